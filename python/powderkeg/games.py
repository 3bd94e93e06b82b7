"""Thousands of games at once, on numpy arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np

from . import _checks, _native

ENVIRONMENT_IDS: tuple[str, ...] = tuple(_native.ENVIRONMENT_IDS)
"""The official environments, by their names."""

POLICIES = ("idle", "random", "harmless", "simple_unbiased", "official_simple")
"""The rule-based agents, by their names."""

AGENTS = 4
ACTIONS = 6
"""0 stop, 1 up, 2 down, 3 left, 4 right, 5 bomb."""

Policies = Union[None, str, Sequence[Optional[str]]]
"""One of POLICIES or None (moved by the caller) for all seats, or one of these per seat."""


class Rules(NamedTuple):
    """What an official environment stands for."""

    game_type: int  # 1 free-for-all, 2 team, 3 team with radio, 4 one against one
    board_size: int  # rows and columns
    max_steps: int  # a game not decided by then is a tie
    blast_strength_cap: int
    view_radius: int  # cells seen to each side; 0: the whole board
    collapse_steps: list[int]  # steps until ring k is walls; 0: never
    agents: int  # that play


def rules(environment: str) -> Rules:
    """The rules of one of ENVIRONMENT_IDS; ValueError for any other name."""
    return Rules(**_native.rules(_checks.text("environment", environment)))


class Step(NamedTuple):
    """What a step led to, also where a game is over and another has begun since."""

    rewards: np.ndarray  # float32 [games, 4], official: -1, 0 or +1
    done: np.ndarray  # bool [games]
    winners: np.ndarray  # uint8 [games], bit i: agent i; 0 of a tie and while nobody has won
    steps: np.ndarray  # uint16 [games], played


class Games:
    """Games of one environment that are stepped together, without Python's lock.

    A game that is over begins anew in the same call (``auto_reset``): ``step`` tells of the old
    game, everything else of the new one. With ``to_the_end=False`` a game is over as soon as no
    agent of the caller's, nor a mate of one, lives. Without ``auto_reset`` a finished game stays as
    it is: done, with rewards of 0.

    Equal arguments and actions give equal games on every machine. Any thread may call; calls of one
    object wait for each other.
    """

    def __init__(self, environment: str = "PommeFFACompetition-v0", games: int = 1024, *,
                 seed: int = 0, policies: Policies = None, to_the_end: bool = True,
                 auto_reset: bool = True) -> None:
        self.rules = rules(environment)
        self.environment = environment
        self.policies = policies_of(policies)
        self._games = _native.Games(environment, _checks.whole("games", games),
                                    _checks.seed(seed), list(self.policies), bool(to_the_end),
                                    bool(auto_reset))

    def __len__(self) -> int:
        return len(self._games)

    def reset(self, seed: int | None = None) -> None:
        """Begins all games anew: those of the seed, or without one the next of the present one."""
        self._games.reset(None if seed is None else _checks.seed(seed))

    def step(self, actions: Any, messages: Any = None) -> Step:
        """Plays one step of every game.

        actions: integers 0..5 [games, 4]; those of policies and of the dead are ignored. uint8 is
        taken as it is. messages: two words 0..7 per agent [games, 4, 2], in radio games; None:
        silence.
        """
        words = None if messages is None else _checks.array("messages", messages)
        return Step(*self._games.step(_checks.array("actions", actions), words))

    def planes(self, agents: Sequence[int] = (0, 1, 2, 3), out: np.ndarray | None = None
               ) -> np.ndarray:
        """What our networks see: float32 [games, agents, 23, 11, 11], in -1..1 (planes.h).

        `out`, an array of this shape and type, is filled and returned; without it a new one is.
        """
        return self._games.planes(_agents(agents), out)

    def observations(self, agents: Sequence[int] = (0, 1, 2, 3)) -> dict[str, np.ndarray]:
        """The official observations as arrays [games, agents, ...]; fog is 5 in the board.

        uint8 [11, 11]: board, bomb_blast_strength, bomb_life, bomb_moving_direction, flame_life;
        bool [4] alive; uint8 [2] position (row, column), message; uint8 ammo, blast_strength; bool
        can_kick; uint16 step_count. Smaller boards fill the top left part; the rest is rigid.
        """
        return self._games.observations(_agents(agents))

    def alive(self) -> np.ndarray:
        """bool [games, 4]."""
        return self._games.alive()

    def legal_actions(self) -> np.ndarray:
        """bool [games, 4, 6]: actions that have an effect now; of the dead stop alone."""
        return self._games.legal_actions()

    def last_actions(self) -> np.ndarray:
        """uint8 [games, 4]: what everybody did in the last step, policies too; 0 of the dead."""
        return self._games.last_actions()

    def text(self, game: int) -> str:
        """A game as text: the board, then its agents, bombs, flames and hidden items."""
        return self._games.text(_checks.whole("game", game))


def policies_of(policies: Policies) -> tuple[str | None, ...]:
    """One entry per seat."""
    names = (policies,) * AGENTS if policies is None or isinstance(policies, str) else policies
    names = tuple(names)
    if len(names) != AGENTS:
        raise ValueError(f"policies has {len(names)} entries, expected {AGENTS}")
    for name in names:
        _checks.one_of("policy", name, (None, *POLICIES))
    return names


def _agents(values: Any) -> list[int]:
    return [_checks.whole("agent", value, 0, AGENTS - 1) for value in values]
