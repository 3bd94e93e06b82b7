"""What callers hand in, checked: one line that says what, which value, and what was expected."""

from __future__ import annotations

from typing import Any

import numpy as np


def shown(value: Any) -> str:
    """The value as messages show it: on one line, and not all of what is long."""
    line = " ".join(repr(value).split())
    return line if len(line) <= 80 else f"{line[:77]}..."


def whole(what: str, value: Any, low: int = -2**63, high: int = 2**63 - 1) -> int:
    """The value as an int; ValueError unless it is an integer in low..high."""
    if isinstance(value, (int, np.integer)) and low <= value <= high:
        return int(value)
    raise ValueError(f"{what} is {shown(value)}, expected an integer from {low} to {high}")


def seed(value: Any) -> int:
    """A seed of 64 bits."""
    return whole("seed", value, 0, 2**64 - 1)


def text(what: str, value: Any) -> str:
    """The value; ValueError unless it is a text."""
    if isinstance(value, str):
        return value
    raise ValueError(f"{what} is {shown(value)}, expected a text")


def one_of(what: str, value: Any, expected: tuple[Any, ...]) -> None:
    """ValueError unless the value is one of those expected."""
    if not any(value is one or (isinstance(value, str) and value == one) for one in expected):
        raise ValueError(f"{what} is {shown(value)}, expected one of {expected}")


def array(what: str, values: Any) -> np.ndarray:
    """The values as an array of whatever type; ValueError if they are none."""
    try:
        return np.asarray(values)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{what} is no array: {error}") from error
