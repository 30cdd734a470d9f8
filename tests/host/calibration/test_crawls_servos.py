"""Servos that crawls tell: drawn anew near those that explain what was seen."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import TRUTH, floor_setup
from serpenoid.calibration.crawls.data import CrawlData
from serpenoid.calibration.crawls.servos import (
    GRAIN,
    ServoEffects,
    effects_of,
)
from serpenoid.calibration.crawls.slope import sloped_speed
from serpenoid.calibration.friction_result import Estimate, ground_of
from serpenoid.calibration.speed_samples import scaled
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.robot import LabRobot
from serpenoid.model.drives import Servo
from serpenoid.model.gait import Gait
from serpenoid.servos.catalogue import HOBBY

ROBOT = floor_setup().robot
GROUND = ground_of(ROBOT.links, TRUTH)
FAST = Gait(math.radians(80), math.radians(75), 2 * math.pi * 0.8)
SEEN = np.array([0.62, 0.55])  # a weak servo, of which few are drawn


def moved(servos):
    """Return what servos do to two gaits in a world of closed form: no solver, weak ones fail."""
    speed, torque = (
        np.array([getattr(s, n) for s in servos]) for n in ("speed_limit_rad_s", "torque_limit_nm")
    )
    weak = np.stack([1.0 / (1.0 + np.exp(2.5 - 0.6 * speed)), np.tanh(1.6 * torque**0.7)], axis=1)
    return ServoEffects(tuple(servos), np.ones((len(servos), 2)), weak)


def off(effects):
    return (effects.amplitude - SEEN) / 0.01


def test_a_weak_servo_does_not_follow_a_larger_amplitude() -> None:
    """What a servo does to joints 3 % further, from its powers, against its own state there."""
    weak = replace(HOBBY.servo, speed_limit_rad_s=4.0)
    here = effects_of(ROBOT, GROUND, (FAST,), [True], (weak,))
    there = effects_of(ROBOT, GROUND, (scaled(FAST, 1.03),), [True], (weak,))
    assert here.amplitude[0, 0] < 0.8
    gains, shares = here.gains(np.array([1.03])), here.shares(np.array([1.03]))
    assert gains[0, 0, 0] == pytest.approx(1.03 * there.amplitude[0, 0], rel=2e-3)
    assert shares[0, 0, 0] == pytest.approx(there.share[0, 0], rel=GRAIN)
    assert abs(gains[0, 0, 0] / here.amplitude[0, 0] - 1.03) > 0.01  # not as ideal joints would


def test_a_slope_acts_on_joints_as_they_were_filmed() -> None:
    """Joints that made 0.7 of their amplitude: a slope slows them more than commanded ones."""
    asked = Gait(math.radians(70), math.radians(60), 2 * math.pi * 0.8)
    gait = replace(asked, joint_gain=(0.7,) * 5, joint_shift_rad=(0.0,) * 5)
    data = CrawlData(
        (gait,),
        np.array([0.1]),
        np.array([0.001]),
        np.ones(1, bool),
        ((1,),),
        (asked,),
        np.array([0.7]),
        np.array([0.003]),
        ((1.0, 0.0),),
    )
    level = data.on_slope(ROBOT, GROUND, Estimate(0.003, 1e-6)).speed_m_s[0]
    slower, commanded = (
        sloped_speed(ROBOT, GROUND, g, -0.003) / sloped_speed(ROBOT, GROUND, g, 0.0)
        for g in (gait, asked)
    )
    assert level == pytest.approx(0.1 / slower, rel=1e-6)
    assert abs(slower - 1.0) > 1.5 * abs(commanded - 1.0)


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
    gait, slope = Gait(math.radians(70), math.radians(60), 2 * math.pi * 0.8), 0.005
    lab = LabRobot(ROBOT, (GROUND,), servo=weak)
    there, level = (crawl_speed(lab, gait, slope_rad=s) for s in (-slope, 0.0))
    back = crawl_speed(lab, gait, slope_rad=slope)
    data = CrawlData(
        (gait, gait),
        np.array([there, back]),
        np.full(2, 0.001),
        np.zeros(2, bool),
        ((1,), (2,)),
        (gait, gait),
        ways=((1.0, 0.0), (0.0, 1.0)),
    )
    known = Estimate(slope, 1e-6)
    put_right = data.on_slope(ROBOT, GROUND, known, weak).speed_m_s
    assert put_right == pytest.approx([level, level], rel=0.02)
    ideal = data.on_slope(ROBOT, GROUND, known).speed_m_s
    assert np.ptp(ideal) > 0.05 * level
