"""The spaces of actions and observations: Gymnasium's where it is installed, else the same few."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

try:
    from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Space
except ImportError:

    class Space:
        """A set of values that can be drawn from. `shape` and `dtype` are those of its arrays."""

        def __init__(self, shape: Sequence[int] | None = None, dtype: Any = None) -> None:
            self.shape = None if shape is None else tuple(shape)
            self.dtype = None if dtype is None else np.dtype(dtype)
            self.np_random = np.random.default_rng()

        def seed(self, seed: int | None = None) -> None:
            """Begins the draws anew."""
            self.np_random = np.random.default_rng(seed)

        def sample(self) -> Any:
            """A uniform draw."""
            raise NotImplementedError

        def contains(self, x: Any) -> bool:
            """Whether x is a value of the space."""
            raise NotImplementedError

        def __contains__(self, x: Any) -> bool:
            return self.contains(x)

    class Discrete(Space):
        """The integers 0..n-1."""

        def __init__(self, n: int) -> None:
            super().__init__((), np.int64)
            self.n = n

        def sample(self) -> np.int64:
            return self.np_random.integers(self.n)

        def contains(self, x: Any) -> bool:
            whole = isinstance(x, (int, np.integer)) or (
                isinstance(x, np.ndarray) and x.shape == () and x.dtype.kind in "iu")
            return whole and 0 <= int(x) < self.n

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Discrete) and self.n == other.n

        def __repr__(self) -> str:
            return f"Discrete({self.n})"

    class MultiDiscrete(Space):
        """Vectors of integers, entry i in 0..nvec[i]-1."""

        def __init__(self, nvec: Sequence[int]) -> None:
            self.nvec = np.asarray(nvec, np.int64)
            super().__init__(self.nvec.shape, np.int64)

        def sample(self) -> np.ndarray:
            return self.np_random.integers(self.nvec)

        def contains(self, x: Any) -> bool:
            return (isinstance(x, np.ndarray) and x.shape == self.shape and x.dtype.kind in "iu"
                    and bool(np.all((0 <= x) & (x < self.nvec))))

        def __eq__(self, other: object) -> bool:
            return isinstance(other, MultiDiscrete) and np.array_equal(self.nvec, other.nvec)

        def __repr__(self) -> str:
            return f"MultiDiscrete({self.nvec.tolist()})"

    class Box(Space):
        """Arrays of one shape and type with values in low..high."""

        def __init__(self, low: float, high: float, shape: Sequence[int], dtype: Any) -> None:
            super().__init__(shape, dtype)
            self.low = np.full(self.shape, low, self.dtype)
            self.high = np.full(self.shape, high, self.dtype)

        def sample(self) -> np.ndarray:
            if self.dtype.kind == "f":
                return self.np_random.uniform(self.low, self.high).astype(self.dtype)
            return self.np_random.integers(self.low, self.high, dtype=self.dtype, endpoint=True)

        def contains(self, x: Any) -> bool:
            return (isinstance(x, np.ndarray) and x.shape == self.shape
                    and np.can_cast(x.dtype, self.dtype)
                    and bool(np.all((self.low <= x) & (x <= self.high))))

        def __eq__(self, other: object) -> bool:
            return (isinstance(other, Box) and self.shape == other.shape
                    and self.dtype == other.dtype and np.array_equal(self.low, other.low)
                    and np.array_equal(self.high, other.high))

        def __repr__(self) -> str:
            return f"Box({self.low.min()}, {self.high.max()}, {self.shape}, {self.dtype})"

    class Dict(Space):
        """Dictionaries with a value of one space for each key."""

        def __init__(self, spaces: Mapping[str, Space]) -> None:
            super().__init__()
            self.spaces = dict(spaces)

        def seed(self, seed: int | None = None) -> None:
            seeds = np.random.default_rng(seed).integers(2**31, size=len(self.spaces))
            for space, own in zip(self.spaces.values(), seeds):
                space.seed(int(own))

        def sample(self) -> dict[str, Any]:
            return {key: space.sample() for key, space in self.spaces.items()}

        def contains(self, x: Any) -> bool:
            return (isinstance(x, dict) and x.keys() == self.spaces.keys()
                    and all(x[key] in space for key, space in self.spaces.items()))

        def __getitem__(self, key: str) -> Space:
            return self.spaces[key]

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Dict) and self.spaces == other.spaces

        def __repr__(self) -> str:
            return f"Dict({self.spaces})"


__all__ = ["Box", "Dict", "Discrete", "MultiDiscrete", "Space"]
