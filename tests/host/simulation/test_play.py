"""Runs in time of gears with play: rotors and links turn apart, and teeth push."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from periodic.servo_cases import full_speeds
from refusals import refused
from robots import BINGHAM, OF_2005, gait_in_deg

FREE = sn.Ground(0.0, 0.0)
GAIT = gait_in_deg(70, 75, math.tau * 0.5)
STILL = sn.Gait(0.0, 1.0, 1.0)
SERVO = replace(sn.servo("MG996R").servo, update_hz=0.0, dead_band_rad=0.0)


def loose(play_deg: float, **more: float) -> sn.Servo:
    """Return the servo with play."""
    return replace(SERVO, backlash_rad=math.radians(play_deg), **more)


def run_of(servo: sn.Servo, ground: sn.Ground = BINGHAM, gait: sn.Gait = GAIT, **more) -> sn.Run:
    """Return a run of servos; its method is the scene's own choice."""
    given = {"duration_s": 1.0, "start": "zero_momentum", "dt_s": 2e-3} | more
    return sn.simulate(sn.Scene(OF_2005, ground, gait, drive="servo", servo=servo, **given))


def test_a_spinning_chain_opens_its_joints_by_the_play_and_no_further() -> None:
    """Rotors too heavy to turn: what spins falls outwards from tooth to tooth, and stays there."""
    held = loose(4.0, armature_kg_m2=1e4, gear_friction_nm=0.0, dead_band_rad=1.0)
    bend = 0.3 * np.arange(6)
    start = sn.LinkState.joined(OF_2005, [0, 0, *bend], [0, 0, *[6.0] * 6])
    run = run_of(held, FREE, STILL, start=start)
    opened = 0.3 - np.diff(run.theta_rad, axis=1)
    assert opened.max() == pytest.approx(math.radians(2.0), rel=0.02)
    assert opened[-1] == pytest.approx(np.full(5, math.radians(2.0)), rel=0.02)
    rates = np.abs(np.diff(run.omega_rad_s, axis=1))
    assert rates[-1].max() < 0.02 * rates.max()  # teeth take the bounce


def test_teeth_push_both_sides_alike() -> None:
    """Links without ground keep their momentum, and gain the energy that the teeth give them."""
    run = run_of(loose(2.0), FREE, record=("energy",), tolerance=1e-8)
    m, inertia = OF_2005.link_mass_kg, OF_2005.inertia_kg_m2
    x, y = (p - p.mean(axis=1, keepdims=True) for p in (run.x_m, run.y_m))
    spin = m * (x * run.vy_m_s - y * run.vx_m_s).sum(axis=1) + inertia * run.omega_rad_s.sum(axis=1)
    size = m * (x**2 + y**2).sum(axis=1).max() * GAIT.omega_rad_s
    assert np.ptp(spin) < 1e-6 * size
    assert np.ptp(run.vx_m_s.sum(axis=1)) < 1e-6
    gained, given = run.energy_j[:, 0] - run.energy_j[0, 0], run.energy_j[:, 3]
    # the ledger chooses no steps: it is off by 1.5e-5 of what was gained
    assert gained == pytest.approx(given, abs=3e-5 * gained.max())


def test_the_speed_is_that_of_the_quick_state() -> None:
    """Which has other coordinates and teeth that are rigid; 2.5 degrees halve the speed.

    With 2 or 3 degrees the motion is irregular, and mostly settles to no speed.
    """
    servo = loose(2.5)
    quick = sn.steady_gait(OF_2005, BINGHAM, GAIT, rtol=1e-3, servo=servo)
    full, _ = full_speeds(quick.ideal, servo, keep=2, seconds=6)
    assert quick.speed_m_s == pytest.approx(full.mean(), rel=0.04)  # cycles differ by 2 %


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (
            {"method": "rk4"},
            "'rk4' with formulation 'explicit' does not run gears with play.*take "
            "method 'nonsmooth'",
        ),
        ({"formulation": "implicit", "method": "nonsmooth"}, "take formulation 'explicit'"),
        ({"formulation": "implicit"}, "take formulation 'explicit' without smoothing_m_s"),
        ({"smoothing_m_s": 0.01}, "take formulation 'explicit' without smoothing_m_s"),
    ],
)
def test_methods_without_play_are_refused_with_a_way_out(more: dict, says: str) -> None:
    with refused(says):
        run_of(loose(1.0), **more)


def test_a_limp_joint_has_no_servo_and_a_locked_one_stays() -> None:
    run = run_of(loose(1.0), limp=(2,), locked={4: 0.1}, duration_s=0.2, record=("joints",))
    assert np.abs(run.joint_torque_nm[:, 1]).max() == 0
    assert np.diff(run.theta_rad, axis=1)[:, 3] == pytest.approx(np.full(len(run.t_s), 0.1))
