"""Set-valued friction in time: the law itself under every drive, closed forms, order, references.

test_truths.py has references that know nothing of the law.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005, gait_in_deg

from . import truth_cases as tc

GAIT = gait_in_deg(70, 75, 1.5)
RATCHET = sn.Ground((0.014, 0.05), 0.2, (0.0233, 0.06), 0.045)
SCENE = sn.Scene(
    OF_2005,
    BINGHAM,
    GAIT,
    method="nonsmooth",
    duration_s=2.0,
    dt_s=0.01,
    tolerance=1e-9,
    record=("friction",),
)
SOFT = replace(SCENE, formulation="implicit", joint_stiffness_n_m=300.0, dt_s=1e-3)
TORQUE = [2e-3, -1e-3, 1.5e-3, -2e-3, 1e-3]
SCENES = {
    "servo": replace(SCENE, drive="servo", servo=sn.Servo()),
    "torque": replace(SCENE, drive="torque", torque=TORQUE),
    "limp": replace(SCENE, limp=(2,)),
    "limp on a slope": replace(SCENE, limp=(2,), incline_rad=0.2),
    "locked": replace(SCENE, locked={3: 0.2}),
    "straight on a slope": replace(SCENE, gait=sn.Gait(0.0, 1.0, 1.0), incline_rad=0.2),
    "ratchet": replace(SCENE, ground=RATCHET),
    "dry across alone": replace(SCENE, ground=sn.Ground((0.14, 0.014), 0.2, 0.0, 0.045)),
    "springs": SOFT,
}


@pytest.mark.parametrize("name", SCENES)
def test_the_law_holds_at_every_recorded_time(name: str) -> None:
    """What slides has its whole force against it, what rests at most that, and truly rests."""
    scene = SCENES[name]
    run, ground = sn.simulate(scene), scene.ground
    v = tc.slips(run, run.vx_m_s, run.vy_m_s)
    f = tc.slips(run, run.friction_x_n, run.friction_y_n)
    viscous = np.where(v > 0, [ground.ct_forward, ground.cn], [ground.ct_backward, ground.cn])
    forward, backward = (ground.ft0_forward, ground.fn0), (ground.ft0_backward, ground.fn0)
    dry = f + viscous * v
    moves = np.abs(v) > (1e-12 if name == "springs" else 1e-7)  # steps of their own creep so little
    assert (dry >= -np.multiply(forward, 1 + 1e-5) - 1e-15).all()
    assert (dry <= np.multiply(backward, 1 + 1e-5) + 1e-15).all()
    slides = np.where(v > 0, np.negative(forward), backward)
    assert dry[moves] == pytest.approx(slides[moves], abs=1e-9 * ground.fn0)
    assert (~moves[..., 1]).any()


def sliding_rod(v0: float, pull: float, kappa: float, mu: float, t: float) -> float:
    """Return the speed at t of v' = pull - kappa v - mu sgn v from v0 > 0, pull < 0."""
    rest = (mu - pull) / kappa
    stops = math.log1p(v0 / rest) / kappa
    if t < stops:
        return (v0 + rest) * math.exp(-kappa * t) - rest
    return min(0.0, pull + mu) / kappa * -math.expm1(-kappa * (t - stops))


@pytest.mark.parametrize("scene", [SCENE, SOFT], ids=["explicit", "implicit"])
@pytest.mark.parametrize("incline", [0.0, 0.02, 0.4])
def test_thrown_uphill_it_stops_and_stays_or_slides_back(scene: sn.Scene, incline: float) -> None:
    """All links alike: m v' = -m g sin - ct v - ft0 sgn v, which is solved exactly."""
    heading = 0.6
    pace = [0.5 * math.cos(heading), 0.5 * math.sin(heading), *[0.0] * 6]
    scene = replace(
        scene,
        gait=sn.Gait(0.0, 0.0, 2.0),
        incline_rad=incline,
        incline_direction_rad=heading,
        start=sn.LinkState.joined(OF_2005, [0.3, 0.1, *[heading] * 6], pace),
    )
    run = sn.simulate(scene)
    m, pull = OF_2005.link_mass_kg, -9.80665 * math.sin(incline)
    speeds = [sliding_rod(0.5, pull, BINGHAM.ct / m, BINGHAM.ft0 / m, t) for t in run.t_s]
    along = tc.slips(run, run.vx_m_s, run.vy_m_s)[:, :, 0]
    assert along == pytest.approx(np.outer(speeds, np.ones(6)), abs=1e-8)
    assert (speeds[-1] == 0) == (incline < 0.1)
    grip = tc.slips(run, run.friction_x_n, run.friction_y_n)[-1, :, 0]
    holds = -m * pull if incline < 0.1 else BINGHAM.ft0 - BINGHAM.ct * speeds[-1]
    # how a straight chain shares its load is open: only the sum is physical
    assert grip.sum() == pytest.approx(6 * holds, abs=1e-6)


