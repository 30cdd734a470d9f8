"""Robots, gaits and servos at random, and the speed that the full simulation gives them."""

from __future__ import annotations

import math

import numpy as np
import serpenoid as sn


def drawn_case(seed: int) -> tuple[sn.Robot, sn.Ground, sn.Gait, sn.Servo]:
    """Return a robot, ground, gait and servo at random; the servo fits the robot's size."""
    rng = np.random.default_rng(seed)

    def about(middle: float, factor: float) -> float:
        return middle * factor ** rng.normal()

    links, mass, length = int(rng.integers(4, 9)), about(0.08, 1.6), about(0.08, 1.3)
    dry = mass * 9.81
    ground = sn.Ground(
        about(0.014, 2),
        about(0.3, 2),
        dry * about(0.03, 1.6) * (rng.random() < 0.9),
        dry * about(0.1, 2) * (rng.random() < 0.95),
    )
    alpha, beta = math.radians(rng.uniform(20, 80)), math.radians(rng.uniform(40, 110))
    gait = sn.Gait(alpha, beta, math.tau * 0.2 * 10 ** rng.uniform(0, 1))
    torque, speed = about(0.4, 1.6) * mass * links * length / 0.036, about(8.0, 1.3)
    line = torque / speed
    servo = sn.Servo(
        torque / about(0.17, 1.6),
        line * (1 + rng.random()),
        torque,
        speed,
        rng.uniform(0, 0.015),
        about(0.04, 1.6) * line * (rng.random() < 0.8),
        torque * about(0.04, 2) * (rng.random() < 0.8),
        0.2 * line * rng.random(),
        float(rng.choice([0, 50, 300])),
        0.08 * rng.random(),
    )
    return sn.Robot(links, mass, length), ground, gait, servo


def mean_speed(run: sn.Run, of_a_cycle: int) -> float:
    """Return the speed of one cycle of a run with 200 rows each, along its mean circle."""
    rows = slice(200 * of_a_cycle, 200 * of_a_cycle + 201)
    turn = np.ptp(run.theta_rad[rows, 0][[0, -1]]) * np.sign(
        run.theta_rad[rows, 0][-1] - run.theta_rad[rows, 0][0]
    )
    angle = turn * (np.arange(200) + 0.5) / 200
    dx, dy = np.diff(run.x_m[rows].mean(1)), np.diff(run.y_m[rows].mean(1))
    along = np.sum((dx + 1j * dy) * np.exp(-1j * angle))
    return float(abs(along) / (run.t_s[rows][-1] - run.t_s[rows][0]))


def full_speeds(
    ideal: sn.Steady, servo: sn.Servo, keep: int, seconds: float = 60.0
) -> tuple[np.ndarray, float]:
    """Return the speeds of the last cycles of a full simulation, and how they still drift."""
    robot, ground, gait = ideal.robot, ideal.ground, ideal.gait
    start = sn.simulate(sn.Scene(robot, ground, gait, start="steady", duration_s=0.0)).state(0)
    settle = max(2, math.ceil(min(5 * ideal.settling_time_s + 6, seconds) / gait.period_s))
    rough = not ground.smooth or servo.gear_friction_nm > 0
    run = sn.simulate(
        sn.Scene(
            robot,
            ground,
            gait,
            drive="servo",
            servo=servo,
            start=start,
            tolerance=1e-6,
            method="nonsmooth" if rough else "dop853",
            dt_s=gait.period_s / 200,
            duration_s=(settle + keep) * gait.period_s,
            record_every=1,
        )
    )
    speeds = np.array([mean_speed(run, settle + k) for k in range(keep)])
    half = keep // 2
    return speeds, float(speeds[half:].mean() - speeds[:half].mean())
