"""Powderkeg from Python: environments, batches of games, training data, weights.

The module in C++ is built by ``deploy/build release python`` and found in ``build/release/python``
beside this package, or in the folder that the environment variable ``POWDERKEG_MODULE`` names.
docs/python.md shows everything by example.
"""

from ._module import FOLDER as MODULE_FOLDER  # the first, as all others need the module
from .data import Batch, batches
from .environments import Env, ParallelEnv
from .games import ENVIRONMENT_IDS, POLICIES, Games, Rules, Step, rules
from .weights import (Canary, Weights, load_safetensors, load_weights, save_safetensors,
                      save_weights)

__all__ = [
    "ENVIRONMENT_IDS", "MODULE_FOLDER", "POLICIES", "Batch", "Canary", "Env", "Games",
    "ParallelEnv", "Rules", "Step", "Weights", "batches", "load_safetensors", "load_weights",
    "rules", "save_safetensors", "save_weights",
]
