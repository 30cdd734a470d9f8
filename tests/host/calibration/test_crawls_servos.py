"""What servos and slopes do to crawls."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import TRUTH, floor_setup
from robots import gait_in_deg
from serpenoid import Servo
from serpenoid.calibration.crawls.level import on_level, sloped_speed
from serpenoid.calibration.friction_result import Estimate, ground_of
from serpenoid.calibration.speeds import GRAIN, SpeedModel, scaled, speed
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.robot import LabRobot
from serpenoid.servos.catalogue import HOBBY
from serpenoid.session.gait_run import GaitRun
from simulated_sessions import MemoryRecord

ROBOT = floor_setup().robot
GROUND = ground_of(ROBOT.links, TRUTH)
LEVEL = Estimate(0.0, 1e-6)
FAST = gait_in_deg(80, 75, 2 * math.pi * 0.8)


def test_a_weak_servo_does_not_follow_a_larger_amplitude() -> None:
    """What a servo does to joints 3 % further, from its powers, against its own state there."""
    weak = replace(HOBBY.servo, speed_limit_rad_s=4.0)
    here, there = (
        SpeedModel(ROBOT, GROUND, (gait,), (gait,)).effects((weak,))
        for gait in (FAST, scaled(FAST, 1.03))
    )
    assert here.amplitude[0, 0] < 0.8
    gains, shares = here.gains(np.array([1.03])), here.shares(np.array([1.03]))
    assert gains[0, 0, 0] == pytest.approx(1.03 * there.amplitude[0, 0], rel=2e-3)
    assert shares[0, 0, 0] == pytest.approx(there.share[0, 0], rel=GRAIN)
    assert abs(gains[0, 0, 0] / here.amplitude[0, 0] - 1.03) > 0.01  # not as ideal joints would


@pytest.mark.parametrize("servo", [HOBBY.servo, Servo()], ids=["hobby", "too quick for long steps"])
def test_a_crawl_up_no_slope_is_the_periodic_state(servo: Servo) -> None:
    found, _ = sloped_speed(ROBOT, GROUND, FAST, (0.0, 0.0), servo)
    assert found == pytest.approx(speed(ROBOT, GROUND, FAST, servo), rel=0.01)


def test_a_slope_with_a_weak_servo_is_that_of_the_lab() -> None:
    """The lab has its own servos, steps and contacts; joints as filmed feel half of the slope."""
    weak = Servo(
        stiffness_nm_rad=3.43,
        damping_nms_rad=0.0876,
        torque_limit_nm=0.435,
        speed_limit_rad_s=4.96,
        dead_band_rad=0.003,
        armature_kg_m2=0.0015,
        gear_friction_nm=0.011,
        gear_damping_nms_rad=0.0044,
        update_hz=50.0,
        supply_sag=0.07,
    )
    gait, slope = gait_in_deg(70, 60, 2 * math.pi * 0.8), 0.005
    lab = LabRobot(ROBOT, (GROUND,), servo=weak)
    there, level = (crawl_speed(lab, gait, slope_rad=s) for s in (-slope, 0.0))
    back = crawl_speed(lab, gait, slope_rad=slope)
    runs = tuple(
        GaitRun(k, gait.alpha_rad, gait.beta_rad, gait.omega_rad_s, v, 0.001, way=way)
        for k, (v, way) in enumerate(((there, "there"), (back, "back")), 1)
    )
    session = replace(MemoryRecord(floor_setup()).session, gait_runs=runs)
    known = Estimate(slope, 1e-6), LEVEL
    moved, ideal = (
        [run.speed_m_s for run in on_level(session, ROBOT, GROUND, known, by).gait_runs]
        for by in (weak, None)
    )
    assert moved == pytest.approx([level, level], rel=0.02)
    assert np.ptp(ideal) > 0.05 * level
