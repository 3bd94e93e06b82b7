"""Tables, CSV files and figures of whatever is done."""

import csv
import io
import os
import pathlib
import string

from paper import drawing, published
from paper.budgets import Budget
from paper.drawing import ACTIONS, Point
from paper.experiments import Curve, Experiment, Row
from paper.summary import Summary, spread, summarize
from paper.work import Workshop

TEMPLATE = pathlib.Path(__file__).with_name("paper.md.in")
NOT_RUN = "not run"
FIGURES = ("games", "win", "win_low", "win_high", "tie", "loss", "died", "steps", "depth")
FIGURES += ("variation_length", "ms_per_move", "bombs", "kicks", "kills", "cells_in_20_steps")
FIGURES += tuple(f"share_{action}" for action in ACTIONS)
CELLS = tuple(f"cell_{cell}" for cell in range(121))


def share(value: float | None, digits: int = 3) -> str:
    if value is None:
        return ""
    text = f"{value:.{digits}f}"
    return text[1:] if text.startswith("0.") else text


def with_spread(mean: float, between: float | None, digits: int = 3) -> str:
    return share(mean, digits) + ("" if between is None else f" ± {share(between, digits)}")


def table(head: list[str], lines: list[list[str]]) -> str:
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def write(file: pathlib.Path, text: str) -> None:
    part = file.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, file)


