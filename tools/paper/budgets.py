"""How much of the paper is played: its own numbers, a night on two cores, or minutes."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """Sizes of trainings and matches; `moments` and `best` are numbers of iterations."""

    name: str
    purpose: str
    network: str
    seeds: int  # models of each kind, unless --seeds says otherwise
    sl_decisions: int  # of demonstrations
    sl_epochs: int
    iterations: int
    decisions: int  # an iteration
    training_simulations: int  # a move
    simulations: tuple[int, ...]  # a move, of figure 2; 0 is the network alone
    official_simulations: tuple[int, int]  # of table 3: with SimpleCpp, with RawNet as models
    moments: tuple[int, ...]  # iterations that figure 4 looks at
    best: int  # the iteration whose weights the tables measure
    games: int  # of each model in each row
    official_games: int  # the same, of table 3

    @property
    def most_simulations(self) -> int:
        return self.simulations[-1]


BUDGETS = {
    budget.name: budget
    for budget in (
        Budget(
            name="published",
            purpose="the paper's numbers and network",
            network="paper",
            seeds=5,
            sl_decisions=1_000_000,
            sl_epochs=5,
            iterations=50,
            decisions=100_000,
            training_simulations=250,
            simulations=(0, 50, 100, 250, 500, 1000),
            official_simulations=(1000, 250),
            moments=(0, 15, 25, 50),
            best=15,
            games=1000,
            official_games=100,
        ),
        Budget(
            name="desk",
            purpose="a night on two cores, with the network `small`",
            network="small",
            seeds=5,
            sl_decisions=500_000,
            sl_epochs=5,
            iterations=50,
            decisions=5_000,
            training_simulations=100,
            simulations=(0, 50, 100, 250),
            official_simulations=(250, 100),
            moments=(0, 15, 25, 50),
            best=15,
            games=200,
            official_games=100,
        ),
        Budget(
            name="smoke",
            purpose="minutes: every step, no meaning in its figures",
            network="small",
            seeds=2,
            sl_decisions=1_000,
            sl_epochs=1,
            iterations=2,
            decisions=200,
            training_simulations=4,
            simulations=(0, 2, 4),
            official_simulations=(4, 2),
            moments=(0, 1, 2),
            best=1,
            games=2,
            official_games=2,
        ),
    )
}
