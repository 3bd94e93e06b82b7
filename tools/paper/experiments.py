"""What each step of the paper needs: runs that train, matches that measure."""

from dataclasses import dataclass

from paper import published
from paper.budgets import Budget

TREES = ("one_player", "two_player")
SHORT = {
    "one_player": "SP",
    "two_player": "TP",
    "simple_unbiased": "SimpleCpp",
    "raw_network": "RawNet",
}


@dataclass(frozen=True)
class Run:
    """One training: runs/NAME, made by deploy/run-local."""

    name: str
    config: str
    settings: tuple[str, ...]
    iterations: int
    decisions: int  # an iteration
    simulations: int  # a move; 0: nothing is searched
    samples: int  # trained on, in all
    begins_with: "Run | None" = None

    def weights(self, iteration: int) -> str:
        """After so many iterations, from the repository's root."""
        return f"runs/{self.name}/weights/version-{iteration + 1:06}.weights"


@dataclass(frozen=True)
class Model:
    """Weights: what they learned from (SL, RL, SRL, untrained) and for how long."""

    kind: str
    seed: int
    budget: Budget
    iteration: int = 0

    @property
    def name(self) -> str:
        iteration = f"-{self.iteration}" if self.kind in ("RL", "SRL") else ""
        return f"{self.kind.lower()}{iteration}-seed-{self.seed}"

    @property
    def run(self) -> Run | None:
        if self.kind == "untrained":
            return None
        if self.kind == "SL":
            return demonstrations(self.budget, self.seed)
        return reinforcement(self.budget, self.kind, "one_player", self.seed)

    @property
    def spec(self) -> str:
        """As agents' model=... has it."""
        if self.run is None:
            return f"untrained:{self.budget.network}:{self.seed}"
        return self.run.weights(1 if self.kind == "SL" else self.iteration)


@dataclass(frozen=True)
class Cell:
    """A match of one model: one file of results."""

    model: Model
    simulations: int  # a move; 0: the network alone
    tree: str
    opponents: str  # models of the opponents in the search
    met: str  # who the opponents are
    games: int
    preset: str = "paper"

    @property
    def name(self) -> str:
        search = f"{self.tree}-{self.opponents}-{self.simulations}-{self.preset}"
        return "-".join(
            (self.model.name, search if self.simulations else "raw", self.met, str(self.games))
        )

    @property
    def agent(self) -> str:
        if self.simulations == 0:
            return f"raw:model={self.model.spec}"
        return (
            f"search:preset={self.preset},tree={self.tree},opponents={self.opponents},"
            f"simulations={self.simulations},model={self.model.spec}"
        )


@dataclass(frozen=True)
class Row:
    """One row of a table or point of a figure: the same match of every model."""

    label: str
    series: str
    cells: tuple[Cell, ...]
    known: published.Rates | None = None  # as published
    details: str = ""  # what else was published


@dataclass(frozen=True)
class Curve:
    """One curve of figure 3: runs that differ in their seeds."""

    label: str
    runs: tuple[Run, ...]


@dataclass(frozen=True)
class Experiment:
    name: str
    title: str
    rows: tuple[Row, ...] = ()
    curves: tuple[Curve, ...] = ()

    @property
    def cells(self) -> list[Cell]:
        return [cell for row in self.rows for cell in row.cells]

    @property
    def runs(self) -> list[Run]:
        """Each once, those that others begin with first."""
        wanted = [cell.model.run for cell in self.cells if cell.model.run]
        wanted += [run for curve in self.curves for run in curve.runs]
        found: dict[Run, None] = {}
        for run in wanted:
            if run.begins_with:
                found[run.begins_with] = None
            found[run] = None
        return list(found)


def demonstrations(budget: Budget, seed: int) -> Run:
    return Run(
        name=f"paper-{budget.name}-sl-{seed}",
        config="deploy/sl.textproto",
        settings=(
            f"training.network={budget.network}",
            f"training.decisions_per_iteration={budget.sl_decisions}",
            f"training.epochs={budget.sl_epochs}",
            "training.initialisation=pytorch",
            "training.batch_size=128",
            "training.learning_rate=0.001",
            f"self_play.seed={seed}",
        ),
        iterations=1,
        decisions=budget.sl_decisions,
        simulations=0,
        samples=budget.sl_decisions * budget.sl_epochs,
    )


def reinforcement(budget: Budget, kind: str, tree: str, seed: int) -> Run:
    window, epochs = 4, 2  # of deploy/paper.textproto
    data_sets = sum(min(window, i + 1) for i in range(budget.iterations))
    return Run(
        name=f"paper-{budget.name}-{kind.lower()}-{SHORT[tree].lower()}-{seed}",
        config="deploy/paper.textproto",
        settings=(
            f"training.network={budget.network}",
            f"training.iterations={budget.iterations}",
            f"training.decisions_per_iteration={budget.decisions}",
            f"self_play.search.simulations={budget.training_simulations}",
            f"self_play.search.tree={tree}",
            f"self_play.seed={seed}",
        ),
        iterations=budget.iterations,
        decisions=budget.decisions,
        simulations=budget.training_simulations,
        samples=data_sets * epochs * budget.decisions,
        begins_with=demonstrations(budget, seed) if kind == "SRL" else None,
    )