def test_ratchets_on_springs_are_braked_backwards_by_their_backward_friction() -> None:
    start = sn.LinkState.joined(OF_2005, [0.0] * 8, [-0.5, 0.0, *[0.0] * 6])
    back = sn.Ground(RATCHET.ct_backward, RATCHET.cn, RATCHET.ft0_backward, RATCHET.fn0)
    ends = [
        sn.simulate(replace(SOFT, ground=g, gait=sn.Gait(0.0, 0.0, 2.0), start=start)).x_m[-1]
        for g in (RATCHET, back)
    ]
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


@pytest.mark.parametrize("incline", [0.0, 0.1])
def test_order_two_through_sticking_and_slipping(incline: float) -> None:
    """Events fall anywhere in a step, so single halvings scatter: the mean of five counts."""
    scene = replace(SOFT, gait=replace(GAIT, omega_rad_s=3.0), incline_rad=incline, duration_s=1.0)
    ends = [
        sn.simulate(replace(scene, dt_s=1 / n, record_every=n)).state().packed()
        for n in (250, 8000, 64000)
    ]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert errors[0] < 1e-3
    assert math.log2(errors[0] / errors[1]) / 5 > 1.75


def test_explicit_forces_are_those_of_the_reference() -> None:
    """Friction, joint forces and torques against those of an event-driven dense solver."""
    run = sn.simulate(
        replace(
            SCENE,
            gait=replace(GAIT, omega_rad_s=2.0),
            dt_s=0.05,
            record=("joints", "friction"),
            start="link1_at_rest",
        )
    )
    friction = tc.slips(run, run.friction_x_n, run.friction_y_n)
    for forces in tc.DRY_RUNS["forces"]["rows"]:
        k, pins = forces["row"], forces["pins"]
        assert friction[k].ravel() == pytest.approx(forces["wheels"], abs=1e-6)
        assert run.joint_force_x_n[k] == pytest.approx(pins[::2], abs=1e-6)
        assert run.joint_force_y_n[k] == pytest.approx(pins[1::2], abs=1e-6)
        assert run.joint_torque_nm[k] == pytest.approx(forces["torques"], abs=1e-7)


def balance(scene: sn.Scene) -> float:
    """Return the largest |stores - (work - heat)| of a run with a ledger."""
    energy = sn.simulate(scene).energy_j
    assert np.diff(energy[:, 4]).min() > -1e-12  # friction never gives
    stores, work, heat, dampers = np.split(energy[:, :6], [3, 4, 5], axis=1)
    kept = stores.sum(axis=1) - stores[0].sum()
    return float(np.abs(kept - (work - heat - dampers).ravel()).max())


@pytest.mark.parametrize(
    "how",
    [{}, {"drive": "servo", "servo": sn.Servo(), "limp": (3,), "incline_rad": 0.1}],
    ids=["angles", "servos, limp, on a slope"],
)
def test_springs_with_sticking_wheels_keep_the_energy_to_order_2(how: dict[str, Any]) -> None:
    coarse = replace(
        SOFT, record=("energy",), joint_stiffness_n_m=1e3, dt_s=2e-4, duration_s=0.5, **how
    )
    off, less = balance(coarse), balance(replace(coarse, dt_s=1e-4))
    assert off < 5e-3
    assert 3.0 < off / less < 6.0


def test_a_zigzag_shortens_until_friction_has_its_energy() -> None:
    """Angles +-a move no centre but along, by L a^2/2 a link: 2 T a = ft0 L (9 a^2/2), at rest."""
    torque = 1e-5
    scene = replace(SCENES["torque"], torque=[torque, 0, 0, 0, 0], gait=sn.Gait(0.0, 0.0, 1.0))
    run = sn.simulate(scene)
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


@pytest.mark.parametrize(
    ("kind", "seed", "tolerance"),
    [("servo", 1003, 1e-3), ("servo", 1004, 1e-8), ("servo", 1023, 1e-6), ("full", 1017, 1e-3)],
)
def test_free_joints_run_to_the_end(kind: str, seed: int, tolerance: float) -> None:
    """Explicit steps give way to implicit ones at a frame; wheels hold each other on gears."""
    run = sn.simulate(replace(tc.free_case(kind, seed), tolerance=tolerance))
    assert run.t_s[-1] == pytest.approx(0.6)


def test_wheels_that_hold_each_other_are_held_at_once() -> None:
    """Nearly all wheels rest at .95 s, more than are needed: shares within rounding hold them."""
    held = replace(SCENE, drive="torque", torque=TORQUE, gait=gait_in_deg(30, 80, 5.0), record=())
    for tolerance in (1e-2, 1e-3, 1e-6):
        assert sn.simulate(replace(held, tolerance=tolerance)).steps < 150
