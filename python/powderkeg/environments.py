"""One game: PettingZoo's parallel API and Gymnasium's single-agent API.

Either library is used where it is installed (spaces and base classes are its own then) and not
needed otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _checks, spaces
from .games import ACTIONS, AGENTS, Games, Policies, policies_of, rules

try:
    from gymnasium import Env as _EnvBase
except ImportError:
    _EnvBase = object
try:
    from pettingzoo import ParallelEnv as _ParallelBase
except ImportError:
    _ParallelBase = object

RENDER_MODES = ("ansi", "rgb_array")
OBSERVATIONS = ("planes", "arrays")
WORDS = 8
_RADIO = 3
_TEAM_MODES = (2, _RADIO)
_BOARDS = ("board", "bomb_blast_strength", "bomb_life", "bomb_moving_direction", "flame_life")
_PIXELS = 24  # a cell's side
_COLORS = {
    ".": (232, 226, 208), "#": (70, 70, 78), "+": (150, 105, 60), "o": (20, 20, 20),
    "*": (240, 120, 30), "b": (110, 110, 200), "r": (200, 90, 160), "k": (90, 170, 170),
    "0": (200, 40, 40), "1": (40, 140, 60), "2": (40, 90, 200), "3": (220, 180, 40),
}


class _Game:
    """One game and what its agents see of it."""

    def __init__(self, environment: str, policies: Policies, observation: str,
                 render_mode: str | None) -> None:
        _checks.one_of("observation", observation, OBSERVATIONS)
        _checks.one_of("render_mode", render_mode, (None, *RENDER_MODES))
        self.games = Games(environment, 1, policies=policies, to_the_end=False, auto_reset=False)
        self.rules = self.games.rules
        self.observation = observation
        self.render_mode = render_mode
        self.running = False
        self.closed = False

    def observation_space(self) -> spaces.Space:
        if self.observation == "planes":
            return spaces.Box(-1.0, 1.0, (23, 11, 11), np.float32)
        size = self.rules.board_size
        limits = {"board": 13, "bomb_blast_strength": 10, "bomb_life": 9,
                  "bomb_moving_direction": 4, "flame_life": 3}
        boards = {key: spaces.Box(0, high, (size, size), np.uint8) for key, high in limits.items()}
        return spaces.Dict({
            "alive": spaces.Box(0, 1, (AGENTS,), np.uint8),
            **boards,
            "position": spaces.Box(0, size - 1, (2,), np.uint8),
            "blast_strength": spaces.Box(1, 10, (1,), np.uint8),
            "can_kick": spaces.Box(0, 1, (1,), np.uint8),
            "ammo": spaces.Box(0, 10, (1,), np.uint8),
            "step_count": spaces.Box(0, self.rules.max_steps, (1,), np.uint16),
            "message": spaces.Box(0, WORDS - 1, (2,), np.uint8),
        })

    def action_space(self) -> spaces.Space:
        if self.rules.game_type == _RADIO:
            return spaces.MultiDiscrete([ACTIONS, WORDS, WORDS])
        return spaces.Discrete(ACTIONS)

    def begin(self, seed: int, options: Mapping[str, Any] | None) -> None:
        self.require_open()
        if options:
            raise ValueError(f"options has the key {next(iter(options))!r}, expected none")
        self.games.reset(seed)
        self.running = True

    def require_open(self) -> None:
        if self.closed:
            raise RuntimeError("the environment is closed")

    def require_running(self) -> None:
        self.require_open()
        if not self.running:
            raise RuntimeError("no game is running, call reset first")

    def observe(self, agent: int) -> Any:
        if self.observation == "planes":
            return self.games.planes((agent,))[0, 0]
        seen = self.seen(agent)
        for key in ("alive", "can_kick"):
            seen[key] = seen[key].astype(np.uint8)
        return {key: np.atleast_1d(value) for key, value in seen.items()}

    def seen(self, agent: int) -> dict[str, Any]:
        """The official fields that are arrays and numbers, in boards of the game's size."""
        size = self.rules.board_size
        seen = {key: value[0, 0] for key, value in self.games.observations((agent,)).items()}
        return {key: value[:size, :size].copy() if key in _BOARDS else value
                for key, value in seen.items()}

    def official(self, agent: int) -> dict[str, Any]:
        """The dictionary that the official environment gives an agent's ``act``."""
        self.require_open()
        seen = self.seen(agent)
        mode = self.rules.game_type
        result: dict[str, Any] = {
            "alive": [10 + other for other in range(AGENTS) if seen["alive"][other]],
            "board": seen["board"]}
        for key in _BOARDS[1:]:
            result[key] = seen[key].astype(np.float64)
        version = 2 if mode == _RADIO else 1 if any(self.rules.collapse_steps) else 0
        teams = mode in _TEAM_MODES
        result |= {
            "game_type": mode,
            "game_env": f"pommerman.envs.v{version}:Pomme",
            "position": tuple(map(int, seen["position"])),
            "blast_strength": int(seen["blast_strength"]),
            "can_kick": bool(seen["can_kick"]),
            "teammate": 10 + (agent + 2) % AGENTS if teams else 9,
            "ammo": int(seen["ammo"]),
            "enemies": [10 + other for other in range(self.rules.agents)
                        if other != agent and not (teams and (agent + other) % 2 == 0)],
            "step_count": int(seen["step_count"])}
        if teams:
            result["enemies"].append(9)
        if mode == _RADIO:
            result["message"] = tuple(map(int, seen["message"]))
        return result

    def mask(self, agent: int) -> np.ndarray:
        return self.games.legal_actions()[0, agent].astype(np.int8)

    def render(self) -> str | np.ndarray | None:
        self.require_open()
        if self.render_mode is None:
            return None
        lines = self.games.text(0).splitlines()
        size = self.rules.board_size
        board = [line[:size] for line in lines[:size]]
        if self.render_mode == "ansi":
            facts = [line for line in lines[11:] if not line.startswith(("hidden", "flame"))]
            return "\n".join(board + facts) + "\n"
        cells = np.array([[_COLORS[cell] for cell in line] for line in board], np.uint8)
        return cells.repeat(_PIXELS, axis=0).repeat(_PIXELS, axis=1)


