"""The lab's servo-driven robot: conserved quantities, the event-driven simulation."""

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

WHOLE = sn.Ground(0.084, 1.2, 0.14, 0.27)
EACH = sn.Ground.whole_body(6, WHOLE.ct, WHOLE.cn, WHOLE.ft0, WHOLE.fn0)
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
STILL = [0.3, -0.2, 0.1, 0.4, -0.3]


def chain(
    servo: Servo, friction: tuple[float, ...] = (0.0,) * 6, rolling_kg: float = 0.0
) -> _core.LabChain:
    rows = np.array([[*friction, rolling_kg, 1.0]] * 6)
    made = _core.LabChain(0.0756, 0.076, OF_2005.inertia_kg_m2, rows, core_servo(servo))
    made.set_joints(STILL)
    made.place(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return made


def swing(frames: int) -> np.ndarray:
    """Setpoints that swing from where the chain stands."""
    t = 0.02 * np.arange(frames)[:, None]
    return np.array(STILL) + 0.8 * np.sin(6 * t + np.arange(5)) - 0.8 * np.sin(np.arange(5))


def full_speed(servo: Servo, cycles: int, keep: int, ground=EACH, gait=GAIT) -> float:
    """Return the mean speed of the last cycles by the event-driven simulation."""
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
    x, y = run.x_m.mean(1)[-1 - keep :], run.y_m.mean(1)[-1 - keep :]
    return float(np.hypot(np.diff(x), np.diff(y)).mean()) / gait.period_s


@pytest.mark.parametrize("rolling_kg", [0.0, 0.02])
def test_without_friction_momentum_stays_and_servos_work_becomes_motion(rolling_kg: float) -> None:
    """Each halving of the step halves what is missing of the energy; wheels turn with the links."""
    frictionless = replace(SERVO, gear_friction_nm=0.0)
    missing = []
    for steps in (20, 40, 80):
        robot = chain(frictionless, rolling_kg=rolling_kg)
        rows = robot.follow(swing(37), 0.02, 0.02 / steps)
        centre = np.abs(rows[:, :2]).max()  # it stays unless the ground turns wheels
        assert centre > 1e-3 if rolling_kg else centre < 2e-3 / steps
        missing.append(abs(robot.work_j - robot.kinetic_j) / robot.kinetic_j)
    assert missing[0] < 0.1
    assert missing[2] < 0.35 * missing[0]


def test_it_crawls_on_ratchets_as_fast_as_the_event_driven_simulation() -> None:
    """All joints in phase: it is the ratchets alone that drive the robot ahead."""
    ratchet = sn.Ground((EACH.ct, 4 * EACH.ct), EACH.cn, (EACH.ft0, 3 * EACH.ft0), EACH.fn0)
    gait = replace(GAIT, alpha_rad=math.radians(60), beta_rad=0.0)
    lab = crawl_speed(LabRobot(OF_2005, (ratchet,), servo=SERVO), gait)
    assert lab == pytest.approx(full_speed(SERVO, 8, 4, ratchet, gait), rel=0.006)
    assert crawl_speed(LabRobot(OF_2005, (EACH,), servo=SERVO), gait) < 1e-3 * lab


def test_a_servo_that_runs_free_turns_as_fast_as_its_motors_line_says() -> None:
    """Full duty, no load: torque and gear balance at a supply that sags under the current."""
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
    turned = np.diff(pair.follow(np.full((150, 1), 1e3), 0.02, 1e-3)[:, 2:], axis=1)[:, 0]
    # by hand: T V - friction = (T / w0 + damping) r with V = 1 - sag (V - r / w0)
    slope = 0.39 / 7.0 + 0.03 - 0.39 * (0.5 / 7.0) / 1.5
    rate = (0.39 / 1.5 - 0.05) / slope
    assert (turned[-1] - turned[-26]) / 0.5 == pytest.approx(rate, rel=0.003)


def test_wheels_that_rest_hold_up_to_the_break_away() -> None:
    """On a slope that pulls 1.15 times the dry force: held by 1.3 times that, not by 1.1."""
    slope = math.asin(1.15 * WHOLE.ft0 / (6 * OF_2005.link_mass_kg * 9.81))
    gone = []
    for breakaway in (1.1, 1.3):
        robot = LabRobot.whole_body(OF_2005, WHOLE, servo=SERVO, breakaway=breakaway)
        track, _ = Floor(robot, slope).follow(np.zeros((50, 5)), SERVO.frame_s)
        gone.append(float(track.x_m[-1]))
    assert gone[0] > 0.01
    assert abs(gone[1]) < 1e-6


def test_a_stiff_servo_on_quick_frames_is_a_robot_whose_joints_follow() -> None:
    stiff = Servo(30.0, 0.6, 1e3, 1e3, 0.0, frame_s=2e-3, armature_kg_m2=1e-3)
    ideal = crawl_speed(LabRobot.whole_body(OF_2005, WHOLE), GAIT)
    driven = crawl_speed(LabRobot.whole_body(OF_2005, WHOLE, servo=stiff), GAIT)
    assert driven == pytest.approx(ideal, rel=0.01)
