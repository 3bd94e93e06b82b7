"""deploy/paper: the paper's experiments by name."""

import argparse
import pathlib
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from paper import cost
from paper.budgets import BUDGETS, Budget
from paper.experiments import STEPS, Cell, Experiment, Run, experiments
from paper.failure import Failure
from paper.report import Report
from paper.work import Workshop

ROOT = pathlib.Path(__file__).resolve().parents[2]
DESCRIPTION = """The experiments of the paper (Weil, Czech et al. 2023), each by its name: trains
what it needs, plays the matches, and writes paper.md with the published figures beside ours, a CSV
file and a figure for each. Stop it with Ctrl-C; the same command goes on where it was."""


def seeds_text(text: str) -> int:
    if text.isdecimal() and 1 <= int(text) <= 100:
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}', expected a number from 1 to 100")


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> None:
        self.exit(2, f"paper: {message}; see --help\n")


def parse(words: list[str]) -> argparse.Namespace:
    known = ", ".join(STEPS)
    parser = Parser(prog="deploy/paper", description=DESCRIPTION, allow_abbrev=False)
    parser.add_argument("steps", nargs="+", metavar="STEP", help=f"list, all, or of {known}")
    purposes = "; ".join(f"{budget.name}: {budget.purpose}" for budget in BUDGETS.values())
    parser.add_argument(
        "--budget", choices=list(BUDGETS), default="desk", help=f"{purposes} (default desk)"
    )
    parser.add_argument(
        "--seeds", type=seeds_text, help="models of each kind (default 5; smoke: 2)", metavar="N"
    )
    parser.add_argument(
        "--estimate", action="store_true", help="say how long it takes and how much disk, no more"
    )
    parser.add_argument(
        "--report", action="store_true", help="write tables and figures of what is done, no more"
    )
    parser.add_argument(
        "--output",
        type=pathlib.Path,
        metavar="FOLDER",
        help="for paper.md and paper/ (default docs/results; smoke: runs/paper-smoke)",
    )
    parser.add_argument("--no-build", action="store_true", help="use the programs that are there")
    arguments = parser.parse_args(words)
    for step in arguments.steps:
        if step not in STEPS and step not in ("all", "list"):
            parser.error(f"no step '{step}', expected list, all, or of {known}")
    return arguments


@dataclass(frozen=True)
class Job:
    """A training or a match that is missing."""

    name: str
    carry_out: Callable[[], None]
    seconds: float  # that it takes, estimated


class Plan:
    """What is missing of some experiments."""

    def __init__(self, wanted: list[Experiment], workshop: Workshop, budget: Budget):
        runs = {run.name: run for experiment in wanted for run in experiment.runs}
        cells = {cell.name: cell for experiment in wanted for cell in experiment.cells}
        self.runs: list[Run] = [run for run in runs.values() if not workshop.trained(run)]
        self.cells: list[Cell] = [cell for cell in cells.values() if not workshop.played(cell)]
        self.workshop = workshop
        self.budget = budget

    def jobs(self) -> list[Job]:
        """In their order. Says what they take; throws Failure if the disk cannot hold it."""
        needed = cost.disk_bytes(self.runs, self.cells, self.budget)
        free = cost.require_space(needed, self.workshop)
        speed = cost.simulations_per_s(self.workshop, self.budget)
        jobs = []
        for run in self.runs:
            seconds = cost.of_run(run, self.budget, speed)
            jobs.append(Job(run.name, partial(self.workshop.train, run), seconds))
        for cell in self.cells:
            seconds = cost.of_cell(cell, self.budget, speed)
            jobs.append(Job(cell.name, partial(self.workshop.play, cell), seconds))
        say(
            f"{len(self.runs)} to train and {len(self.cells)} to play: about "
            f"{cost.time(sum(job.seconds for job in jobs))} at {speed:,.0f} simulations/s, and "
            f"{cost.size(needed)} of {cost.size(free)}"
        )
        return jobs


def say(text: str) -> None:
    print(f"paper: {text}", flush=True)


def work(jobs: list[Job]) -> None:
    left = sum(job.seconds for job in jobs)
    for number, job in enumerate(jobs, start=1):
        begun = time.monotonic()
        job.carry_out()
        left -= job.seconds
        took = cost.time(time.monotonic() - begun)
        say(f"{number} of {len(jobs)}: {job.name}, {took}; left about {cost.time(max(0, left))}")


def list_steps(found: dict[str, Experiment], workshop: Workshop) -> None:
    for name, experiment in found.items():
        runs = sum(workshop.trained(run) for run in experiment.runs)
        cells = sum(workshop.played(cell) for cell in experiment.cells)
        done = f"{runs} of {len(experiment.runs)} trainings"
        if experiment.cells:
            done += f", {cells} of {len(experiment.cells)} matches"
        print(f"{name:8} {experiment.title}: {done} done")


def run(arguments: argparse.Namespace) -> None:
    budget = BUDGETS[arguments.budget]
    seeds = arguments.seeds or budget.seeds
    workshop = Workshop(ROOT, budget.name)
    found = experiments(budget, seeds)
    if "list" in arguments.steps:
        list_steps(found, workshop)
        return
    names = list(STEPS) if "all" in arguments.steps else arguments.steps
    wanted = [found[name] for name in names]
    if not arguments.report:
        workshop.claim()
        if not arguments.no_build:
            programs = ["learner", "actor", "arena"]
            subprocess.run([ROOT / "deploy/build", "release", *programs], check=True)
        plan = Plan(wanted, workshop, budget)
        jobs = plan.jobs() if plan.runs or plan.cells else []
        if arguments.estimate:
            return
        work(jobs)
    output = workshop.folder if budget.name == "smoke" else ROOT / "docs" / "results"
    report = Report(workshop, budget, seeds, found, arguments.output or output)
    if not any(report.has_data(experiment) for experiment in wanted):
        steps = " ".join(arguments.steps)
        raise Failure(
            f"{steps} has no results to draw; deploy/paper {steps} --budget {budget.name} "
            "makes them"
        )
    report.write()
    say(workshop.shown(report.output / "paper.md"))


def interrupted(*_) -> None:
    raise KeyboardInterrupt


def main() -> int:
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupted)
    try:
        run(parse(sys.argv[1:]))
    except KeyboardInterrupt:
        print("\npaper: stopped; the same command goes on from here", file=sys.stderr)
        return 130
    except subprocess.CalledProcessError:
        return 1  # it has said why
    except (Failure, OSError) as error:
        print(f"paper: {error}", file=sys.stderr)
        return 1
    return 0


sys.exit(main())
