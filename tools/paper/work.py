"""Trains and plays what is missing. Whatever is done is a file and stays done: every result is
written beside its place and moved there whole, and runs go on by themselves."""

import csv
import fcntl
import json
import os
import pathlib
import signal
import subprocess

from paper.experiments import Cell, Run
from paper.failure import Failure

BOARDS = 2023  # the seed of the matches: every model plays on the same boards


class Workshop:
    """The repository at `root`, and the results of a budget in runs/paper-BUDGET/. One process."""

    def __init__(self, root: pathlib.Path, budget: str):
        self.root = root
        self.folder = root / "runs" / f"paper-{budget}"

    def claim(self) -> None:
        """Until the process ends; beside another it would do everything twice."""
        for name in ("cells", "log"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        self.lock = open(self.folder / "lock", "a", encoding="utf-8")
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise Failure(f"{self.shown(self.folder)} is in use by another deploy/paper") from None

    def shown(self, path: pathlib.Path) -> str:
        return str(path.relative_to(self.root)) if path.is_relative_to(self.root) else str(path)

    # Runs.

    def iterations(self, run: Run) -> list[dict[str, str]]:
        """The whole lines of its iterations.csv so far."""
        file = self.root / "runs" / run.name / "iterations.csv"
        if not file.exists():
            return []
        with open(file, encoding="utf-8", newline="") as lines:
            return [line for line in csv.DictReader(lines) if None not in line.values()]

    def trained(self, run: Run) -> bool:
        """Whether it is complete. Throws Failure if what it learned is gone."""
        if len(self.iterations(run)) < run.iterations:
            return False
        for iteration in range(run.iterations + 1):
            self.require_weights(run, iteration)
        return True

    def require_weights(self, run: Run, iteration: int) -> None:
        weights = run.weights(iteration)
        if not (self.root / weights).is_file():
            raise Failure(
                f"{weights} is missing, expected the model of a complete run; bring it back, or "
                f"move runs/{run.name} away to train it anew"
            )

    def train(self, run: Run) -> None:
        command = ["deploy/run-local", "--no-build", "--http", "off", "--run", run.name]
        command += ["--config", run.config]
        for setting in run.settings:
            command += ["--set", setting]
        if run.begins_with:
            command += ["--initial-weights", run.begins_with.weights(1)]
        self.call(run.name, command)
        if not self.trained(run):
            raise Failure(f"runs/{run.name} is not complete; see {self.log_of(run.name)}")

    # Matches.

    def file_of(self, cell: Cell) -> pathlib.Path:
        return self.folder / "cells" / f"{cell.name}.json"

    def played(self, cell: Cell) -> bool:
        return self.file_of(cell).exists()

    def result(self, cell: Cell) -> dict:
        """What arena said of it. Requires played. Throws Failure if the file is damaged."""
        file = self.file_of(cell)
        try:
            result = json.loads(file.read_text(encoding="utf-8"))["contenders"][0]
            if result["games"] == cell.games:
                return result
        except (ValueError, LookupError, TypeError):
            pass
        raise Failure(
            f"{self.shown(file)} is damaged, expected arena's result of {cell.games} games; "
            "remove it to play them again"
        )

    def play(self, cell: Cell) -> None:
        if cell.model.run and not (self.root / cell.model.spec).is_file():
            raise Failure(f"no model {cell.model.spec}, expected one of a complete run")
        file = self.file_of(cell)
        part = file.with_suffix(".part")
        command = ["build/release/bin/arena", "--agent", cell.agent, "--opponents", cell.met]
        command += ["--games", str(cell.games), "--seed", str(BOARDS), "--json", str(part)]
        if cell.met == "official_simple":
            command += ["--corners", "official"]
        self.call(cell.name, command)
        with open(part, "rb+") as written:
            os.fsync(written.fileno())
        os.replace(part, file)

    # Programs.

    def log_of(self, name: str) -> str:
        return self.shown(self.folder / "log" / f"{name}.out")

    def call(self, name: str, command: list[str]) -> None:
        """Waits for the command; its output goes to the log. When we are interrupted it is asked to
        end, and waited for; when we are killed it is asked, too."""
        with open(self.root / self.log_of(name), "ab") as log:
            child = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", "--", *command],
                cwd=self.root,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            try:
                code = child.wait()
            except KeyboardInterrupt:
                child.send_signal(signal.SIGTERM)
                child.wait()
                raise
        if code != 0:
            raise Failure(f"{name}: {command[0]} ended with code {code}: {self.last_line(name)}")

    def last_line(self, name: str) -> str:
        lines = (self.root / self.log_of(name)).read_text(errors="replace").split("\n")
        said = [line.strip() for line in lines if line.strip()]
        return said[-1] if said else f"see {self.log_of(name)}"
