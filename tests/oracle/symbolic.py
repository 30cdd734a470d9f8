"""The three-link snake derived with SymPy, by Lagrange, in exact arithmetic.

States are rational: every angle comes with a rational sine and cosine, so that an equation either
holds exactly or does not; no tolerance and no simplification rule stands in between.
"""

from __future__ import annotations

import random

import sympy as sp

N = 3
m, ell, I_c, k, c = sp.symbols("m l I_c k c", positive=True)
C_t = sp.symbols("C_t1:4", positive=True)
C_n = sp.symbols("C_n1:4", positive=True)
T = sp.symbols("T1:3")
q = sp.symbols("x y theta1:4")
qd = sp.symbols("xd yd thetad1:4")
qdd = sp.symbols("xdd ydd thetadd1:4")
theta, theta_d, theta_dd = q[2:], qd[2:], qdd[2:]
f = [sp.Matrix(sp.symbols(f"f{i}x f{i}y")) for i in range(1, N + 1)]
Expr = sp.Expr


def rate(expr: Expr | sp.Matrix) -> Expr | sp.Matrix:
    """Return the time derivative by the chain rule."""
    pairs = [*zip(q, qd, strict=True), *zip(qd, qdd, strict=True)]
    return sum((expr.diff(a) * b for a, b in pairs), expr * 0)


def tangent(i: int) -> sp.Matrix:
    """Return the unit vector along link i (from 0)."""
    return sp.Matrix([sp.cos(theta[i]), sp.sin(theta[i])])


def normal(i: int) -> sp.Matrix:
    """Return the unit vector across link i (from 0)."""
    return sp.Matrix([-sp.sin(theta[i]), sp.cos(theta[i])])


def centre(i: int) -> sp.Matrix:
    """Return the centre of link i: half a link along each of the links on the way."""
    place = sp.Matrix(q[:2])
    for j in range(i):
        place += ell * tangent(j) + ell * tangent(j + 1)
    return place


CENTRES = [centre(i) for i in range(N)]
VELOCITIES = [rate(place) for place in CENTRES]


def dissipative_friction(i: int) -> sp.Matrix:
    """Return the viscous force on link i as minus the gradient of Rayleigh's function."""
    vx, vy = sp.symbols("vx vy")
    v = sp.Matrix([vx, vy])
    half_power = (C_t[i] * v.dot(tangent(i)) ** 2 + C_n[i] * v.dot(normal(i)) ** 2) / 2
    force = -sp.Matrix([half_power.diff(vx), half_power.diff(vy)])
    return force.subs({vx: VELOCITIES[i][0], vy: VELOCITIES[i][1]})


def generalised_ground_force(coordinate: sp.Symbol) -> Expr:
    """Return the ground forces' virtual work per unit of a coordinate."""
    return sum(f[i].dot(CENTRES[i].diff(coordinate)) for i in range(N))


def lagrange_equations() -> list[Expr]:
    """Return the five residuals d/dt dK/dqd - dK/dq - Q, with T_i on link i from link i+1."""
    kinetic = sum(m * v.dot(v) / 2 for v in VELOCITIES) + sum(I_c * w**2 / 2 for w in theta_d)
    work_rate = sum(T[j] * (theta[j] - theta[j + 1]) for j in range(N - 1))
    return [
        rate(kinetic.diff(qd[j]))
        - kinetic.diff(q[j])
        - generalised_ground_force(q[j])
        - work_rate.diff(q[j])
        for j in range(N + 2)
    ]


def rational_state(seed: int) -> dict[sp.Expr, sp.Rational]:
    """Return exact random values of everything: angles by their sine and cosine."""
    draw = random.Random(seed)

    def number() -> sp.Rational:
        return sp.Rational(draw.randint(1, 40), draw.randint(1, 40)) * draw.choice([-1, 1])

    values = {symbol: number() for symbol in (*q[:2], *qd, *T, *f[0], *f[1], *f[2])}
    values |= {symbol: abs(number()) for symbol in (m, ell, I_c, k, c, *C_t, *C_n)}
    for angle in theta:
        half = number()  # tan(angle / 2)
        values[sp.sin(angle)] = 2 * half / (1 + half**2)
        values[sp.cos(angle)] = (1 - half**2) / (1 + half**2)
    return values


def evaluate(expr: Expr, values: dict[sp.Expr, sp.Rational]) -> Expr:
    """Return an expression at a rational state, exactly."""
    return sp.expand(sp.expand_trig(sp.expand(expr)).xreplace(values))


def with_true_accelerations(values: dict[sp.Expr, sp.Rational]) -> dict[sp.Expr, sp.Rational]:
    """Return the state with the accelerations that Lagrange's equations give it."""
    system = [evaluate(equation, values) for equation in lagrange_equations()]
    matrix, load = sp.linear_eq_to_matrix(system, *qdd)
    return values | dict(zip(qdd, matrix.LUsolve(load), strict=True))
