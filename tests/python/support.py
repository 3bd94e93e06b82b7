"""What several tests need."""

import functools
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "tests/data"
_PROGRAM = os.environ.get("POWDERKEG_PYTHON_DATA",
                          str(ROOT / "build/release/tests/bin/python_data"))


class PowderkegTest(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def refuses(self, pattern, call, *arguments, **options):
        """The call raises a ValueError of one line that holds the pattern."""
        with self.assertRaisesRegex(ValueError, pattern) as caught:
            call(*arguments, **options)
        self.assertNotIn("\n", str(caught.exception))


@functools.cache
def _data():
    """Made once, as durable files take their time."""
    folder = tempfile.TemporaryDirectory()
    subprocess.run([_PROGRAM, folder.name], check=True)
    return folder


def write_data(folder):
    """A run of two segments, small.weights and paper.weights (python_data_main.cc)."""
    shutil.copytree(_data().name, folder, dirs_exist_ok=True)
