"""The largest stable step is that of the stiffest shape of the cycle, wherever the cycle begins."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import serpenoid as sn
from serpenoid.simulation.stability import largest_stable_step_s


def test_a_cycle_that_begins_elsewhere_has_the_same_limit() -> None:
    """Of a robot that is straight at phase 0, or a zigzag; a small inertia makes bends count."""
    gait = sn.Gait(1.2, math.pi, 5.0)
    zigzag = replace(gait, joint_shift_rad=(math.pi / 2,) * 5)
    limits_s = [
        largest_stable_step_s(
            sn.Scene(
                sn.Robot(6, 1.0, 0.12, 1e-4),
                sn.Ground(0.1, 10.0),
                one,
                method="rk4",
                formulation="implicit",
                joint_stiffness_n_m=1e4,
                dt_s=1e-6,
            )
        )
        for one in (gait, zigzag)
    ]
    assert limits_s[0] == pytest.approx(limits_s[1], rel=5e-3)
