"""The examples of docs/python.md, run in order in a folder with a run."""

import contextlib
import importlib.util
import io
import os
import re
import shutil

from support import ROOT, PowderkegTest, write_data


class ExamplesTest(PowderkegTest):
    def test_they_run(self):
        write_data(self.folder)
        run = self.folder / "runs/quick"
        shutil.move(self.folder / "run", run)
        (run / "weights").mkdir()
        shutil.copy(self.folder / "small.weights", run / "weights/version-000025.weights")
        (self.folder / "tests").symlink_to(ROOT / "tests")
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)
        text = (ROOT / "docs/python.md").read_text()
        examples = re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
        self.assertGreater(len(examples), 4)
        names = {}
        for number, example in enumerate(examples):
            if "import torch" in example and importlib.util.find_spec("torch") is None:
                continue
            with self.subTest(example=number), contextlib.redirect_stdout(io.StringIO()):
                exec(compile(example, f"docs/python.md, example {number}", "exec"), names)
