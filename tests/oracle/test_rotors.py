"""Servos' rotors and gears by Lagrange, motor and gear ratio in full, against the core's motion."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
import sympy as sp
from serpenoid import _core

from . import symbolic as sy

ROBOT, GROUND = sn.Robot(3, 0.0756, 0.076), sn.Ground(0.1, 1.0)
GAIT = sn.Gait(0.9, 1.2, 4.0, offset_rad=0.1)
SERVO = sn.Servo(
    0.4,
    0.02,
    50.0,
    100.0,
    0.0,
    armature_kg_m2=1.5e-3,
    gear_friction_nm=0.02,
    gear_damping_nms_rad=5e-3,
)
Q = np.array([0.1, -0.2, 0.3, -0.4, 0.7])
QD = np.array([0.05, -0.03, 1.1, -0.7, 0.4])
J, RATIO = sp.symbols("J ratio", positive=True)


def rotor_terms() -> list[sp.Expr]:
    """Return what rotors add to each of Lagrange's equations.

    The motor of a joint sits on the link behind it. Its rotor (inertia J / ratio^2) turns with that
    link, and ratio times as fast as the joint besides.
    """
    spins = [sy.theta_d[j] + RATIO * (sy.theta_d[j + 1] - sy.theta_d[j]) for j in range(sy.N - 1)]
    kinetic = sum(J / RATIO**2 * spin**2 / 2 for spin in spins)
    return [sy.rate(kinetic.diff(rate)) for rate in sy.qd]


def accelerations(ratio: float) -> np.ndarray:
    """Return qddot by Lagrange, the servos' torques by their law, at the first frame."""
    goal = _core.firmware.gait_setpoints_rad(
        GAIT.alpha_rad, GAIT.beta_rad, GAIT.omega_rad_s, offset_rad=GAIT.offset_rad, joints=2
    )[0]
    angle, rate = np.diff(Q[2:]), np.diff(QD[2:])
    s = SERVO
    torque = s.stiffness_nm_rad * (np.array(goal) - angle) - s.damping_nms_rad * rate
    torque -= s.gear_damping_nms_rad * rate + s.gear_friction_nm * np.sign(rate)
    known = {
        sy.m: ROBOT.link_mass_kg,
        sy.ell: ROBOT.link_length_m / 2,
        sy.I_c: ROBOT.inertia_kg_m2,
        J: s.armature_kg_m2,
        RATIO: ratio,
    }
    known |= dict.fromkeys(sy.C_t, GROUND.ct) | dict.fromkeys(sy.C_n, GROUND.cn)
    known |= dict(zip(sy.q, Q, strict=True)) | dict(zip(sy.qd, QD, strict=True))
    # T_i acts on link i from link i+1: a torque that opens the joint turns link i backwards
    known |= dict(zip(sy.T, -torque, strict=True))
    for force, i in zip(sy.f, range(sy.N), strict=True):
        drag = sy.dissipative_friction(i).subs(known)
        known |= dict(zip(force, [float(x) for x in drag], strict=True))
    whole = [a + b for a, b in zip(sy.lagrange_equations(), rotor_terms(), strict=True)]
    matrix, load = sp.linear_eq_to_matrix([e.subs(known) for e in whole], *sy.qdd)
    return np.linalg.solve(np.array(matrix, dtype=float), np.array(load, dtype=float).ravel())


def by_the_core(servo: sn.Servo) -> np.ndarray:
    """Return qddot at the start of a simulation, by differences of its velocities."""
    dt = 1e-6
    run = sn.simulate(
        sn.Scene(
            ROBOT,
            GROUND,
            GAIT,
            drive="servo",
            servo=servo,
            dt_s=dt,
            duration_s=2 * dt,
            record_every=1,
            start=sn.LinkState.joined(ROBOT, Q, QD),
            method="rk4",
        )
    )
    v = np.column_stack([run.vx_m_s[:, 0], run.vy_m_s[:, 0], run.omega_rad_s])
    return (-3 * v[0] + 4 * v[1] - v[2]) / (2 * dt)


@pytest.fixture(scope="module")
def core() -> np.ndarray:
    return by_the_core(SERVO)


def test_the_reflected_rotor_is_the_limit_of_a_high_gear_ratio(core: np.ndarray) -> None:
    """The core has J phi'^2 / 2 alone; what it leaves out falls as one over the ratio."""
    largest = np.abs(core).max()
    far, near = (np.abs(accelerations(ratio) - core).max() / largest for ratio in (1e3, 1e5))
    assert near < 1e-4
    assert far / near == pytest.approx(100, rel=0.2)


def test_at_a_hobby_servos_ratio_the_rest_is_a_per_cent(core: np.ndarray) -> None:
    off = np.abs(accelerations(270.0) - core).max() / np.abs(core).max()
    assert 1e-3 < off < 0.03
