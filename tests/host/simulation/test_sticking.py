"""Set-valued friction with pinned joints under every drive and fault.

Held to the law itself at recorded times; test_truths.py has references that know nothing of it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005, gait_in_deg

from .truth_cases import slips

GAIT = gait_in_deg(70, 75, 1.5)
SCENE = sn.Scene(
    OF_2005,
    BINGHAM,
    GAIT,
    method="nonsmooth",
    duration_s=2.0,
    dt_s=0.01,
    tolerance=1e-9,
    start="zero_momentum",
)
DRIVES: dict[str, dict[str, Any]] = {
    "servo": {"drive": "servo", "servo": sn.Servo()},
    "torque": {"drive": "torque", "torque": [2e-3, -1e-3, 1.5e-3, -2e-3, 1e-3]},
    "limp": {"limp": (2,)},
    "limp on a slope": {"limp": (2,), "incline_rad": 0.2},
    "locked": {"locked": {3: 0.2}},
    "straight on a slope": {"gait": sn.Gait(0.0, 1.0, 1.0), "incline_rad": 0.2},
}


def of(name: str, **more: Any) -> sn.Scene:
    return replace(SCENE, **(DRIVES[name] | more))


@pytest.mark.parametrize("name", DRIVES)
def test_the_law_holds_at_every_recorded_time(name: str) -> None:
    """What slides has its whole force against it, what rests at most that, and truly rests."""
    run = sn.simulate(of(name, record=("friction",)))
    v = slips(run, run.vx_m_s, run.vy_m_s)
    f = slips(run, run.friction_x_n, run.friction_y_n)
    for way, viscous, dry in ((0, BINGHAM.ct, BINGHAM.ft0), (1, BINGHAM.cn, BINGHAM.fn0)):
        left = f[..., way] + viscous * v[..., way]
        moves = np.abs(v[..., way]) > 1e-7
        assert np.abs(left).max() <= dry * (1 + 1e-5)
        assert left[moves] == pytest.approx(-dry * np.sign(v[..., way][moves]), abs=1e-9 * dry)
    assert (np.abs(v) <= 1e-7).any()


def test_torques_below_what_friction_holds_move_nothing() -> None:
    straight = sn.Gait(0.0, 0.0, 1.0)
    run = sn.simulate(of("torque", torque=[1e-5, 1e-5, 0, 0, 0], gait=straight))
    assert run.travel_m < 1e-9  # of half a metre: what the tolerance lets creep
    assert np.abs(run.theta_rad).max() < 1e-8


def test_a_zigzag_shortens_until_friction_has_its_energy() -> None:
    """Angles +-a move no centre but along, by L a^2/2 a link: 2 T a = ft0 L (9 a^2/2), at rest."""
    torque, straight = 1e-5, sn.Gait(0.0, 0.0, 1.0)
    run = sn.simulate(of("torque", torque=[torque, 0, 0, 0, 0], gait=straight))
    angle = 4 * torque / (9 * BINGHAM.ft0 * OF_2005.link_length_m)
    assert np.abs(run.theta_rad[-1]) == pytest.approx([angle] * 6, rel=3e-3)
    assert np.abs(run.omega_rad_s[-1]).max() < 1e-8


def test_a_wheel_that_turns_back_for_a_moment_is_seen() -> None:
    """A thousandth of a cycle, at 5 micrometres a second: at 1e-8 it lay between two looks."""
    gait = sn.Gait(
        1.1432119800600966,
        0.70080509117233,
        1.475344705493894,
        0.0,
        (0.9336745413116935, 0.9060444751704962, 0.9791539102821627, 0.890030452956113),
        (-0.1312988896871905, -0.06338689422875218, 0.17445656634035472, -0.02645669039453824),
    )
    scene = replace(
        SCENE,
        robot=sn.Robot(5, 0.8897103695729025, 0.28510368385558316),
        ground=sn.Ground(
            0.0006115766747115468,
            0.007260020669181927,
            0.007326248646415052,
            0.48860798522351667,
        ),
        gait=gait,
        tolerance=1e-12,
        duration_s=31 * gait.period_s,
    )
    cycle = replace(scene, start=sn.simulate(scene).state(), duration_s=gait.period_s)
    loose = sn.simulate(replace(cycle, tolerance=1e-8))
    assert loose.theta_rad[-1] == pytest.approx(sn.simulate(cycle).theta_rad[-1], abs=1e-7)
