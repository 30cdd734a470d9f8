"""Hard springs, free joints on dry ground and long runs, held to references of their own.

The references (tests/oracle: dense models, a table of an event-driven solver) share no code with
the package.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn

from . import truth_cases as tc

# Link 1 after 5000 cycles, and after 60 on dry ground: settled cycles of the references, composed.
TURNS = math.radians(5)
DRY_CYCLES = 60
FAR_DRY = {
    0.0: (7.899060148354895, 9.208333343160035, 0.0611180395688667),
    TURNS: (-0.04168477392518902, -0.05596362568897478, 18.80935828283074),
}


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("torque", 0), ("torque", 5), ("table", 0), ("servo", 2), ("full", 0), ("full", 7)],
)
def test_torques_and_servos_on_dry_ground(kind: str, seed: int) -> None:
    """Wheels and gears that stick and slip, by events: to 1e-8, and to what runs claim."""
    scene = tc.free_case(kind, seed, duration_s=0.2)
    loose, tight = (sn.simulate(replace(scene, tolerance=t)) for t in (1e-6, 1e-11))
    truth = np.array(tc.DRY_RUNS[f"{kind} {seed}"]["places"])
    assert tc.off(tc.places(tight)[10::10], truth, scene.robot) < 1e-8
    claim = loose.error_estimate.integration.size(scene.robot.body_length_m)
    assert tc.off(tc.places(loose)[10::10], truth, scene.robot) <= 1.5 * claim + 1e-9


@pytest.mark.parametrize(
    ("links", "k", "lasts_s", "dt_s"),
    [(2, 1e4, 0.1, 1e-3), (3, 1e7, 0.01, 1e-4), (2, 1e9, 0.002, 1e-5)],
)
def test_springs_on_dry_ground(links: int, k: float, lasts_s: float, dt_s: float) -> None:
    """Wheels that rest and slide while springs ring, by events: as far off as runs claim."""
    scene = tc.hard_scene(
        links,
        k,
        ground=sn.Ground(0.1, 1.0, 0.3, 1.0),
        method="nonsmooth",
        duration_s=lasts_s,
        dt_s=dt_s,
    )
    run = sn.simulate(scene)
    truth = np.array(tc.DRY_RUNS[f"springs {links} {k:g}"]["places"])
    error = tc.off(tc.places(run)[-1:], truth, scene.robot)
    assert error < 1e-5
    assert run.error_estimate.settled
    assert error <= 1.1 * run.error_estimate.integration.size(scene.robot.body_length_m) + 1e-11


@pytest.mark.parametrize("offset", FAR_DRY)
def test_many_cycles_on_dry_ground(offset: float) -> None:
    """The 2005 robot forgets its start in three cycles; the others are composed."""
    x, y, theta = FAR_DRY[offset]
    run = sn.simulate(tc.far_scene(DRY_CYCLES, offset, tolerance=1e-7, dt_s=0.5))
    end, said = run.state(), run.error_estimate
    assert said.settled
    assert math.hypot(end.x_m[0] - x, end.y_m[0] - y) <= 1.5 * said.integration.position_m
    assert abs(end.theta_rad[0] - theta) <= 1.5 * said.integration.angle_rad
    assert said.integration.position_m < 1e-3