def models(budget: Budget, seeds: int, kind: str, iteration: int) -> list[Model]:
    return [Model(kind, seed, budget, iteration) for seed in range(1, seeds + 1)]


def matches(
    found: list[Model],
    simulations: int,
    tree: str = "one_player",
    opponents: str = "simple_unbiased",
    met: str = "simple_unbiased",
    preset: str = "paper",
) -> tuple[Cell, ...]:
    budget = found[0].budget
    games = budget.official_games if met == "official_simple" else budget.games
    return tuple(Cell(model, simulations, tree, opponents, met, games, preset) for model in found)


def figure_2(budget: Budget, seeds: int) -> Experiment:
    rows = []
    for (kind, tree), points in published.FIGURE_2.items():
        found = models(budget, seeds, kind, 0)
        for simulations in budget.simulations:
            rows.append(
                Row(
                    label=f"{simulations}" if simulations else "0 (network alone)",
                    series=f"{SHORT[tree]}, {kind}",
                    cells=matches(found, simulations, tree if simulations else "one_player"),
                    known=points.get(simulations),
                )
            )
    return Experiment("fig2", "Wins over simulations", tuple(rows))


def label_of(kind: str, tree: str, opponents: str) -> str:
    return f"{kind}, {SHORT[tree]}, {SHORT[opponents]}"


def table_2(budget: Budget, seeds: int) -> Experiment:
    rows = []
    for (kind, tree, opponents), (rates, depth, ms, steps) in published.TABLE_2.items():
        found = models(budget, seeds, kind, budget.best)
        rows.append(
            Row(
                label=label_of(kind, tree, opponents),
                series=kind,
                cells=matches(found, budget.most_simulations, tree, opponents),
                known=rates,
                details=f"{depth} / {ms} / {steps}",
            )
        )
    return Experiment("table2", "Models of opponents, most simulations", tuple(rows))


def table_3(budget: Budget, seeds: int) -> Experiment:
    rows = []
    for (kind, tree, opponents), rates in published.TABLE_3.items():
        found = models(budget, seeds, kind, budget.best)
        simulations = budget.official_simulations[opponents == "raw_network"]
        rows.append(
            Row(
                label=label_of(kind, tree, opponents),
                series=kind,
                cells=matches(found, simulations, tree, opponents, met="official_simple"),
                known=rates,
            )
        )
    return Experiment("table3", "Against three official SimpleAgents", tuple(rows))


def figure_3(budget: Budget, seeds: int) -> Experiment:
    curves = []
    for tree in TREES:
        for kind in ("RL", "SRL"):
            runs = (reinforcement(budget, kind, tree, seed) for seed in range(1, seeds + 1))
            curves.append(Curve(f"{SHORT[tree]}, {kind}", tuple(runs)))
    return Experiment("fig3", "Wins over iterations", curves=tuple(curves))


def learned(budget: Budget, seeds: int, kind: str, moment: int) -> Row:
    """What agents of this kind do after so many iterations; SRL begins with SL."""
    begun = kind == "SRL" and moment == 0
    return Row(
        label="SL" if begun else f"{kind}, iteration {moment}",
        series=kind,
        cells=matches(
            models(budget, seeds, "SL" if begun else kind, moment), budget.training_simulations
        ),
    )


def figure_4(budget: Budget, seeds: int) -> Experiment:
    rows = [
        learned(budget, seeds, kind, moment) for kind in ("RL", "SRL") for moment in budget.moments
    ]
    return Experiment("fig4", "Shares of actions over iterations", tuple(rows))


def figure_5(budget: Budget, seeds: int) -> Experiment:
    moments = [("SRL", 0)]
    for kind in ("SRL", "RL"):
        moments += [(kind, budget.best), (kind, budget.iterations)]
    rows = [learned(budget, seeds, kind, moment) for kind, moment in moments]
    return Experiment("fig5", "Where agents are, and how much they move", tuple(rows))


def beyond(budget: Budget, seeds: int) -> Experiment:
    rows = []
    for kind, tree, opponents in published.TABLE_2:
        if opponents != "simple_unbiased":
            continue
        found = models(budget, seeds, kind, budget.best)
        key = (kind, tree, "simple_unbiased")
        for met, rates in (
            ("simple_unbiased", published.TABLE_2[key][0]),
            ("official_simple", published.TABLE_3[key]),
        ):
            rows.append(
                Row(
                    label=f"{kind}, {SHORT[tree]}, against {met}",
                    series=met,
                    cells=matches(
                        found, budget.most_simulations, tree, met, met=met, preset="default"
                    ),
                    known=rates,
                )
            )
    return Experiment("beyond", "The same models with this program's own search", tuple(rows))


STEPS = {
    "fig2": figure_2,
    "table2": table_2,
    "table3": table_3,
    "fig3": figure_3,
    "fig4": figure_4,
    "fig5": figure_5,
    "beyond": beyond,
}


def experiments(budget: Budget, seeds: int) -> dict[str, Experiment]:
    return {name: make(budget, seeds) for name, make in STEPS.items()}
