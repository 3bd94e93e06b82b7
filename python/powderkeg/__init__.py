"""Powderkeg from Python: environments, batches of games, training data, weights.

The module in C++ is built by ``deploy/build release python`` and found in ``build/release/python``
beside this package, or in the folder that the environment variable ``POWDERKEG_MODULE`` names.
docs/python.md shows everything by example.
"""

import importlib
import os
import pathlib

_MODULE_FOLDER = os.environ.get(
    "POWDERKEG_MODULE", str(pathlib.Path(__file__).resolve().parents[2] / "build/release/python"))
__path__.append(_MODULE_FOLDER)

try:
    importlib.import_module(f"{__name__}._native")
except ModuleNotFoundError as error:
    raise ImportError(f"powderkeg: no module for this Python in {_MODULE_FOLDER}, expected one "
                      "built by: deploy/build release python") from error

from .environments import Env, ParallelEnv
from .games import ENVIRONMENT_IDS, POLICIES, Games, Rules, Step, rules

__all__ = [
    "ENVIRONMENT_IDS", "POLICIES", "Env", "Games", "ParallelEnv", "Rules", "Step", "rules",
]
