"""The spring-and-damper model: its balances, its limit k -> infinity, and its integrators."""

from __future__ import annotations

import numpy as np
import pytest

from . import explicit, implicit
from .implicit import Spring
from .params import Params, gait_deg

GAIT = gait_deg(30, 90, 3)
PAPER_3 = Params(links=3)


def random_links(n: int, seed: int) -> tuple:
    """Return a random snake, springs, pose and rates (n, 3) with open joints, and the generator."""
    rng = np.random.default_rng([seed, n])
    p = Params(n, *rng.uniform(0.05, 2.0, 3), *rng.uniform(0.0, 5.0, 4), tuple(rng.normal(size=2)))
    spring = Spring(rng.uniform(10, 1e3, n - 1), rng.uniform(0, 5, n - 1))
    return p, spring, *rng.normal(size=(2, n, 3)), rng


def slow_start(p: Params, spring: Spring, rest: bool = True) -> np.ndarray:
    """Return the angle-driven state on the slow manifold, or (rest False) with closed joints."""
    phi, phi_dot, _ = GAIT.angles(0.0, p.links - 1)
    q, qdot = explicit.whole_state(np.zeros(3), phi), explicit.whole_state(np.zeros(3), phi_dot)
    if rest:
        drive = implicit.gait_drive(p, GAIT)
        return implicit.pack(*implicit.on_slow_manifold(p, spring, drive, 0.0, (q, qdot)))
    return implicit.pack(*implicit.closed_links(p, q, qdot))


@pytest.mark.parametrize("n", [2, 3, 6, 12, 50])
@pytest.mark.parametrize("driven", [False, True])
def test_energy_and_momentum_balance(n: int, driven: bool) -> None:
    p, spring, pose, rates, rng = random_links(n, 1)
    imposed = rng.normal(size=n - 1)
    drive = implicit.angle_driven if driven else implicit.torque_driven
    motion = drive(p, spring, pose, rates, imposed)
    residual, scale = implicit.power_balance(p, spring, pose, rates, motion)
    assert abs(residual) < 1e-13 * n * scale  # rounding of a dense solve of 4n - 1 unknowns
    external = motion.friction_n.sum(0) + n * p.mass_kg * np.asarray(p.gravity_m_s2)
    size = np.abs(motion.force_n).sum()
    assert np.abs(p.mass_kg * motion.accel_m_s2.sum(0) - external).max() < 1e-13 * n * size
    if driven:
        assert np.diff(motion.theta_ddot) == pytest.approx(imposed, rel=1e-9, abs=1e-9 * size)


def test_joint_force_pulls_links_together() -> None:
    pose = np.array([[0.0, 0.0, 0.0], [0.13, 0.0, 0.0]])  # joint open by 0.01 m
    motion = implicit.torque_driven(Params(2), Spring(100.0, 0.0), pose, 0 * pose, [0.0])
    assert motion.force_n[0] == pytest.approx([1.0, 0.0])
    assert motion.accel_m_s2[:, 0] == pytest.approx([1.0, -1.0])


def test_slow_manifold_carries_the_exact_forces() -> None:
    """There k gap + c gap' is the exact F, and its F' is the force's slope along the motion."""
    q, qdot = (explicit.whole_state(np.array([0.1, -0.2, 0.3]), a) for a in GAIT.angles(0.4, 2)[:2])
    drive = implicit.gait_drive(PAPER_3, GAIT)
    exact = drive(0.4, q, qdot)
    for stiffness in (1e3, 1e5):
        spring = Spring(stiffness, 3.0)
        links = implicit.on_slow_manifold(PAPER_3, spring, drive, 0.4, (q, qdot))
        force = implicit.joint_forces(PAPER_3, spring, *links)
        assert force == pytest.approx(exact.force_n, abs=1e-9)  # rounding, k * 1e-16 m

    def force_at(h: float) -> np.ndarray:
        moved = q + h * qdot + h * h / 2 * exact.qddot
        return drive(0.4 + h, moved, qdot + h * exact.qddot).force_n

    slope = (force_at(1e-4) - force_at(-1e-4)) / 2e-4
    rate = implicit.force_and_rate(drive, 0.4, q, qdot)[1]
    # a central difference along the motion's parabola is off by the order of its step squared
    assert slope == pytest.approx(rate, rel=1e-5, abs=1e-5)


