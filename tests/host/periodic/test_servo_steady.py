"""Speeds with servos: against the full simulation, which steps from event to event; limits."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from periodic.servo_cases import drawn_case, full_speeds
from refusals import refused
from robots import BINGHAM, OF_2005, gait_in_deg
from serpenoid.periodic.servo_steady import band, ripple_share, servo_speed, with_servo

GAIT = gait_in_deg(70, 75, math.tau * 0.5)
VISCOUS = sn.Ground(0.1, 1.0)


def solved(seed: int) -> sn.ServoSteady:
    robot, ground, gait, servo = drawn_case(seed)
    return sn.steady_gait(robot, ground, gait, rtol=1e-4, servo=servo)


@pytest.mark.parametrize("seed", [4, 11, 14, 21, 28, 34])
def test_the_speed_is_that_of_the_full_simulation(seed: int) -> None:
    """Other coordinates, other steps, other contacts: what both share is the servo's law alone."""
    found = solved(seed)
    speeds, _ = full_speeds(found.ideal, drawn_case(seed)[3], keep=4)
    assert found.speed_m_s == pytest.approx(speeds.mean(), rel=0.01)
    assert found.error_estimate < 0.05


@pytest.mark.parametrize(("seed", "keep"), [(2198, 4), (4096, 24)])
def test_what_is_hard_to_tell_has_an_honest_error(seed: int, keep: int) -> None:
    """A five-hundredth of what the joints could give; loops whose hunting outlasts a cycle."""
    found = solved(seed)
    speeds, _ = full_speeds(found.ideal, drawn_case(seed)[3], keep)
    assert found.speed_m_s == pytest.approx(speeds.mean(), rel=0.02)
    assert abs(found.speed_m_s / speeds.mean() - 1) < found.error_estimate < 0.05


def test_a_speed_that_hangs_on_the_start_is_none() -> None:
    """Full simulations go on at 0.004 or 0.021 m/s, by the phase of the frames alone."""
    with pytest.raises(sn.NotConverged, match=r"not defined.* at 0\.004\d? to 0\.021 m/s"):
        solved(4269)


def test_a_motor_near_its_limits_is_as_slow_as_the_sines_that_it_makes() -> None:
    """Its middle joint lags 12 degrees more than the mean one; a ripple takes little beside."""
    weak = sn.Servo(
        stiffness_nm_rad=0.346,
        damping_nms_rad=0.0161,
        torque_limit_nm=0.0997,
        speed_limit_rad_s=6.21,
        dead_band_rad=0.007,
        armature_kg_m2=4.2e-4,
        gear_friction_nm=0.003,
        gear_damping_nms_rad=4.8e-4,
        supply_sag=0.04,
    )
    ideal = sn.steady_gait(OF_2005, BINGHAM, gait_in_deg(70, 60, math.tau * 0.8), rtol=1e-4)
    assert servo_speed(ideal, weak) < 0.95 * ideal.speed_m_s
    assert ripple_share(ideal, weak) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("ground", [BINGHAM, VISCOUS], ids=["dry", "viscous"])
def test_a_perfect_servo_has_the_ideal_speed(ground: sn.Ground) -> None:
    """Slow, strong, on frames of .5 ms: joints follow the gait, 20 ms late."""
    perfect = sn.Servo(30.0, 0.6, 1e3, 1e3, 0.0, frame_s=5e-4)
    found = sn.steady_gait(OF_2005, ground, GAIT, servo=perfect)
    assert found.speed_m_s == pytest.approx(found.ideal.speed_m_s, rel=0.01)
    assert found.amplitude_ratio == pytest.approx(1, rel=3e-3)
    late = GAIT.omega_rad_s * (perfect.frame_s / 2 + 0.6 / 30)
    assert found.lag_rad == pytest.approx(late, rel=0.05)
    assert found.power_w == pytest.approx(found.ideal.power_w, rel=0.02)


def test_an_uncertain_kind_leaves_a_band_around_its_typical_speed() -> None:
    found = with_servo(sn.steady_gait(OF_2005, BINGHAM, GAIT), sn.servo("XL-330"), draws=80)
    assert found.low_m_s < found.speed_m_s < found.high_m_s < 1.05 * found.ideal.speed_m_s
    assert len(found.samples_m_s) == 80
    within = [found.low_m_s <= speed <= found.high_m_s for speed in found.samples_m_s]
    assert np.mean(within) == pytest.approx(0.95, abs=0.03)  # of 80 two lie beyond, or four
    assert set(found.to_dict()) >= {"speed_m_s", "low_m_s", "high_m_s", "spread_m_s"}


