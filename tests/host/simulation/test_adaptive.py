"""dop853, which picks its own steps for smooth motion: truth, order, limits, refusals."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from oracle.params import Array
from oracle.scenes import SlowScene
from robots import PAPER, VISCOUS, gait_in_deg
from serpenoid import Diverged
from serpenoid.simulation.starts import start_state

GAIT = gait_in_deg(30, 80, 5.0)
PAPERS_SCENE = sn.Scene(PAPER, VISCOUS, GAIT, duration_s=1.0, dt_s=0.01, start="link1_at_rest")


def link1(run: sn.Run) -> Array:
    """Return (x, y, theta) of link 1 and their rates at all recorded times, (T, 6)."""
    names = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
    return np.stack([getattr(run, name)[:, 0] for name in names], axis=1)


def error(run: sn.Run, exact: Array) -> float:
    """Return the largest error of link 1, in body lengths, radians, and these times omega."""
    scene = run.scene
    body, w = scene.robot.links * scene.robot.link_length_m, scene.gait.omega_rad_s
    return float(np.max(np.abs(link1(run) - exact) / [body, body, 1, body * w, body * w, w]))


def truth(scene: sn.Scene, rtol: float = 1e-10) -> Array:
    """Return link 1 of a scene by the dense reference and SciPy, at the recorded times."""
    times = np.append(np.arange(scene.steps) * scene.dt_s, scene.duration_s)[:: scene.every]
    states = SlowScene(scene).run(start_state(scene), times, rtol=rtol)
    return np.array([[*pose[0], *rates[0]] for pose, rates in states])


@pytest.fixture(scope="module")
def paper_truth() -> Array:
    return truth(PAPERS_SCENE, 1e-12)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_every_recorded_time_is_as_good_as_asked(tolerance: float, paper_truth: Array) -> None:
    run = sn.simulate(replace(PAPERS_SCENE, method="dop853", tolerance=tolerance))
    assert error(run, paper_truth) < 3 * tolerance
    assert run.local_error > 0


def test_steps_grow_as_the_order_says() -> None:
    """An estimate of order p needs tolerance^(-1/p) steps."""
    taken = [
        sn.simulate(replace(PAPERS_SCENE, method="dop853", tolerance=t, duration_s=10.0)).steps
        for t in (1e-5, 1e-12)
    ]
    assert math.log(1e7) / math.log(taken[1] / taken[0]) == pytest.approx(8, abs=0.8)


EXTREMES = [  # alpha (deg), omega, ct, cn, mass, cycles
    (170, 5.0, 0.1, 10.0, 1.0, 0.5),
    (30, 0.01, 0.1, 10.0, 1.0, 0.01),
    (70, 100.0, 0.1, 10.0, 1.0, 1),
    (30, 5.0, 10.0, 1e-5, 1.0, 1),
    (30, 5.0, 0.1, 10.0, 1e-3, 0.01),
    (30, 5.0, 0.0, 0.0, 1.0, 1),
]


@pytest.mark.parametrize(("alpha", "omega", "ct", "cn", "mass", "cycles"), EXTREMES)
def test_extremes(
    alpha: float, omega: float, ct: float, cn: float, mass: float, cycles: float
) -> None:
    gait = gait_in_deg(alpha, 80, omega)
    scene = sn.Scene(
        sn.Robot(3, mass, 0.12),
        sn.Ground(ct, cn),
        gait,
        tolerance=1e-8,
        duration_s=cycles * gait.period_s,
        dt_s=cycles * gait.period_s / 20,
        start="link1_at_rest",
    )
    exact = truth(scene)
    # at the edge of its stability an explicit method's errors are all of the tolerance's size
    assert error(sn.simulate(replace(scene, method="dop853")), exact) < 3e-7


def test_a_stiff_scene_is_refused_by_the_explicit_method() -> None:
    scene = sn.Scene(
        sn.Robot(6, 1e-6, 0.12),
        VISCOUS,
        GAIT,
        method="dop853",
        duration_s=100.0,
        start="link1_at_rest",
    )
    began = time.process_time()
    with pytest.raises(Diverged, match="stiff"):
        sn.simulate(scene)
    assert time.process_time() - began < 20  # the run itself would take hours
