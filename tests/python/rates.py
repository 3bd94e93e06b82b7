"""Prints the rates that docs/python.md shows: PYTHONPATH=python python3 tests/python/rates.py"""

import time

import numpy as np

import powderkeg

GAMES = 1024
SECONDS = 3.0
FREE_FOR_ALL = "PommeFFACompetition-v0"


def rate(work, steps):
    """Steps per second of this process's time, after one call that is not counted."""
    work()
    start, calls = time.process_time(), 0
    while (elapsed := time.process_time() - start) < SECONDS:
        work()
        calls += 1
    return calls * steps / elapsed


def batched(policies=None, agents=()):
    """The rate of random actions, with the planes of these agents."""
    games = powderkeg.Games(FREE_FOR_ALL, GAMES, seed=1, policies=policies)
    actions = np.random.default_rng(1).integers(6, size=(50, GAMES, 4), dtype=np.uint8)
    planes = np.empty((GAMES, len(agents), 23, 11, 11), np.float32)

    def work():
        for row in actions:
            games.step(row)
            if agents:
                games.planes(agents, planes)

    return rate(work, len(actions) * GAMES)


def single():
    """The rate of one game among SimpleUnbiased."""
    env = powderkeg.Env(FREE_FOR_ALL)
    env.reset(seed=1)

    def work():
        if env.step(0)[2]:
            env.reset()

    return rate(work, 1)


def main():
    """Prints one line for each row of the table."""
    others = [None] + ["simple_unbiased"] * 3
    for what, value in (("random actions of all four", batched()),
                        ("with the planes of one agent", batched(agents=(0,))),
                        ("with the planes of all four", batched(agents=(0, 1, 2, 3))),
                        ("one among three SimpleUnbiased", batched(others)),
                        ("one game, Env with planes", single())):
        print(f"{what:<32} {value:>12,.0f} steps/s")


if __name__ == "__main__":
    main()
