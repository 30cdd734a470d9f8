"""Sticking wheels in time: closed forms, order 2, rest that is rest, forces, slopes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005, gait_in_deg

from . import truth_cases as tc

GAIT = gait_in_deg(70, 75, 3.0)
SOFT = sn.Scene(
    OF_2005,
    BINGHAM,
    GAIT,
    formulation="implicit",
    joint_stiffness_n_m=300.0,
    method="nonsmooth",
    start="zero_momentum",
    duration_s=1.0,
)


def sliding_rod(v0: float, pull: float, kappa: float, mu: float, t: float) -> float:
    """Return the speed at t of v' = pull - kappa v - mu sgn v from v0 > 0, pull < 0."""
    rest = (mu - pull) / kappa
    stops = math.log1p(v0 / rest) / kappa
    if t < stops:
        return (v0 + rest) * math.exp(-kappa * t) - rest
    return min(0.0, pull + mu) / kappa * -math.expm1(-kappa * (t - stops))


@pytest.mark.parametrize(
    ("formulation", "incline"),
    [
        ("explicit", 0.0),
        ("explicit", 0.02),
        ("explicit", 0.4),
        ("implicit", 0.02),
        ("implicit", 0.4),
    ],
)
def test_thrown_uphill_it_stops_and_stays_or_slides_back(formulation: str, incline: float) -> None:
    """All links alike: m v' = -m g sin - ct v - ft0 sgn v, which is solved exactly."""
    straight, heading = sn.Gait(0.0, 0.0, 2.0), 0.6
    c, s = math.cos(heading), math.sin(heading)
    start = sn.LinkState.joined(OF_2005, [0.3, 0.1, *[heading] * 6], [0.5 * c, 0.5 * s, *[0.0] * 6])
    scene = sn.Scene(
        OF_2005,
        BINGHAM,
        straight,
        formulation=formulation,
        method="nonsmooth",
        dt_s=1e-3,
        incline_rad=incline,
        incline_direction_rad=heading,
        start=start,
        duration_s=2.0,
        tolerance=1e-8,
        record_every=20,
        record=("friction",),
    )
    run = sn.simulate(scene)
    m, pull = OF_2005.link_mass_kg, -9.80665 * math.sin(incline)
    wanted = [sliding_rod(0.5, pull, BINGHAM.ct / m, BINGHAM.ft0 / m, t) for t in run.t_s]
    along = tc.slips(run, run.vx_m_s, run.vy_m_s)[:, :, 0]
    # rounding; the explicit run lands on the stop within its tolerance
    within = 1e-12 if formulation == "implicit" else 1e-8
    assert along == pytest.approx(np.outer(wanted, np.ones(6)), abs=within)
    grip = tc.slips(run, run.friction_x_n, run.friction_y_n)[-1, :, 0]
    stays = incline < 0.1
    assert (wanted[-1] == 0) == stays
    holds = -m * pull if stays else BINGHAM.ft0 - BINGHAM.ct * wanted[-1]
    # how a straight chain shares its load is open: only the sum is physical
    assert grip.sum() == pytest.approx(6 * holds, abs=1e-6)


@pytest.mark.parametrize("incline", [0.0, 0.1])
@pytest.mark.parametrize("omega", [1.0, 3.0])
def test_order_two_through_sticking_and_slipping(omega: float, incline: float) -> None:
    """Events fall anywhere in a step, so single halvings scatter: the mean of five counts."""
    scene = replace(SOFT, gait=replace(GAIT, omega_rad_s=omega), incline_rad=incline)
    ends = [
        sn.simulate(replace(scene, dt_s=1 / n, record_every=n)).state().packed()
        for n in (250, 8000, 64000)
    ]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert errors[0] < 1e-3
    assert math.log2(errors[0] / errors[1]) / 5 > 1.75


def test_a_wheel_at_rest_is_at_rest() -> None:
    """No creep: what the ground holds has no speed beyond rounding, and its force obeys the law."""
    scene = replace(SOFT, gait=replace(GAIT, omega_rad_s=1.0), duration_s=3.0)
    run = sn.simulate(replace(scene, record=("friction", "joints")))
    slip = tc.slips(run, run.vx_m_s, run.vy_m_s)
    force = tc.slips(run, run.friction_x_n, run.friction_y_n)
    viscous, dry = np.array([BINGHAM.ct, BINGHAM.cn]), np.array([BINGHAM.ft0, BINGHAM.fn0])
    rests = np.abs(slip) < 1e-15
    assert 0.3 < rests[:, :, 1].mean() < 0.7
    assert np.mean((np.abs(slip) < 1e-6) & ~rests) < 1e-3  # nothing creeps
    assert (np.abs(force) <= (dry + 1e-15))[rests].all()
    slides = -(viscous * slip + dry * np.sign(slip))
    assert force[~rests] == pytest.approx(slides[~rests], abs=1e-15)


def test_explicit_forces_are_those_of_the_reference() -> None:
    """Friction, joint forces and torques against those of an event-driven dense solver."""
    scene = sn.Scene(
        OF_2005,
        BINGHAM,
        replace(GAIT, omega_rad_s=2.0),
        method="nonsmooth",
        dt_s=0.05,
        duration_s=2.0,
        tolerance=1e-9,
        record=("joints", "friction"),
        start="link1_at_rest",
    )
    run = sn.simulate(scene)
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
    stores, work, heat, dampers = np.split(energy[:, :6], [3, 4, 5], axis=1)
    kept = stores.sum(axis=1) - stores[0].sum()
    return float(np.abs(kept - (work - heat - dampers).ravel()).max())


@pytest.mark.parametrize(
    "how",
    [{}, {"drive": "servo", "servo": sn.Servo(), "limp": (3,), "incline_rad": 0.1}],
    ids=["angles", "servos, limp, on a slope"],
)
def test_springs_with_sticking_wheels_keep_the_energy_to_order_2(how) -> None:
    coarse = replace(
        SOFT, record=("energy",), joint_stiffness_n_m=1e3, dt_s=2e-4, duration_s=0.5, **how
    )
    off, less = balance(coarse), balance(replace(coarse, dt_s=1e-4))
    assert off < 5e-3
    assert 3.0 < off / less < 6.0
    heat = sn.simulate(coarse).energy_j[:, 4]
    assert np.diff(heat).min() > -1e-12  # friction never gives
