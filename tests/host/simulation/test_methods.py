"""Every method converges with its declared order, for all drives that it supports."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import gait_in_deg

ROBOT, GROUND = sn.Robot(4, 0.08, 0.09, 2.5e-4), sn.Ground(0.3, 3.0)
GAIT = gait_in_deg(40, 70, 4.0)
# A servo without limits and dead band, which would add kinks.
SERVO = sn.Servo(0.3, 0.02, 1e6, 1e6, 0.0)
TABLE = sn.TorqueTable(np.array([0.03, 0.1]), np.array([[0.02, -0.01, 0.03], [0.0, 0.01, -0.02]]))
DRIVES = {
    "angle": {},
    "torque": {"torque": TABLE},
    "servo": {"servo": SERVO},
}
ORDERS = [  # orders of methods with fixed steps
    ("rk4", "explicit", 4),
    ("rk4", "implicit", 4),
    ("paper", "implicit", 1),
    ("nonsmooth", "implicit", 2),
]


def end_state(scene: sn.Scene, steps: int) -> np.ndarray:
    """Return the state at the end of a run with this number of steps."""
    scene = replace(scene, dt_s=scene.duration_s / steps, record_every=steps)
    return sn.simulate(scene).state().packed()


@pytest.mark.parametrize(("method", "formulation", "order"), ORDERS)
@pytest.mark.parametrize("drive", DRIVES)
def test_a_method_has_its_order(method: str, formulation: str, order: int, drive: str) -> None:
    """The drives have jumps and kinks: frames of 20 ms, rows of a table."""
    scene = sn.Scene(
        ROBOT,
        GROUND,
        GAIT,
        formulation=formulation,
        drive=drive,
        **DRIVES[drive],
        method=method,
        limp=(2,),
        joint_stiffness_n_m=300.0,
        joint_damping_n_s_m=1.0,
        incline_rad=0.1,
        duration_s=0.12,
        start="link1_at_rest",
    )
    exact = end_state(replace(scene, method="rk4"), 960)
    counts = (60, 120) if order > 2 else (240, 480)
    errors = [np.abs(end_state(scene, steps) - exact).max() for steps in counts]
    assert errors[0] < 0.1
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


def test_a_changed_scene_chooses_its_method_again_unless_it_names_one() -> None:
    smooth = sn.Scene(sn.Robot(3, 1.0, 0.12), sn.Ground(0.1, 1.0), sn.Gait(0.3, 0.5, 3.0))
    dry = sn.Ground(0.1, 1.0, 0.01, 0.02)
    assert smooth.method == "rk4"
    assert replace(smooth, ground=dry).method == "nonsmooth"
    assert replace(replace(smooth, method="rk4"), ground=dry).method == "rk4"
    with refused("nonsmooth"):
        replace(smooth, ground=sn.Ground((0.014, 0.14), 0.2), method="dop853")
