"""What a run has stored, as numpy arrays, in batches and bounded memory."""

from __future__ import annotations

import os
import pathlib
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from typing import Optional, Union

import numpy as np

from . import _checks, _native

Source = Union[str, os.PathLike, Iterable[Union[str, os.PathLike]]]
"""A file, several, or the folder of a run."""


@dataclass
class Batch:
    """Decisions as training reads them, one per row; the view is that of the agent who decided."""

    ticket: np.ndarray  # uint64 [n], of the game; in recorded games its number within the file
    viewer: np.ndarray  # uint8 [n], 0..3: the agent
    step: np.ndarray  # uint16 [n], steps played before the decision
    end_step: np.ndarray  # uint16 [n], when the game ended
    searched: np.ndarray  # bool [n]; False: a demonstration
    visits: np.ndarray  # uint16 [n, 6], by action, as the search counted; all 0: no policy
    value: np.ndarray  # float32 [n], of the search's root, -1..1; 0 of demonstrations
    outcome: np.ndarray  # int8 [n]: +1 win, 0 tie, -1 loss
    others: np.ndarray  # uint8 [n, 3], what viewer + 1, + 2, + 3 (mod 4) did; 0 of the dead
    planes: Optional[np.ndarray] = None  # float32 [n, 23, 11, 11], what the agent knew (planes.h)

    def __len__(self) -> int:
        return len(self.ticket)

    @property
    def policy(self) -> np.ndarray:
        """The policy's target, float32 [n, 6]: the visits' distribution; all 0 without one."""
        total = self.visits.sum(axis=1, keepdims=True, dtype=np.float32)
        return self.visits / np.maximum(total, np.float32(1))


def files_of(source: Source) -> list[pathlib.Path]:
    """The files of a source, in order. Those of a run are its segments, the oldest first."""
    if not isinstance(source, (str, os.PathLike)):
        return [pathlib.Path(file) for file in source]
    path = pathlib.Path(source)
    if not path.is_dir():
        return [path]
    found = sorted((path / "replay").glob("segment-*.h5")) or sorted(path.glob("segment-*.h5"))
    if not found:
        raise ValueError(f"{path} has no segments, expected segment-*.h5 there or in its replay/")
    return found


def batches(source: Source, batch_size: int = 1024, *, planes: bool = True) -> Iterator[Batch]:
    """The decisions of all teaching agents, game by game, `batch_size` at a time (the last: fewer).

    Reads segments (.h5) and recorded games (.jsonl, .jsonl.gz, as `replay --export` writes them:
    demonstrations) and plays every game again. In memory are one segment's games (16 bytes a
    decision) and one batch. Where a file is damaged, a RuntimeWarning says what was left out.
    ValueError: a file cannot be read or is of another format.
    """
    size = _checks.whole("batch_size", batch_size, 1, 1_000_000)
    files = files_of(source)
    return _rows(files, size, planes)


def _rows(files: list[pathlib.Path], size: int, planes: bool) -> Iterator[Batch]:
    rest: Optional[Batch] = None
    for file in files:
        reader = _native.Samples(os.fspath(file))
        while True:
            wanted = size - (len(rest) if rest else 0)
            batch = Batch(**reader.next(wanted, planes))
            if len(batch) == 0:
                break
            rest = batch if rest is None else joined([rest, batch])
            if len(rest) == size:
                yield rest
                rest = None
        for damage in reader.damages():
            warnings.warn(damage, RuntimeWarning, stacklevel=3)
    if rest is not None:
        yield rest


def joined(parts: list[Batch]) -> Batch:
    """Several batches as one."""
    columns = {}
    for field in fields(Batch):
        arrays = [getattr(part, field.name) for part in parts]
        columns[field.name] = None if arrays[0] is None else np.concatenate(arrays)
    return Batch(**columns)
