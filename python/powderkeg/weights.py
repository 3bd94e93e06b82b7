"""Weights of a network: our .weights files and safetensors, as numpy arrays."""

from __future__ import annotations

import base64
import json
import math
import os
import pathlib
from dataclasses import dataclass, field
from typing import Any, Union

import numpy as np

from . import _checks, _native

Canary = _native.Canary
"""Positions with the answers that the network gives, by which whoever loads weights checks them.

planes float32 [n, 23, 11, 11], viewer [n], policy float32 [n, 6], value float32 [n], others uint8
[n, 3, 6] (probabilities in 255ths). `answered(policy, value, others=None)` gives the same positions
with other answers. Canary() is one without positions.
"""

Path = Union[str, os.PathLike]
_LENGTH_BYTES = 8
_ALIGNMENT = 8
_MAX_HEADER_BYTES = 100_000_000  # as the format's own reader allows


@dataclass
class Weights:
    """Weights of one version.

    `description`: the architecture (common/model/network_description.h) as a dictionary of numbers
    and, for each block, of its kind and numbers. `arrays`: float32 by name, as ArraysOf there lists
    them.
    """

    version: int
    description: dict[str, Any]
    arrays: dict[str, np.ndarray]
    canary: Canary = field(default_factory=Canary)


def load_weights(name: Path) -> Weights:
    """Reads a .weights file, or makes "untrained:small" or "untrained:paper"."""
    return Weights(*_native.load_weights(os.fspath(name)))


def save_weights(weights: Weights, path: Path) -> None:
    """Writes a .weights file; it appears whole or not at all.

    ValueError unless the arrays are those of the description, and finite.
    """
    version = _checks.whole("version", weights.version, 0, 2**32 - 1)
    if not isinstance(weights.canary, Canary):
        raise ValueError(f"canary is {_checks.shown(weights.canary)}, expected a Canary")
    _native.save_weights(os.fspath(path), version, weights.description, weights.arrays,
                         weights.canary)


def save_safetensors(weights: Weights, path: Path) -> None:
    """Writes a safetensors file: the arrays, with all else in its metadata.

    The metadata's texts: powderkeg_version, powderkeg_description (JSON) and powderkeg_canary (the
    bytes of a .weights file's canary in base64).
    """
    arrays = {name: np.ascontiguousarray(array, "<f4") for name, array in weights.arrays.items()}
    header: dict[str, Any] = {"__metadata__": {
        "powderkeg_version": str(weights.version),
        "powderkeg_description": json.dumps(weights.description),
        "powderkeg_canary": base64.b64encode(weights.canary.to_bytes()).decode()}}
    offset = 0
    for name, array in arrays.items():
        header[name] = {"dtype": "F32", "shape": list(array.shape),
                        "data_offsets": [offset, offset + array.nbytes]}
        offset += array.nbytes
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % _ALIGNMENT)
    temporary = f"{os.fspath(path)}.tmp"
    with open(temporary, "wb") as file:
        file.write(len(text).to_bytes(_LENGTH_BYTES, "little"))
        file.write(text)
        for array in arrays.values():
            file.write(array.tobytes())
    os.replace(temporary, path)


def load_safetensors(path: Path) -> Weights:
    """Reads what save_safetensors wrote; ValueError that says what is wrong with any other file."""
    data = pathlib.Path(path).read_bytes()
    try:
        header, values = _header(data)
        metadata = header.pop("__metadata__", None)
        if not isinstance(metadata, dict) or "powderkeg_description" not in metadata:
            raise ValueError("no powderkeg_description in its metadata, expected a network of ours")
        arrays = {name: _array(name, entry, values) for name, entry in header.items()}
        canary = base64.b64decode(_text(metadata, "powderkeg_canary"), validate=True)
        weights = Weights(_version(metadata), json.loads(_text(metadata, "powderkeg_description")),
                          arrays, Canary.from_bytes(canary) if canary else Canary())
        _native.check_weights(weights.description, weights.arrays)
        return weights
    except ValueError as error:
        raise ValueError(f"{os.fspath(path)}: {error}") from error


def _header(data: bytes) -> tuple[dict[str, Any], memoryview]:
    size = int.from_bytes(data[:_LENGTH_BYTES], "little")
    if len(data) < _LENGTH_BYTES or size > min(len(data) - _LENGTH_BYTES, _MAX_HEADER_BYTES):
        raise ValueError(f"a header of {size} bytes in a file of {len(data)}: no safetensors file")
    end = _LENGTH_BYTES + size
    header = json.loads(data[_LENGTH_BYTES:end].decode())
    if not isinstance(header, dict):
        raise ValueError("its header is no JSON object")
    return header, memoryview(data)[end:]


def _text(metadata: dict[str, Any], key: str) -> str:
    return _checks.text(key, metadata.get(key, ""))


def _version(metadata: dict[str, Any]) -> int:
    text = _text(metadata, "powderkeg_version")
    if text.isascii() and text.isdigit() and int(text) < 2**32:
        return int(text)
    raise ValueError(f"powderkeg_version is {_checks.shown(text)}, expected 0 to 2**32 - 1")


def _array(name: str, entry: Any, values: memoryview) -> np.ndarray:
    dtypes = {"F32": "<f4", "F64": "<f8", "F16": "<f2"}
    if not isinstance(entry, dict) or entry.get("dtype") not in dtypes:
        raise ValueError(f"{name}: {_checks.shown(entry)} is no array of F16, F32 or F64")
    shape, offsets = entry.get("shape", 0), entry.get("data_offsets", 0)
    if not _numbers(shape) or not _numbers(offsets) or len(offsets) != 2:
        raise ValueError(f"{name}: {_checks.shown(entry)} has no shape and data_offsets")
    dtype = np.dtype(dtypes[entry["dtype"]])
    begin, end = offsets
    if end > len(values) or end - begin != math.prod(shape) * dtype.itemsize:
        raise ValueError(f"{name}: bytes {begin} to {end} of {len(values)} do not hold an array of "
                         f"{entry['dtype']} {shape}")
    return np.frombuffer(values[begin:end], dtype).reshape(shape).astype(np.float32)


def _numbers(values: Any) -> bool:
    return isinstance(values, list) and all(
        isinstance(value, int) and not isinstance(value, bool) and value >= 0 for value in values)