def test_a_gait_faster_than_the_no_load_speed_has_no_band() -> None:
    """70 degrees at 1 Hz ask for 7.68 rad/s, a typical hobby servo turns at 6.98 with 6 V."""
    quick = replace(GAIT, omega_rad_s=math.tau)
    hobby = sn.servo().at_volts(6.0)
    found = with_servo(sn.steady_gait(OF_2005, VISCOUS, quick), hobby, draws=2)
    assert found.joint_rate_over_no_load == pytest.approx(7.676 / 6.981, rel=1e-3)
    assert not found.follows
    assert not found.samples_m_s
    assert found.to_dict()["low_m_s"] is found.to_dict()["high_m_s"] is None
    # 0.9 of 6.98 rad/s over 70 degrees
    assert found.highest_hz == pytest.approx(0.9 * 6.981 / math.radians(70) / math.tau, rel=1e-3)
    exact = replace(found, servo=hobby.servo.at_volts(8.0))
    assert exact.follows
    assert exact.joint_rate_over_no_load < 0.9
    gained = replace(found.ideal.gait, joint_gain=(1.0, 1.0, 1.3, 1.0, 1.0))
    more = replace(exact, ideal=replace(found.ideal, gait=gained))
    assert not more.follows


def test_servos_too_weak_for_the_robot_have_no_band() -> None:
    """Millimetres typed for metres: a millionth of the torque that its links ask for."""
    long = sn.Robot(6, OF_2005.link_mass_kg, 1000 * OF_2005.link_length_m)
    found = with_servo(sn.steady_gait(long, VISCOUS, GAIT), sn.servo("hobby"))
    assert found.amplitude_ratio < 0.2
    assert not found.follows
    assert not found.samples_m_s


def test_the_power_is_what_the_full_simulation_gives_the_joints() -> None:
    """The gears' dry friction takes more of the motors' than the ground does."""
    servo = replace(sn.servo().servo, gear_friction_nm=0.04)
    found = sn.steady_gait(OF_2005, BINGHAM, GAIT, rtol=1e-3, servo=servo)
    scene = sn.Scene(OF_2005, BINGHAM, GAIT, start="steady", duration_s=0.0)
    run = sn.simulate(
        sn.Scene(
            OF_2005,
            BINGHAM,
            GAIT,
            drive="servo",
            servo=servo,
            start=sn.simulate(scene).state(0),
            duration_s=6.0,
            method="nonsmooth",
            dt_s=0.02,
            record=("energy",),
        )
    )
    work, late = run.energy_j[:, 3], np.searchsorted(run.t_s, 2.0 - 1e-9)
    full = (work[-1] - work[late]) / (run.t_s[-1] - run.t_s[late])
    assert found.power_w == pytest.approx(full, rel=0.01)


def test_the_bands_ends_leave_as_many_servos_as_they_say() -> None:
    rng = np.random.default_rng(1)
    held = []
    for _ in range(600):
        low, high = band(rng.normal(size=128))
        held += [low <= rng.normal() <= high for _ in range(4)]
    assert np.mean(held) == pytest.approx(0.95, abs=0.015)
    assert band(np.full((3, 1), 3.0)) == pytest.approx((3.0, 3.0))


def test_what_is_no_servo_is_refused() -> None:
    with refused(r"servo is a str; it must be a serpenoid\.Servo or"):
        sn.steady_gait(OF_2005, BINGHAM, GAIT, servo="SG90")  # type: ignore[call-overload]


def interrupted_after(seconds: float, work: Callable[[], object]) -> float:
    """Return how long after Ctrl-C, given so many seconds from now, the work ends, s."""
    timer = threading.Timer(seconds, lambda: os.kill(os.getpid(), signal.SIGINT))
    begin_s = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        work()
    return time.monotonic() - begin_s - seconds


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends the process there")
def test_ctrl_c_ends_a_servo_state_of_many_links_within_a_second() -> None:
    """In the typical servo's state, which takes seconds, and while servos are drawn in threads."""
    many = sn.steady_gait(
        sn.Robot(60, 0.0756, 0.076), BINGHAM, gait_in_deg(70, 75, 1.0), powers=False
    )
    assert interrupted_after(0.3, lambda: with_servo(many, sn.Servo())) < 1
    few = sn.steady_gait(sn.Robot(12, 0.0756, 0.076), BINGHAM, GAIT, powers=False)
    shares: list[float] = []
    assert interrupted_after(0.7, lambda: with_servo(few, sn.servo(), progress=shares.append)) < 1
    assert shares
