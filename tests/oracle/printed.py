"""The paper's Eqs. 28-33 and 44-50 as printed, left side minus right side, and their corrections.

The steps between, Eqs. 1-27 and 34-43, are right, and symbolic.py derives what they lead to.
"""

from __future__ import annotations

import sympy as sp

from . import symbolic as sy
from .symbolic import VELOCITIES, I_c, T, ell, m

Residuals = dict[str, list[sp.Expr]]

THETA1, THETA2, THETA3 = sy.theta
W1, W2, W3 = sy.theta_d
SIN = [sp.sin(angle) for angle in sy.theta]
COS = [sp.cos(angle) for angle in sy.theta]
X_DD, Y_DD, A1, A2, A3 = sy.qdd
FX, FY = zip(*sy.f, strict=True)
Q = [sy.generalised_ground_force(coordinate) for coordinate in sy.q]
I_01, I_02, I_03 = I_c + 2 * m * ell**2, I_c + 5 * m * ell**2, I_c + m * ell**2


def friction(sign: int) -> Residuals:
    """Return Eqs. 28-33 for every link; sign +1 as printed, -1 with the force opposing motion."""
    residuals: Residuals = {str(number): [] for number in range(28, 34)}
    for i in range(sy.N):
        force, velocity = sy.dissipative_friction(i), VELOCITIES[i]
        turn = sp.Matrix([[COS[i], -SIN[i]], [SIN[i], COS[i]]])
        drag = sp.diag(sy.C_t[i], sy.C_n[i])
        true_t, true_n = force.dot(sy.tangent(i)), force.dot(sy.normal(i))
        vx, vy = velocity
        residuals["28"].append(true_t - sign * sy.C_t[i] * (vx * COS[i] + vy * SIN[i]))
        residuals["29"].append(true_n - sign * sy.C_n[i] * (-vx * SIN[i] + vy * COS[i]))
        residuals["30"] += list(sp.Matrix([true_t, true_n]) - sign * drag * turn.T * velocity)
        residuals["31"].append(force[0] - (true_t * COS[i] - true_n * SIN[i]))
        residuals["32"].append(force[1] - (true_t * SIN[i] + true_n * COS[i]))
        right = turn * drag * velocity if sign > 0 else -turn * drag * turn.T * velocity
        residuals["33"] += list(force - right)
    return residuals


def moments() -> Residuals:
    """Return Eqs. 44, 46, 48, whose Q_3..Q_5 are taken as the true generalised forces."""
    c12, c31, c23 = (sp.cos(THETA1 - THETA2), sp.cos(THETA3 - THETA1), sp.cos(THETA2 - THETA3))
    s12, s31, s23 = (sp.sin(THETA1 - THETA2), sp.sin(THETA3 - THETA1), sp.sin(THETA2 - THETA3))
    arm = [Y_DD * COS[i] - X_DD * SIN[i] for i in range(sy.N)]
    unit = m * ell**2
    return {
        "44": [
            I_01 * A1
            + 2 * m * ell * arm[0]
            + unit * (3 * A2 * c12 + A3 * c31)
            - (T[0] + Q[2] + unit * (-3 * W2**2 * s12 + W3**2 * s31))
        ],
        "46": [
            I_02 * A2
            + 3 * m * ell * arm[1]
            + unit * (3 * A1 * c12 + 2 * A3 * c23)
            - ((T[1] - T[0]) + Q[3] + unit * (3 * W1**2 * s12 - 2 * W3**2 * s23))
        ],
        "48": [
            I_03 * A3
            + m * ell * arm[2]
            + unit * (A1 * c31 + 2 * A2 * c23)
            - (-T[1] + Q[4] + unit * (-(W1**2) * s31 + 2 * W2**2 * s23))
        ],
    }


def generalised_forces(arm: sp.Expr) -> Residuals:
    """Return Eqs. 45, 47, 49; the factor `arm` of Q_3 and Q_4 is printed as 1 and should be l."""
    q3 = -(FX[1] + FX[2]) * SIN[0] + (FY[1] + FY[2]) * COS[0]
    q4 = -(FX[1] + 2 * FX[2]) * SIN[1] + (FY[1] + 2 * FY[2]) * COS[1]
    q5 = -FX[2] * ell * SIN[2] + FY[2] * ell * COS[2]
    own = [sy.lagrange_equations()[2 + i].expand().coeff(sy.theta_dd[i]) for i in range(sy.N)]
    inertia = [true - shown for true, shown in zip(own, (I_01, I_02, I_03), strict=True)]
    return {
        "45": [inertia[0], Q[2] - arm * q3],
        "47": [inertia[1], Q[3] - arm * q4],
        "49": [inertia[2], Q[4] - q5],
    }


def matrix_form(row4_rate: sp.Symbol) -> Residuals:
    """Return the rows of Eq. 50; row 4's first rate is printed as theta_2's, not theta_1's."""
    (s1, s2, s3), (c1, c2, c3) = SIN, COS
    c12, c31, c23 = (sp.cos(THETA1 - THETA2), sp.cos(THETA3 - THETA1), sp.cos(THETA2 - THETA3))
    s12, s31, s23 = (sp.sin(THETA1 - THETA2), sp.sin(THETA3 - THETA1), sp.sin(THETA2 - THETA3))
    first, unit = m * ell, m * ell**2
    matrix = sp.Matrix(
        [
            [3 * m, 0, -2 * first * s1, -3 * first * s2, -first * s3],
            [0, 3 * m, 2 * first * c1, 3 * first * c2, first * c3],
            [-2 * first * s1, 2 * first * c1, I_01, 3 * unit * c12, unit * c31],
            [-3 * first * s2, 3 * first * c2, 3 * unit * c12, I_02, 2 * unit * c23],
            [-first * s3, first * c3, unit * c31, 2 * unit * c23, I_03],
        ]
    )
    torque = sp.Matrix([0, 0, T[0], T[1] - T[0], -T[1]])
    inertial = sp.Matrix(
        [
            first * (2 * W1**2 * c1 + 3 * W2**2 * c2 + W3**2 * c3),
            first * (2 * W1**2 * s1 + 3 * W2**2 * s2 + W3**2 * s3),
            unit * (-3 * W2**2 * s12 + W3**2 * s31),
            unit * (3 * row4_rate**2 * s12 - 2 * W3**2 * s23),
            unit * (-(W1**2) * s31 + 2 * W2**2 * s23),
        ]
    )
    residual = matrix * sp.Matrix(sy.qdd) - torque - inertial - sp.Matrix(Q)
    return {f"50 row {i + 1}": [row] for i, row in enumerate(residual)}


def as_printed() -> Residuals:
    """Return the equations as they stand in the paper."""
    return assemble(friction(+1), generalised_forces(sp.Integer(1)), matrix_form(W2))


def corrected() -> Residuals:
    """Return the equations with the errata put right."""
    return assemble(friction(-1), generalised_forces(ell), matrix_form(W1))


def assemble(*varying: Residuals) -> Residuals:
    """Return the moments, common to both readings, and what varies."""
    common = moments()
    for part in varying:
        common |= part
    return common
