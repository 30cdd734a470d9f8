"""Errata of the paper: its equations, evaluated exactly, against a derivation for three links."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from . import dense, printed
from . import symbolic as sy
from .params import Params

WRONG = {"28", "29", "30", "33", "45", "47", "50 row 4"}


@pytest.fixture(scope="module")
def states() -> list[dict[sp.Expr, sp.Rational]]:
    """Return two exact random states, at both of which a wrong equation cannot hold by chance."""
    return [sy.with_true_accelerations(sy.rational_state(seed)) for seed in (1, 2)]


def disagreeing(equations: printed.Residuals, states: list) -> set[str]:
    return {
        number
        for number, residuals in equations.items()
        if any(sy.evaluate(residual, values) != 0 for residual in residuals for values in states)
    }


def test_dense_model_agrees_with_lagrange(states: list) -> None:
    """Compare dense.py with the symbolic derivation for viscous friction."""
    for values in states:
        drag = {sy.C_t[i]: values[sy.C_t[0]] for i in range(3)}
        drag |= {sy.C_n[i]: values[sy.C_n[0]] for i in range(3)}
        state = {key: value for key, value in values.items() if key not in sy.qdd} | drag
        for i in range(3):
            force = [sy.evaluate(part, state) for part in sy.dissipative_friction(i)]
            state |= dict(zip(sy.f[i], force, strict=True))
        truth = sy.with_true_accelerations(state)
        q = [state[sy.q[0]], state[sy.q[1]]]
        q += [sp.atan2(state[sp.sin(angle)], state[sp.cos(angle)]) for angle in sy.theta]
        keys = (sy.m, sy.ell, sy.I_c, sy.C_t[0], sy.C_n[0])
        p = Params(3, *(float(state[key]) for key in keys))
        qdot, torque = (np.array([float(state[s]) for s in part]) for part in (sy.qd, sy.T))
        motion = dense.evaluate(p, *dense.closed_links(p, np.array(q, float), qdot), torque=torque)
        qddot = [*motion.accel_m_s2[0], *motion.theta_ddot]
        # double precision against exact rationals; the condition number of the system is < 1e4
        assert qddot == pytest.approx([float(truth[s]) for s in sy.qdd], rel=1e-10)


def test_exactly_the_listed_equations_are_wrong(states: list) -> None:
    equations = printed.as_printed()
    assert len(equations) == 12 + 5
    assert disagreeing(equations, states) == WRONG


def test_the_corrected_equations_hold(states: list) -> None:
    assert disagreeing(printed.corrected(), states) == set()


def test_spring_and_damper_of_equations_51_to_56() -> None:
    """The joint force is minus the gradient of the spring's energy and the damper's loss."""
    positions = sp.Matrix(sp.symbols("x1 y1 x2 y2"))
    speeds = sp.Matrix(sp.symbols("xd1 yd1 xd2 yd2"))
    left = positions[:2, :] + sy.ell * sy.tangent(0)  # Eqs. 54, 56
    right = positions[2:, :] - sy.ell * sy.tangent(1)  # Eqs. 53, 55
    gap, variables = right - left, [*positions, *sy.theta[:2]]
    rates = [*speeds, *sy.theta_d[:2]]
    gap_rate = gap.jacobian(variables) * sp.Matrix(rates)
    force = sy.k * gap + sy.c * gap_rate  # Eqs. 51-52, on link 1
    energy, loss = sy.k * gap.dot(gap) / 2, sy.c * gap_rate.dot(gap_rate) / 2
    for axis in range(2):
        on_tail = -energy.diff(positions[axis]) - loss.diff(speeds[axis])
        assert sp.simplify(on_tail - force[axis]) == 0
    turning = -energy.diff(sy.theta[0]) - loss.diff(sy.theta_d[0])
    assert sp.simplify(turning - sy.ell * sy.normal(0).dot(force)) == 0


def test_equation_58_weighs_the_whole_snake() -> None:
    """Only with all six links do Eqs. 58-59 put the first reading near the paper's 2 degrees."""

    def slope_deg(mass_kg: float, speed_m_s: float) -> float:
        return np.degrees(np.arcsin((0.084 * speed_m_s + 0.14) / (mass_kg * 9.81)))

    assert 1.7 < slope_deg(6 * 0.0756, 0.0) < 2.0 < slope_deg(6 * 0.0756, 1.0) < 3.0
    assert slope_deg(0.0756, 0.0) > 10.0
