"""One joint of the lab's robot, tested: a light camera, or a film of 240 frames a second."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import serpenoid as sn
from robots import OF_2005
from serpenoid import _core
from serpenoid.model.drives import core_servo
from serpenoid.servos.bench_test import BenchTest

ROBOT = OF_2005
SENT = np.repeat([0.0, 0.8, 0.1, 0.15, -0.6, -0.62, 0.0], 15)
# kg m^2, of two free links on one joint: (I + m l^2 (1 - cos angle) / 4) / 2 is 1.8e-5 to 3.5e-5
OWN_INERTIA = 2.2e-5
NOISE_RAD = math.radians(0.3)
_TICK_S = 1 / 1200  # 24 in a frame of 20 ms, 5 in a picture of 240 a second


def _angles(servo: sn.Servo, setpoints: np.ndarray) -> np.ndarray:
    """Return the joint's angle after each of the servo's frames, rad, from 0 on."""
    links = np.array([[1e3, 1e3, 0, 0, 1e3, 0, 0, 1], [0, 0, 0, 0, 0, 0, 0, 1.0]])
    joint = _core.DrivenChain(0.0756, 0.076, ROBOT.inertia_kg_m2, links, core_servo(servo))
    joint.place(0.0, [0.0])
    rows = joint.drive(np.ascontiguousarray(setpoints[:, None]), 40)
    return np.append(0.0, rows[:, 3] - rows[:, 2]).astype(np.float64)


def _noisy(angle: np.ndarray, seed: int, noise_rad: float) -> np.ndarray:
    noise = noise_rad * np.random.default_rng(seed).normal(size=angle.size)
    noise[0] = 0.0
    return angle + noise


def shown_by(servo: sn.Servo, seed: int) -> BenchTest:
    """Return what a camera of 50 frames a second sees of one joint, by the lab's robot."""
    angle = _noisy(_angles(servo, SENT), seed, NOISE_RAD)
    t_s = 0.02 * np.arange(len(angle))
    return BenchTest(t_s, np.append(SENT, SENT[-1]), angle, math.radians(0.4), OWN_INERTIA)


def filmed_by(servo: sn.Servo, seed: int, noise_rad: float = NOISE_RAD) -> BenchTest:
    """Return what a film of 240 frames a second shows of one joint: setpoints change in between."""
    ticks = np.repeat(SENT, 24)
    angle = _angles(replace(servo, frame_s=_TICK_S), ticks)
    t_s = _TICK_S * np.arange(angle.size)
    changes = np.arange(0, ticks.size, 24)
    rows = np.union1d(np.arange(0, angle.size, 5), changes)
    seen = np.interp(t_s, t_s[::5], _noisy(angle[::5], seed, noise_rad))  # at pictures: as seen
    setpoint = np.append(ticks, ticks[-1])
    return BenchTest(t_s[rows], setpoint[rows], seen[rows], math.radians(0.4), OWN_INERTIA)