class Report:
    """Of a budget, into `output`/paper.md and `output`/paper/."""

    def __init__(
        self,
        workshop: Workshop,
        budget: Budget,
        seeds: int,
        found: dict[str, Experiment],
        output: pathlib.Path,
    ):
        self.workshop = workshop
        self.budget = budget
        self.seeds = seeds
        self.experiments = found
        self.output = output
        self.folder = output / "paper"

    def has_data(self, experiment: Experiment) -> bool:
        return any(self.workshop.played(cell) for cell in experiment.cells) or any(
            self.workshop.iterations(run) for curve in experiment.curves for run in curve.runs
        )

    def write(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        texts = {
            "budget": self.budget_text(),
            "fig3_published": published.FIGURE_3,
            "simulations": f"{self.budget.training_simulations}",
            "most": f"{self.budget.most_simulations}",
        }
        for name, experiment in self.experiments.items():
            summaries = {row: summarize(row, self.workshop) for row in experiment.rows}
            texts[name] = getattr(self, f"text_{name}")(experiment, summaries)
            if self.has_data(experiment):
                self.write_csv(experiment)
        template = string.Template(TEMPLATE.read_text(encoding="utf-8"))
        write(self.output / "paper.md", template.substitute(texts))

    def budget_text(self) -> str:
        budget = self.budget
        return (
            f"`--budget {budget.name} --seeds {self.seeds}` ({budget.purpose}): the network "
            f"`{budget.network}`. SL: {budget.sl_decisions:,} decisions, passes: "
            f"{budget.sl_epochs}. RL and SRL: {budget.iterations} iterations of "
            f"{budget.decisions:,} decisions, {budget.training_simulations} simulations a move. "
            f"{budget.games} games a model and row, {budget.official_games} in table 3."
        )

    # Each experiment's table, and its figure where there is something to draw.

    def text_fig2(self, experiment: Experiment, summaries: dict[Row, Summary | None]) -> str:
        series: dict[str, list[Point]] = {}
        known: dict[str, list[tuple[float, float]]] = {}
        lines = []
        for row, summary in summaries.items():
            lines.append([row.series, row.label, *self.rates(row, summary)])
            simulations = row.cells[0].simulations
            if summary:
                point = Point(simulations, summary.mean("win"), summary.spread("win"))
                series.setdefault(row.series, []).append(point)
            if row.known:
                known.setdefault(row.series, []).append((simulations, row.known.win))
        if series:
            drawing.bands(self.folder / "fig2.svg", "simulations per move", series, known)
        head = ["search, network", "simulations", *self.rate_heads()]
        return self.shown("fig2", bool(series)) + table(head, lines)

    def text_table2(self, _: Experiment, summaries: dict[Row, Summary | None]) -> str:
        lines = []
        for row, summary in summaries.items():
            figures = ("depth", "variation_length", "ms_per_move", "steps")
            measured = [f"{summary.mean(name):.1f}" if summary else "" for name in figures]
            lines.append([row.label, *self.rates(row, summary), " / ".join(measured), row.details])
        head = ["network, search, models of opponents", *self.rate_heads()]
        head += ["depth / variation / ms / steps", "published depth / ms / steps"]
        return table(head, lines)

    def text_table3(self, _: Experiment, summaries: dict[Row, Summary | None]) -> str:
        lines = [
            [row.label, str(row.cells[0].simulations), *self.rates(row, summary)]
            for row, summary in summaries.items()
        ]
        head = ["network, search, models of opponents", "simulations", *self.rate_heads()]
        return table(head, lines)

    def text_beyond(self, _: Experiment, summaries: dict[Row, Summary | None]) -> str:
        lines = [[row.label, *self.rates(row, summary)] for row, summary in summaries.items()]
        return table(["network, search", *self.rate_heads()], lines)

    def text_fig3(self, experiment: Experiment, _: dict[Row, Summary | None]) -> str:
        points = {curve.label: self.points(curve) for curve in experiment.curves}
        drawn = {label: found for label, found in points.items() if found}
        if drawn:
            drawing.bands(self.folder / "fig3.svg", "iteration", drawn, {})
        last = self.budget.iterations
        asked = sorted({1, self.budget.best + 1, last} - {last + 1})
        lines = []
        for label, found in points.items():
            by_iteration = {point.at: with_spread(point.mean, point.spread) for point in found}
            lines.append([label, *(by_iteration.get(iteration, NOT_RUN) for iteration in asked)])
        head = ["search, network", *(f"iteration {iteration}" for iteration in asked)]
        return self.shown("fig3", bool(drawn)) + table(head, lines)

    def text_fig4(self, _: Experiment, summaries: dict[Row, Summary | None]) -> str:
        lines = []
        shares = {}
        for row, summary in summaries.items():
            values = [summary.mean(f"share_{action}") for action in ACTIONS] if summary else []
            if summary:
                label = row.label if row.label != "SL" else "SRL, iteration 0 (SL)"
                shares[label] = values
            texts = [share(value) for value in values] or [NOT_RUN] + [""] * (len(ACTIONS) - 1)
            lines.append([row.label, *texts, self.win(summary)])
        if shares:
            drawing.action_shares(self.folder / "fig4.svg", shares)
        return self.shown("fig4", bool(shares)) + table(["network", *ACTIONS, "wins"], lines)

    def text_fig5(self, _: Experiment, summaries: dict[Row, Summary | None]) -> str:
        figures = ("steps", "cells_in_20_steps", "share_stop", "kills")
        names = ["steps a game", "unique positions in 20 steps", "share of stop", "kills a game"]
        charts: dict[str, dict[str, Point]] = {name: {} for name in names[:2]}
        maps = {}
        lines = []
        for row, summary in summaries.items():
            if not summary:
                lines.append([row.label, NOT_RUN, "", "", ""])
                continue
            maps[row.label] = summary.heat_map()
            for chart, name in zip(charts.values(), figures):
                chart[row.label] = Point(0, summary.mean(name), summary.spread(name))
            values = ((summary.mean(name), summary.spread(name)) for name in figures)
            lines.append([row.label, *(with_spread(*value, digits=2) for value in values)])
        if maps:
            drawing.boards(self.folder / "fig5-boards.svg", maps)
            drawing.bars(self.folder / "fig5.svg", charts)
        pictures = self.shown("fig5-boards", bool(maps)) + self.shown("fig5", bool(maps))
        return pictures + table(["network", *names], lines)

    # Parts of these.

    def shown(self, name: str, drawn: bool) -> str:
        return f"![{name}](paper/{name}.svg)\n\n" if drawn else ""

    def rate_heads(self) -> list[str]:
        return ["wins ± sd [95 % of all games]", "ties", "published wins ± sd", "ties"]

    def win(self, summary: Summary | None) -> str:
        if not summary:
            return NOT_RUN
        low, high = summary.interval("win")
        text = with_spread(summary.mean("win"), summary.spread("win"))
        text += f" [{share(low)}, {share(high)}]"
        return text + (f", {summary.models} of {self.seeds}" if summary.models < self.seeds else "")

    def rates(self, row: Row, summary: Summary | None) -> list[str]:
        known = row.known
        return [
            self.win(summary),
            share(summary.mean("tie")) if summary else "",
            with_spread(known.win, known.spread) if known else "",
            share(known.tie) if known else "",
        ]

    def points(self, curve: Curve) -> list[Point]:
        """Wins of the games that each iteration trained on."""
        won: dict[int, list[float]] = {}
        for run in curve.runs:
            for line in self.workshop.iterations(run):
                games = sum(int(line[name]) for name in ("wins", "ties", "losses"))
                if games:
                    won.setdefault(int(line["iteration"]), []).append(int(line["wins"]) / games)
        return [
            Point(iteration, sum(values) / len(values), spread(values))
            for iteration, values in sorted(won.items())
        ]

    # CSV.

    def write_csv(self, experiment: Experiment) -> None:
        text = io.StringIO()
        lines = csv.writer(text, lineterminator="\n")
        if experiment.curves:
            self.curve_lines(experiment, lines)
        else:
            self.cell_lines(experiment, lines)
        write(self.folder / f"{experiment.name}.csv", text.getvalue())

    def curve_lines(self, experiment: Experiment, lines) -> None:
        figures = ("iteration", "games", "decisions", "wins", "ties", "losses", "mean_steps")
        figures += tuple(f"share_{action}" for action in ACTIONS)
        lines.writerow(["curve", "run", *figures])
        for curve in experiment.curves:
            for run in curve.runs:
                for line in self.workshop.iterations(run):
                    lines.writerow([curve.label, run.name, *(line[name] for name in figures)])

    def cell_lines(self, experiment: Experiment, lines) -> None:
        board = CELLS if experiment.name == "fig5" else ()
        head = ["row", "series", "model", "tree", "opponents", "simulations", "met"]
        lines.writerow([*head, *FIGURES, *board])
        for row in experiment.rows:
            for cell in row.cells:
                if not self.workshop.played(cell):
                    continue
                result = self.workshop.result(cell)
                what = [row.label, row.series, cell.model.name, cell.tree, cell.opponents]
                values = [result[name] for name in FIGURES]
                moves = [moves for line in result["heat_map"] for moves in line] if board else []
                lines.writerow([*what, cell.simulations, cell.met, *values, *moves])
