"""The lab's robot with servos: conserved quantities, comparison with the event-driven method."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from robots import OF_2005, gait_in_deg
from serpenoid import Servo, _core
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.floor import Floor
from serpenoid.lab.robot import LabRobot
from serpenoid.model.drives import core_servo

WHOLE_GROUND = sn.Ground(0.084, 1.2, 0.14, 0.27)
LINK_GROUND = sn.Ground.whole_body(
    6, WHOLE_GROUND.ct, WHOLE_GROUND.cn, WHOLE_GROUND.ft0, WHOLE_GROUND.fn0
)
GAIT = gait_in_deg(70, 75, math.tau * 0.5)
SERVO = Servo(
    2.3,
    0.06,
    0.39,
    7.0,
    0.004,
    armature_kg_m2=2e-3,
    gear_friction_nm=0.014,
    gear_damping_nms_rad=0.005,
    update_hz=50.0,
    supply_sag=0.04,
)
START_POSE = [0.3, -0.2, 0.1, 0.4, -0.3]


def chain(
    servo: Servo, friction: tuple[float, ...] = (0.0,) * 6, rolling_kg: float = 0.0
) -> _core.LabChain:
    rows = np.array([[*friction, rolling_kg, 1.0]] * 6)
    robot = _core.LabChain(0.0756, 0.076, OF_2005.inertia_kg_m2, rows, core_servo(servo))
    robot.set_joints(START_POSE)
    robot.place(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return robot


def oscillating_setpoints(frames: int) -> np.ndarray:
    """Return setpoints, rad, that oscillate and begin at START_POSE."""
    t = 0.02 * np.arange(frames)[:, None]
    return np.array(START_POSE) + 0.8 * np.sin(6 * t + np.arange(5)) - 0.8 * np.sin(np.arange(5))


def simulated_speed(
    servo: Servo, cycles: int, last_cycles: int, ground=LINK_GROUND, gait=GAIT
) -> float:
    """Return the mean speed, m/s, of the last cycles in the event-driven simulation."""
    run = sn.simulate(
        sn.Scene(
            OF_2005,
            ground,
            gait,
            drive="servo",
            servo=servo,
            method="nonsmooth",
            start="zero_momentum",
            dt_s=gait.period_s / 100,
            duration_s=cycles * gait.period_s,
            record_every=100,
            tolerance=1e-6,
        )
    )
    x_m = run.x_m.mean(1)[-1 - last_cycles :]
    y_m = run.y_m.mean(1)[-1 - last_cycles :]
    return float(np.hypot(np.diff(x_m), np.diff(y_m)).mean()) / gait.period_s


@pytest.mark.parametrize("rolling_kg", [0.0, 0.02])
def test_momentum_and_energy_without_friction(rolling_kg: float) -> None:
    """The error of the energy halves with the step; wheels with inertia push the ground."""
    frictionless = replace(SERVO, gear_friction_nm=0.0)
    energy_error = []
    for steps in (20, 40, 80):
        robot = chain(frictionless, rolling_kg=rolling_kg)
        rows = robot.follow(oscillating_setpoints(37), 0.02, 0.02 / steps)
        centre = np.abs(rows[:, :2]).max()  # the ground pushes only wheels with inertia
        assert centre > 1e-3 if rolling_kg else centre < 2e-3 / steps
        energy_error.append(abs(robot.work_j - robot.kinetic_j) / robot.kinetic_j)
    assert energy_error[0] < 0.1
    assert energy_error[2] < 0.35 * energy_error[0]


def test_speed_on_ratchets_equals_the_event_driven_simulation() -> None:
    """All joints have the same phase, so that only the ratchets drive the robot forwards."""
    ratchet = sn.Ground(
        (LINK_GROUND.ct, 4 * LINK_GROUND.ct),
        LINK_GROUND.cn,
        (LINK_GROUND.ft0, 3 * LINK_GROUND.ft0),
        LINK_GROUND.fn0,
    )
    gait = replace(GAIT, alpha_rad=math.radians(60), beta_rad=0.0)
    lab = crawl_speed(LabRobot(OF_2005, (ratchet,), servo=SERVO), gait)
    assert lab == pytest.approx(simulated_speed(SERVO, 8, 4, ratchet, gait), rel=0.006)
    assert crawl_speed(LabRobot(OF_2005, (LINK_GROUND,), servo=SERVO), gait) < 1e-3 * lab


def test_speed_of_a_servo_without_load() -> None:
    """At full duty the motor balances the gear friction; the supply sags with the current."""
    servo = Servo(
        5.0,
        0.0,
        0.39,
        7.0,
        0.0,
        armature_kg_m2=0.02,
        gear_friction_nm=0.05,
        gear_damping_nms_rad=0.03,
        supply_sag=0.5,
    )
    rows = np.array([[0.0] * 7 + [1.0]] * 2)
    pair = _core.LabChain(0.0756, 0.076, OF_2005.inertia_kg_m2, rows, core_servo(servo))
    angle_rad = np.diff(pair.follow(np.full((150, 1), 1e3), 0.02, 1e-3)[:, 2:], axis=1)[:, 0]
    # Balance: T V - friction = (T / w0 + damping) r with V = 1 - sag (V - r / w0)
    slope = 0.39 / 7.0 + 0.03 - 0.39 * (0.5 / 7.0) / 1.5
    rate = (0.39 / 1.5 - 0.05) / slope
    assert (angle_rad[-1] - angle_rad[-26]) / 0.5 == pytest.approx(rate, rel=0.003)


def test_wheels_at_rest_hold_up_to_the_breakaway_force() -> None:
    """A slope pulls with 1.15 times the dry friction: ratio 1.3 holds the robot, 1.1 does not."""
    slope = math.asin(1.15 * WHOLE_GROUND.ft0 / (6 * OF_2005.link_mass_kg * 9.81))
    displacement_m = []
    for breakaway in (1.1, 1.3):
        robot = LabRobot.whole_body(OF_2005, WHOLE_GROUND, servo=SERVO, breakaway=breakaway)
        track, _ = Floor(robot, slope).follow(np.zeros((50, 5)), SERVO.frame_s)
        displacement_m.append(float(track.x_m[-1]))
    assert displacement_m[0] > 0.01
    assert abs(displacement_m[1]) < 1e-6


def test_stiff_servos_with_short_frames_equal_imposed_angles() -> None:
    stiff = Servo(30.0, 0.6, 1e3, 1e3, 0.0, frame_s=2e-3, armature_kg_m2=1e-3)
    ideal = crawl_speed(LabRobot.whole_body(OF_2005, WHOLE_GROUND), GAIT)
    driven = crawl_speed(LabRobot.whole_body(OF_2005, WHOLE_GROUND, servo=stiff), GAIT)
    assert driven == pytest.approx(ideal, rel=0.01)
