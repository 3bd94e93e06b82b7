"""Makes the module in C++, powderkeg._native, importable from where it was built."""

import importlib
import os
import pathlib
import sys

FOLDER = os.environ.get(
    "POWDERKEG_MODULE", str(pathlib.Path(__file__).resolve().parents[2] / "build/release/python"))

sys.modules["powderkeg"].__path__.append(FOLDER)
try:
    importlib.import_module("powderkeg._native")
except ModuleNotFoundError as error:
    raise ImportError(f"powderkeg: no module for this Python in {FOLDER}, expected one built by: "
                      "deploy/build release python") from error
