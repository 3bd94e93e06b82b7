"""How long a step takes here, and how much disk: estimates from a short match."""

import json
import shutil

from paper.budgets import Budget
from paper.experiments import Cell, Run
from paper.failure import Failure
from paper.work import Workshop

MOVES = 200  # of an agent in a game
# Against a search of one tree whose models are scripts, which is 1.
TWO_PLAYER = 1.3
RAW_NETWORK = {"small": 2.0, "paper": 6.0}  # a network asked for every opponent
# Samples trained in the time of a simulation on all cores. The learner has one.
TRAINING = {"small": 12.0, "paper": 10.0}
START_S = 1.0  # of a program
ITERATION_S = 1.0  # of a run, besides playing and training
# Bytes.
WEIGHTS = {"small": 220_000, "paper": 1_400_000}
CHECKPOINTS = 12  # times the weights: three, with the optimizer's moments
DECISION = 40
CELL = 8_000
RESERVE = 500_000_000  # that stays free


def simulations_per_s(workshop: Workshop, budget: Budget) -> float:
    """Of a few games of an untrained network, now."""
    part = workshop.folder / "speed.part"
    agent = f"search:preset=paper,simulations=50,model=untrained:{budget.network}:1"
    command = ["build/release/bin/arena", "--agent", agent, "--games", "4", "--json", str(part)]
    workshop.call("speed", command)
    speed = json.loads(part.read_text(encoding="utf-8"))["contenders"][0]["simulations_per_s"]
    part.unlink()
    return speed


def of_run(run: Run, budget: Budget, speed: float) -> float:
    """Seconds."""
    played = run.iterations * run.decisions * run.simulations
    if any(setting.endswith("two_player") for setting in run.settings):
        played *= TWO_PLAYER
    work = played + run.samples * TRAINING[budget.network]
    return work / speed + 3 * START_S + run.iterations * ITERATION_S


def of_cell(cell: Cell, budget: Budget, speed: float) -> float:
    """Seconds."""
    factor = TWO_PLAYER if cell.tree == "two_player" else 1
    if cell.opponents == "raw_network":
        factor *= RAW_NETWORK[budget.network]
    return cell.games * MOVES * (1 + cell.simulations * factor) / speed + START_S


def disk_bytes(runs: list[Run], cells: list[Cell], budget: Budget) -> int:
    weights = WEIGHTS[budget.network]
    total = CELL * len(cells)
    for run in runs:
        total += run.iterations * run.decisions * DECISION
        total += weights * (run.iterations + 1 + CHECKPOINTS)
    return total


def require_space(needed: int, workshop: Workshop) -> int:
    """The bytes that are free. Throws Failure if that is too little."""
    free = shutil.disk_usage(workshop.folder).free
    if needed + RESERVE > free:
        raise Failure(
            f"{workshop.shown(workshop.folder.parent)} has {size(free)} free, expected "
            f"{size(needed + RESERVE)}: {size(needed)} for what is missing, and a reserve"
        )
    return free


def size(count: float) -> str:
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"


def time(of_seconds: float) -> str:
    if of_seconds < 90:
        return f"{of_seconds:.0f} s"
    minutes = of_seconds / 60
    if minutes < 90:
        return f"{minutes:.0f} min"
    return f"{minutes / 60:.1f} h" if minutes < 60 * 48 else f"{minutes / 1440:.0f} days"
