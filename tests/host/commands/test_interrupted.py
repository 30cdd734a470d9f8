"""Ctrl-C at any moment of a command's life ends it without a traceback."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import serpenoid as sn
from robot.patience import LONG_S
from serpenoid import _core
from serpenoid.simulation.core_run import core_request
from serpenoid.simulation.error import Difference

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


@pytest.mark.parametrize("seed", range(12))
def test_ctrl_c_during_the_import_leaves_no_traceback(seed):
    child = subprocess.Popen(
        [sys.executable, "-c", STARTED], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "started\n"
    time.sleep(random.Random(seed).uniform(0.0, 0.15))
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=LONG_S)
    assert child.returncode in (0, 130, -signal.SIGINT)
    assert "Traceback" not in errors


SCENE = sn.Scene(
    sn.Robot(3, 1.0, 0.12), sn.Ground(0.1, 10.0), sn.Gait(0.5, 1.0, 3.0), duration_s=0.1
)


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("every", 0, "every"),
        ("every", -3, "every"),
        ("dt_s", 0.0, "dt_s"),
        ("dt_s", float("nan"), "dt_s"),
        ("duration_s", float("inf"), "duration_s"),
        ("steps", -1, "steps"),
        ("faults", [_core.Fault.limp] * 3, "faults"),
        ("locked_rad", [0.1], "locked_rad"),
    ],
)
def test_the_core_refuses_what_would_never_end_or_overrun(field, value, said):
    request = core_request(SCENE)
    setattr(request, field, value)
    with pytest.raises(ValueError, match=said):
        _core.run(request, np.zeros(18), None)


@pytest.mark.parametrize("size", [0, 17, 19])
def test_the_core_refuses_a_start_of_another_size(size):
    with pytest.raises(ValueError, match="start"):
        _core.run(core_request(SCENE), np.zeros(size), None)
    with pytest.raises(ValueError, match="links"):
        _core.evaluate(core_request(SCENE), np.zeros(size), np.zeros(2))
    with pytest.raises(ValueError, match="value a joint"):
        _core.evaluate(core_request(SCENE), np.zeros(18), np.zeros(size))


def test_the_mean_speed_of_a_snake_at_rest_is_no_nan():
    assert Difference(0.0, 0.0, float("nan")).in_words().endswith("of nothing: at rest")
    assert Difference(0.0, 0.0, 0.01).in_words().endswith("speed +0.01")
