"""Ctrl-C at any moment of a command's life ends it without a traceback."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time

import pytest
from robot.patience import LONG_S

# Python's own start, before any of this package runs, prints what it likes.
STARTED = """
import sys
class Tell:
    def find_spec(self, name, *_):
        if name == "serpenoid.commands.main":
            print("started", flush=True)
sys.meta_path.insert(0, Tell())
sys.argv = ["serpenoid", "ports"]
from serpenoid.__main__ import main
main()
"""

LEAVING = """
import atexit, sys, time
atexit.register(lambda: (print("leaving", flush=True), time.sleep(30)))
sys.argv = ["serpenoid", "--version"]
from serpenoid.__main__ import main
main()
"""


def started(program: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.mark.parametrize("seed", range(3))
def test_ctrl_c_during_the_import_leaves_no_traceback(seed):
    child = started(STARTED)
    assert child.stdout is not None
    assert child.stdout.readline() == "started\n"
    time.sleep(random.Random(seed).uniform(0.0, 0.15))
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=LONG_S)
    assert child.returncode in (0, 130, -signal.SIGINT)
    assert "Traceback" not in errors


def test_ctrl_c_while_python_leaves_ends_it_without_a_traceback():
    child = started(LEAVING)
    assert child.stdout is not None
    while child.stdout.readline() != "leaving\n":
        assert child.poll() is None
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=LONG_S)
    assert child.returncode == -signal.SIGINT
    assert errors == ""
