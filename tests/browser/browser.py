"""Programs and a real browser, for the tests that look at pages."""

import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = ROOT / "build/release/bin"
BROWSER_OPTIONS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}


class Failure(Exception):
    pass


def expect(condition, reason):
    if not condition:
        raise Failure(reason)


def wait_for(what, condition, limit_s=60, pause_s=0.2):
    """Returns the first value of the condition that is true."""
    deadline = time.monotonic() + limit_s
    while True:
        value = condition()
        if value:
            return value
        expect(time.monotonic() < deadline, f"timed out waiting for {what}")
        time.sleep(pause_s)


class Processes:
    """Programs that end with the test; each writes into a file of the folder."""

    def __init__(self, folder):
        self.folder = folder
        self.started = []

    def start(self, name, *command):
        with open(self.output(name), "w") as output:
            process = subprocess.Popen(
                [str(word) for word in command], cwd=ROOT, stdout=output, stderr=subprocess.STDOUT
            )
        self.started.append(process)
        return process

    def output(self, name):
        return self.folder / f"{name}.out"

    def said(self, name, pattern):
        """What the pattern's group is in the output, once it is there."""
        return wait_for(
            f"'{pattern}' from {name}",
            lambda: re.search(pattern, self.output(name).read_text()),
        )[1]

    def stop(self, process):
        process.send_signal(signal.SIGTERM)
        expect(process.wait(timeout=30) == 0, f"{process.args[0]} ended with {process.returncode}")

    def end(self):
        for process in self.started:
            if process.poll() is None:
                process.kill()
                process.wait()


class Browser:
    """A page in Chromium, by the WebDriver protocol; a context, at whose end Chromium ends."""

    def __init__(self, processes):
        processes.start("driver", "chromedriver", "--port=0")
        port = processes.said("driver", r"started successfully on port (\d+)")
        self.root = f"http://127.0.0.1:{port}/session"
        options = [*BROWSER_OPTIONS, f"--user-data-dir={processes.folder}/profile"]
        wanted = {"goog:chromeOptions": {"args": options}, "goog:loggingPrefs": {"browser": "ALL"}}
        session = self.ask("POST", "", capabilities={"alwaysMatch": wanted})
        self.root += "/" + session["sessionId"]

    def ask(self, method, path, **body):
        data = json.dumps(body).encode() if method == "POST" else None
        request = urllib.request.Request(self.root + path, data, method=method)
        with urllib.request.urlopen(request, timeout=60) as reply:
            return json.load(reply)["value"]

    def open(self, url):
        self.ask("POST", "/url", url=url)

    def run(self, script):
        """The value of an expression of JavaScript."""
        return self.ask("POST", "/execute/sync", script=f"return {script};", args=[])

    def texts(self, selector):
        """What is written in those of the elements that can be seen."""
        visible = f"[...document.querySelectorAll({selector!r})].filter(e => e.checkVisibility())"
        return self.run(f"{visible}.map(e => e.innerText)")

    def text(self, selector):
        return " ".join(self.texts(selector))

    def count(self, selector):
        return self.run(f"document.querySelectorAll({selector!r}).length")

    def point_at(self, selector):
        element = self.ask("POST", "/element", using="css selector", value=selector)
        move = {"type": "pointerMove", "origin": element, "x": 0, "y": 0}
        mouse = {"type": "pointer", "id": "mouse", "actions": [move]}
        self.ask("POST", "/actions", actions=[mouse])

    def click(self, selector):
        element = self.ask("POST", "/element", using="css selector", value=selector)
        self.ask("POST", f"/element/{next(iter(element.values()))}/click")

    def press(self, *keys):
        """One key after the other, as WebDriver writes them."""
        strokes = [{"type": type, "value": key} for key in keys for type in ("keyDown", "keyUp")]
        self.ask("POST", "/actions", actions=[{"type": "key", "id": "keys", "actions": strokes}])

    def emulate(self, command, **parameters):
        self.ask("POST", "/goog/cdp/execute", cmd=f"Emulation.{command}", params=parameters)

    def errors(self):
        """Errors of the page; that nobody answers while the learner is away is none."""
        lines = self.ask("POST", "/se/log", type="browser")
        return [line["message"] for line in lines if line["source"] != "network"]

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        self.ask("DELETE", "")


def look_with(name, look):
    """Runs look(processes, browser), the test of this name, and exits."""
    for program in ("chromium", "chromedriver"):
        if not shutil.which(program):
            print(f"{name}: skipped, {program} is not installed")
            sys.exit(77)
    folder = pathlib.Path(tempfile.mkdtemp())
    processes = Processes(folder)
    try:
        with Browser(processes) as browser:
            look(processes, browser)
    except (Failure, OSError) as failure:
        for output in sorted(folder.glob("*.out")):
            print(f"--- {output.name}", *output.read_text().splitlines()[-5:], sep="\n")
        sys.exit(f"{name}: {failure}")
    finally:
        processes.end()
        shutil.rmtree(folder, ignore_errors=True)
