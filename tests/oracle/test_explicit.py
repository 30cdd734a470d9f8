"""The dense exact model against the published reference numbers, the energy balance and limits."""

from __future__ import annotations

import numpy as np
import pytest

from . import explicit
from .params import Params, gait_deg

PAPER_3 = Params(links=3)


def random_case(n: int, seed: int) -> tuple[Params, np.ndarray, np.ndarray, np.random.Generator]:
    """Return a random snake, q, qdot (n+2,) and the generator that drew them."""
    rng = np.random.default_rng([seed, n])
    p = Params(n, *rng.uniform(0.05, 2.0, 3), *rng.uniform(0.0, 5.0, 4), tuple(rng.normal(size=2)))
    return p, rng.normal(size=n + 2), rng.normal(size=n + 2), rng


def test_state_s() -> None:
    q, qdot = np.array([0.1, -0.2, 0.3, -0.4, 0.7]), np.array([0.05, -0.03, 1.1, -0.7, 0.4])
    motion = explicit.torque_driven(PAPER_3, q, qdot, [0.02, -0.01])
    printed = [0.29644152322, 0.322294357236, 5.963369138345, -7.68832830881, 2.550904313997]
    # half a unit of the last printed digit
    assert motion.qddot == pytest.approx(printed, rel=0, abs=1e-11)


def test_three_links_at_ten_seconds() -> None:
    gait = gait_deg(30, 90, 3)
    end = explicit.trajectory(PAPER_3, gait, np.zeros(6), np.array([10.0]))[-1]
    printed = [0.6944674004, 0.2002216975, 0.6090597074, 0.0621623417, 0.0625789382, -0.7831627707]
    # the printed digits, and some growth of the tolerance 1e-12 over ten seconds
    assert end == pytest.approx(printed, rel=0, abs=2e-10)


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6, 7, 9, 12, 50])
@pytest.mark.parametrize("drive", ["torque", "angle", "mixed"])
def test_energy_and_momentum_balance(n: int, drive: str) -> None:
    p, q, qdot, rng = random_case(n, 1)
    driven = {"torque": np.zeros(n - 1, bool), "angle": np.ones(n - 1, bool)}.get(
        drive, rng.random(n - 1) < 0.5
    )
    torque, phi_ddot = rng.normal(size=(2, n - 1))
    motion = explicit.evaluate(p, q, qdot, torque=torque, phi_ddot=phi_ddot, driven=driven)
    residual, scale = explicit.power_balance(p, qdot, motion)
    # the dense solve of 3n + 3(n-1) unknowns loses a few digits as n grows
    assert abs(residual) < 1e-12 * n * scale
    external = motion.friction_n.sum(0) + n * p.mass_kg * np.asarray(p.gravity_m_s2)
    assert p.mass_kg * motion.accel_m_s2.sum(0) == pytest.approx(external, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("n", [2, 3, 6, 12, 50])
def test_drives_agree(n: int) -> None:
    """Imposing the joint accelerations that some torques caused gives those torques back."""
    p, q, qdot, rng = random_case(n, 2)
    torque = rng.normal(size=n - 1)
    first = explicit.torque_driven(p, q, qdot, torque)
    joints = np.diff(q[2:]), np.diff(qdot[2:]), np.diff(first.theta_ddot)
    second = explicit.angle_driven(p, q[:3], qdot[:3], joints)
    # the torque recovery multiplies rounding of the accelerations by the chain's inertia, ~ n**3
    assert second.torque_n_m == pytest.approx(torque, rel=1e-9, abs=1e-12 * n**3)
    assert second.qddot == pytest.approx(first.qddot, rel=1e-9, abs=1e-9)


def test_accelerations_are_second_derivatives() -> None:
    """Differentiating the energy numerically along the motion gives the power that was computed."""
    p, q, qdot, rng = random_case(5, 3)
    motion = explicit.torque_driven(p, q, qdot, rng.normal(size=4))
    step = 1e-5

    def energy(h: float) -> float:
        moved = q + h * qdot + h * h / 2 * motion.qddot
        return explicit.kinetic_energy(p, moved, qdot + h * motion.qddot)

    slope = (energy(step) - energy(-step)) / (2 * step)
    power = -np.sum(motion.torque_n_m * np.diff(qdot[2:]))
    power += np.sum(motion.velocity_m_s * motion.friction_n)
    power += p.mass_kg * np.sum(motion.velocity_m_s @ np.asarray(p.gravity_m_s2))
    # central differences: step**2 truncation and eps / step rounding, both about 1e-10
    assert slope == pytest.approx(power, rel=1e-7)


def test_free_snake_keeps_momentum() -> None:
    """Without ground or torques, momentum and angular momentum have no rate of change."""
    p = Params(7, ct=0.0, cn=0.0)
    _, q, qdot, _ = random_case(7, 4)
    motion = explicit.torque_driven(p, q, qdot, np.zeros(6))
    centre = explicit.centres(p, q)
    spin = p.mass_kg * np.sum(
        centre[:, 0] * motion.accel_m_s2[:, 1] - centre[:, 1] * motion.accel_m_s2[:, 0]
    )
    assert spin + p.inertia * motion.theta_ddot.sum() == pytest.approx(0.0, abs=1e-12)
    assert motion.accel_m_s2.sum(0) == pytest.approx(np.zeros(2), abs=1e-12)


def test_friction_sign_is_a_choice_at_rest() -> None:
    p = Params(2, ft0=0.3, fn0=0.7)
    theta, rest = np.zeros(2), np.zeros((2, 2))
    assert not explicit.friction(p, theta, rest).any()
    chosen = explicit.friction(p, theta, rest, np.array([[1.0, -0.5], [0.0, 1.0]]))
    assert chosen == pytest.approx(np.array([[-0.3, 0.35], [0.0, -0.7]]))
