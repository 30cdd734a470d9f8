"""The error of a run with sticking wheels and many links is a bound, at a bounded cost."""

from __future__ import annotations

from dataclasses import replace

import pytest
import serpenoid as sn
from serpenoid.simulation.judge import difference

GROUND = sn.Ground(0.014, 0.2, 0.02, 0.045)


def scene(links: int, tolerance: float, duration_s: float = 0.5) -> sn.Scene:
    robot, gait = sn.Robot(links, 0.0756, 0.076), sn.Gait(0.5, 9.4 / links, 4.0)
    return sn.Scene(
        robot,
        GROUND,
        gait,
        method="nonsmooth",
        dt_s=5e-3,
        duration_s=duration_s,
        start="link1_at_rest",
        tolerance=tolerance,
    )


@pytest.mark.parametrize("links", [6, 20, 40])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_the_estimate_is_a_bound(links: int, tolerance: float) -> None:
    run = sn.simulate(scene(links, tolerance))
    truth = sn.simulate(replace(run.scene, tolerance=1e-11 if links < 40 else 1e-10))
    off, said = difference(run, truth), run.error_estimate
    assert said.settled
    rounding = 1e-11
    assert off.position_m <= said.integration.position_m + rounding
    assert off.angle_rad <= said.integration.angle_rad + rounding


def test_ninety_nine_links_have_an_error_that_is_finite() -> None:
    run = sn.simulate(scene(99, 1e-7, duration_s=0.2))
    assert run.error_estimate.settled
    assert run.error_estimate.worst(run.scene.robot.body_length_m) < 1e-6