def settled_error(stiffness: float, rest: bool) -> tuple[float, float]:
    """Return the worst error of link 1's velocity and of the joint forces over 0.2 to 0.4 s."""
    spring, times = Spring(stiffness, 1.0), np.linspace(0.2, 0.4, 41)
    rate = implicit.gait_rate(PAPER_3, spring, GAIT)
    runs = implicit.integrate(rate, slow_start(PAPER_3, spring, rest), times, rtol=1e-9)
    exact = explicit.trajectory(PAPER_3, GAIT, np.zeros(6), times)
    velocity = force = 0.0
    for t, y, truth in zip(times, runs, exact, strict=True):
        pose, rates, phi_ddot = implicit.unpack(PAPER_3, GAIT, t, y)
        loose = implicit.angle_driven(PAPER_3, spring, pose, rates, phi_ddot)
        tight = explicit.angle_driven(PAPER_3, truth[:3], truth[3:], GAIT.angles(t, 2))
        velocity = max(velocity, np.abs(rates[0, :2] - truth[3:5]).max())
        force = max(force, np.abs(loose.force_n - tight.force_n).max())
    return velocity, force


def test_modelling_error_falls_as_one_over_k_from_the_slow_manifold_only() -> None:
    (v1, f1), (v2, f2) = settled_error(1e4, True), settled_error(4e4, True)
    # four times the stiffness: a fourth of the error, give or take the next order
    assert 3.0 < v1 / v2 < 5.0
    assert 3.0 < f1 / f2 < 5.0
    (w1, g1), (w2, g2) = settled_error(1e4, False), settled_error(4e4, False)
    # from closed joints the spring rings: half the velocity error, and the force error stays
    assert 1.4 < w1 / w2 < 2.8
    assert 0.6 < g1 / g2 < 1.6
    assert g2 > 20 * f2


def test_integrators_agree_and_rk4_is_of_order_four() -> None:
    spring, end = Spring(), np.array([0.2])
    start, rate = slow_start(PAPER_3, spring, False), implicit.gait_rate(PAPER_3, spring, GAIT)
    truth = implicit.integrate(rate, start, end)[-1]
    stiff = implicit.integrate(rate, start, end, "Radau", 1e-9)[-1]
    assert stiff == pytest.approx(truth, abs=1e-7)  # Radau's tolerance, gathered over 0.2 s
    errors = [np.abs(implicit.rk4(rate, start, 0.2 / n, n) - truth).max() for n in (100, 200, 400)]
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    # at 2 to 0.5 ms the next term still adds some hundredths
    assert order == pytest.approx([4.0, 4.0], abs=0.2)


def test_torques_of_the_driven_run_reproduce_it() -> None:
    """Torque-driven and angle-driven are one model: feeding T_i back gives the same motion."""
    p, spring, pose, rates, rng = random_links(5, 7)
    driven = implicit.angle_driven(p, spring, pose, rates, rng.normal(size=4))
    free = implicit.torque_driven(p, spring, pose, rates, driven.torque_n_m)
    assert free.accel_m_s2 == pytest.approx(driven.accel_m_s2, rel=1e-11)
    assert free.theta_ddot == pytest.approx(driven.theta_ddot, rel=1e-9, abs=1e-9)


def test_the_papers_figure_6() -> None:
    """Paper: implicit and exact theta_1 agree to order 1e-3; 1.7e-3 rad was measured over 10 s."""
    spring, times = Spring(), np.arange(1, 41) * 0.25
    rate, start = implicit.gait_rate(PAPER_3, spring, GAIT), slow_start(PAPER_3, spring, False)
    exact = explicit.trajectory(PAPER_3, GAIT, np.zeros(6), times, 1e-9)[:, 2]
    loose = implicit.integrate(rate, start, times, rtol=1e-7)[:, 2 * PAPER_3.links]
    assert 5e-4 < np.abs(loose - exact).max() < 2e-3
