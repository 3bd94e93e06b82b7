"""The figures of Weil, Czech, Meuser, Kersting: Know your Enemy, ALA 2023."""

from typing import NamedTuple


class Rates(NamedTuple):
    """Shares of the games; `spread` is the standard deviation between models."""

    win: float
    spread: float | None = None
    tie: float | None = None


# By what the network learned from and the tree: wins against three SimpleUnbiased by simulations.
FIGURE_2 = {
    ("SL", "one_player"): {
        0: Rates(0.386, 0.013, 0.105),
        50: Rates(0.614, 0.029, 0.153),
        100: Rates(0.680, 0.025, 0.132),
        250: Rates(0.768, 0.017, 0.095),
        500: Rates(0.791, 0.017, 0.072),
        1000: Rates(0.788, 0.015, 0.064),
    },
    ("SL", "two_player"): {
        0: Rates(0.377, 0.020, 0.103),
        50: Rates(0.494, 0.021, 0.197),
        100: Rates(0.615, 0.026, 0.178),
        250: Rates(0.796, 0.017, 0.118),
        500: Rates(0.878, 0.013, 0.075),
        1000: Rates(0.901, 0.017, 0.067),
    },
    ("untrained", "one_player"): {
        0: Rates(0.100, 0.056),
        50: Rates(0.393, 0.008),
        100: Rates(0.438, 0.027),
        250: Rates(0.490, 0.036),
        500: Rates(0.555, 0.048),
        1000: Rates(0.575, 0.049),
    },
    ("untrained", "two_player"): {
        0: Rates(0.095, 0.053),
        50: Rates(0.131, 0.007),
        100: Rates(0.162, 0.011),
        250: Rates(0.167, 0.006),
        500: Rates(0.209, 0.014),
        1000: Rates(0.246, 0.014),
    },
}

# Table 2, 1,000 simulations. Network, tree, models of the opponents: rates, depth, ms, steps.
TABLE_2 = {
    ("SL", "one_player", "simple_unbiased"): (Rates(0.78, 0.03, 0.07), 17.9, 35, 189),
    ("SL", "one_player", "raw_network"): (Rates(0.76, 0.03, 0.10), 21.5, 267, 191),
    ("SL", "two_player", "simple_unbiased"): (Rates(0.91, 0.01, 0.06), 11.6, 37, 246),
    ("SL", "two_player", "raw_network"): (Rates(0.92, 0.01, 0.06), 12.1, 165, 255),
    ("SRL", "one_player", "simple_unbiased"): (Rates(0.94, 0.01, 0.02), 21.4, 37, 275),
    ("SRL", "one_player", "raw_network"): (Rates(0.90, 0.01, 0.04), 25.5, 316, 288),
    ("RL", "one_player", "simple_unbiased"): (Rates(0.82, 0.01, 0.07), 22.0, 36, 332),
    ("RL", "one_player", "raw_network"): (Rates(0.71, 0.03, 0.08), 28.3, 309, 317),
}

# The same against three official SimpleAgents.
TABLE_3 = {
    ("SL", "one_player", "simple_unbiased"): Rates(0.78, 0.04, 0.12),
    ("SL", "one_player", "raw_network"): Rates(0.67, 0.06, 0.25),
    ("SL", "two_player", "simple_unbiased"): Rates(0.66, 0.05, 0.32),
    ("SL", "two_player", "raw_network"): Rates(0.61, 0.06, 0.34),
    ("SRL", "one_player", "simple_unbiased"): Rates(0.65, 0.09, 0.30),
    ("SRL", "one_player", "raw_network"): Rates(0.63, 0.05, 0.32),
    ("RL", "one_player", "simple_unbiased"): Rates(0.74, 0.03, 0.22),
    ("RL", "one_player", "raw_network"): Rates(0.72, 0.04, 0.23),
}

# What the text says of the curves, 250 simulations.
FIGURE_3 = "one-player SRL goes from about .80 to .90, RL is best near iteration 15"
