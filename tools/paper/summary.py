"""What the models of a row did together."""

import math
import statistics

from paper.experiments import Row
from paper.work import Workshop


def wilson(count: float, games: int) -> tuple[float, float]:
    """The 95 % interval of a share."""
    z = 1.959964
    share = count / games
    middle = (share + z * z / (2 * games)) / (1 + z * z / games)
    half = z * math.sqrt(share * (1 - share) / games + z * z / (4 * games * games))
    half /= 1 + z * z / games
    return max(0.0, middle - half), min(1.0, middle + half)


def spread(values: list[float]) -> float | None:
    """The standard deviation between models; None where there is one."""
    return statistics.stdev(values) if len(values) > 1 else None


class Summary:
    """Of the results of one model at least, by the names of arena's figures."""

    def __init__(self, results: list[dict]):
        self.results = results
        self.models = len(results)
        self.games = sum(result["games"] for result in results)

    def values(self, figure: str) -> list[float]:
        return [result[figure] or 0.0 for result in self.results]

    def mean(self, figure: str) -> float:
        return statistics.fmean(self.values(figure))

    def spread(self, figure: str) -> float | None:
        return spread(self.values(figure))

    def interval(self, figure: str) -> tuple[float, float]:
        """95 %, of the games of all models."""
        count = sum(result[figure] * result["games"] for result in self.results)
        return wilson(count, self.games)

    def heat_map(self) -> list[list[float]]:
        """Shares of the moves made on each cell, in percent."""
        maps = [result["heat_map"] for result in self.results]
        moves = sum(sum(map(sum, each)) for each in maps) or 1
        return [[100 * sum(cells) / moves for cells in zip(*rows)] for rows in zip(*maps)]


def summarize(row: Row, workshop: Workshop) -> Summary | None:
    """None where no model was played."""
    results = [workshop.result(cell) for cell in row.cells if workshop.played(cell)]
    return Summary(results) if results else None