class ParallelEnv(_ParallelBase):
    """PettingZoo's parallel API: the seats without a policy are its agents.

    environment: one of ENVIRONMENT_IDS. policies: rule-based agents, None where an agent of the
    caller's sits (see Games). observation: "planes", float32 [23, 11, 11] as our networks see the
    game, or "arrays", the official observation as a dictionary of arrays. Actions are 0..5, in
    radio games [action, word, word] or an action alone.

    An agent terminates when its result is certain: in free-for-all with its death, in team games,
    where it may still win, with the game. Till then its actions are ignored once it is dead. The
    last step is one of the rules, a tie, and so a termination too: nothing is ever truncated.
    Rewards are the official ones. infos hold "action_mask", int8 [6] (1: has an effect), and of
    those that terminate "winners", the names of who has won.
    """

    metadata = {"name": "pommerman", "render_modes": list(RENDER_MODES), "render_fps": 10}

    def __init__(self, environment: str = "PommeFFACompetition-v0", *, policies: Policies = None,
                 observation: str = "planes", render_mode: str | None = None) -> None:
        self._game = _Game(environment, policies, observation, render_mode)
        self.render_mode = render_mode
        seats = policies_of(policies)
        self._ids = {f"agent_{i}": i for i in range(self._game.rules.agents) if seats[i] is None}
        if not self._ids:
            raise ValueError("policies has no None, expected one for each agent of the caller's")
        self.possible_agents = list(self._ids)
        self.agents: list[str] = []
        self.observation_spaces = {name: self._game.observation_space() for name in self._ids}
        self.action_spaces = {name: self._game.action_space() for name in self._ids}
        self._seeds = np.random.default_rng()

    @property
    def num_agents(self) -> int:
        """How many are still in the game."""
        return len(self.agents)

    @property
    def max_num_agents(self) -> int:
        """How many begin a game."""
        return len(self.possible_agents)

    @property
    def unwrapped(self) -> ParallelEnv:
        """The environment itself."""
        return self

    def observation_space(self, agent: str) -> spaces.Space:
        """The same object in every call."""
        self._id(agent)
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space:
        """The same object in every call."""
        self._id(agent)
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: Mapping[str, Any] | None = None
              ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begins a game, the same for the same seed; (observations, infos)."""
        if seed is not None:
            self._seeds = np.random.default_rng(_checks.seed(seed))
        self._game.begin(int(self._seeds.integers(2**63)), options)
        self.agents = self.possible_agents[:]
        return self._observations(self.agents), self._infos(self.agents)

    def step(self, actions: Mapping[str, Any]
             ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool],
                        dict[str, dict[str, Any]]]:
        """Plays one step: (observations, rewards, terminations, truncations, infos) of `agents`.

        actions: one for each of `agents`. Those that terminate leave `agents`.
        """
        self._game.require_running()
        done, rewards, winners = self._play(actions)
        names = self.agents
        alive = self._game.games.alive()[0]
        final = self._game.rules.game_type not in _TEAM_MODES
        ends = {name: done or bool(final and not alive[self._ids[name]]) for name in names}
        infos = self._infos(names)
        for name in names:
            if ends[name]:
                infos[name]["winners"] = winners
        self.agents = [name for name in names if not ends[name]]
        self._game.running = bool(self.agents)
        return (self._observations(names), {name: rewards[self._ids[name]] for name in names}, ends,
                dict.fromkeys(names, False), infos)

    def official_observation(self, agent: str) -> dict[str, Any]:
        """What the official environment would show this agent: its keys, units and types."""
        return self._game.official(self._id(agent))

    def render(self) -> str | np.ndarray | None:
        """The board as text ("ansi") or as uint8 [rows, columns, 3] ("rgb_array")."""
        return self._game.render()

    def close(self) -> None:
        """Ends the environment; whatever needs it raises RuntimeError from then on."""
        self._game.closed = True
        self.agents = []

    def _play(self, actions: Mapping[str, Any]) -> tuple[bool, list[float], list[str]]:
        if not isinstance(actions, Mapping) or set(actions) != set(self.agents):
            given = sorted(map(str, actions)) if isinstance(actions, Mapping) else actions
            raise ValueError(f"actions has {_checks.shown(given)}, expected a dictionary of "
                             f"{self.agents}")
        rows = np.zeros((1, AGENTS, 3), np.uint8)
        for name, action in actions.items():
            rows[0, self._ids[name]] = _row_of(name, action, self.action_spaces[name])
        radio = self._game.rules.game_type == _RADIO
        step = self._game.games.step(rows[:, :, 0].copy(), rows[:, :, 1:].copy() if radio else None)
        winners = [f"agent_{i}" for i in range(AGENTS) if step.winners[0] >> i & 1]
        return bool(step.done[0]), step.rewards[0].tolist(), winners

    def _observations(self, names: list[str]) -> dict[str, Any]:
        return {name: self._game.observe(self._ids[name]) for name in names}

    def _infos(self, names: list[str]) -> dict[str, dict[str, Any]]:
        return {name: {"action_mask": self._game.mask(self._ids[name])} for name in names}

    def _id(self, agent: str) -> int:
        if isinstance(agent, str) and agent in self._ids:
            return self._ids[agent]
        raise ValueError(f"agent is {_checks.shown(agent)}, expected one of "
                         f"{self.possible_agents}")


class Env(_EnvBase):
    """Gymnasium's API: one agent of the caller's among rule-based ones.

    agent: its seat, 0..3. policies: of the other seats, one name for all or one per seat (that of
    the agent's own is ignored). Everything else as in ParallelEnv.
    """

    metadata = {"render_modes": list(RENDER_MODES), "render_fps": 10}
    spec = None

    def __init__(self, environment: str = "PommeFFACompetition-v0", *, agent: int = 0,
                 policies: Policies = "simple_unbiased", observation: str = "planes",
                 render_mode: str | None = None) -> None:
        seats = list(policies_of(policies))
        playing = rules(environment).agents
        seats[_checks.whole("agent", agent, 0, playing - 1)] = None
        self._name = f"agent_{agent}"
        self._env = ParallelEnv(environment, policies=seats, observation=observation,
                                render_mode=render_mode)
        self.observation_space = self._env.observation_space(self._name)
        self.action_space = self._env.action_space(self._name)
        self.render_mode = render_mode

    @property
    def unwrapped(self) -> Env:
        """The environment itself."""
        return self

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
              ) -> tuple[Any, dict[str, Any]]:
        """Begins a game, the same for the same seed; (observation, info)."""
        if seed is not None:
            seed = _checks.seed(seed)
        if _EnvBase is not object:
            super().reset(seed=seed)
        observations, infos = self._env.reset(seed, options)
        return observations[self._name], infos[self._name]

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Plays one step: (observation, reward, terminated, truncated, info)."""
        results = self._env.step({self._name: action})
        return tuple(result[self._name] for result in results)

    def official_observation(self) -> dict[str, Any]:
        """What the official environment would show the agent: its keys, units and types."""
        return self._env.official_observation(self._name)

    def render(self) -> str | np.ndarray | None:
        """The board as text ("ansi") or as uint8 [rows, columns, 3] ("rgb_array")."""
        return self._env.render()

    def close(self) -> None:
        """Ends the environment; whatever needs it raises RuntimeError from then on."""
        self._env.close()


def _row_of(name: str, action: Any, space: spaces.Space) -> Any:
    """The action as three numbers; ValueError unless it is one."""
    values = _checks.array(f"action of {name}", action)
    radio = isinstance(space, spaces.MultiDiscrete)
    row = np.array([values, 0, 0]) if values.shape == () else values
    limits = (ACTIONS, WORDS, WORDS)
    if (row.shape == (3,) and values.dtype.kind in "iu" and (radio or row is not values)
            and all(0 <= value < limit for value, limit in zip(row, limits))):
        return row
    raise ValueError(f"action of {name} is {_checks.shown(action)}, expected one of {space}")
