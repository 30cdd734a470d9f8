"""The paper's Eqs. 28-33 and 44-50 as printed and as corrected: left minus right side.

Eqs. 1-27 and 34-43 are printed correctly; symbolic.py derives what follows from them.
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
DIFFERENCES = (THETA1 - THETA2, THETA3 - THETA1, THETA2 - THETA3)
C12, C31, C23 = map(sp.cos, DIFFERENCES)
S12, S31, S23 = map(sp.sin, DIFFERENCES)
X_DD, Y_DD, A1, A2, A3 = sy.qdd
FX, FY = zip(*sy.f, strict=True)
Q = [sy.generalised_ground_force(coordinate) for coordinate in sy.q]
I_01, I_02, I_03 = I_c + 2 * m * ell**2, I_c + 5 * m * ell**2, I_c + m * ell**2


def friction(sign: int) -> Residuals:
    """Return Eqs. 28-33 for every link; sign +1 as printed, -1 with the force opposing motion."""
    residuals: Residuals = {str(number): [] for number in range(28, 34)}
    for i in range(sy.N):
        force, velocity = sy.dissipative_friction(i), VELOCITIES[i]
        rotation = sp.Matrix([[COS[i], -SIN[i]], [SIN[i], COS[i]]])
        drag = sp.diag(sy.C_t[i], sy.C_n[i])
        force_t, force_n = force.dot(sy.tangent(i)), force.dot(sy.normal(i))
        vx, vy = velocity
        residuals["28"].append(force_t - sign * sy.C_t[i] * (vx * COS[i] + vy * SIN[i]))
        residuals["29"].append(force_n - sign * sy.C_n[i] * (-vx * SIN[i] + vy * COS[i]))
        residuals["30"] += list(sp.Matrix([force_t, force_n]) - sign * drag * rotation.T * velocity)
        residuals["31"].append(force[0] - (force_t * COS[i] - force_n * SIN[i]))
        residuals["32"].append(force[1] - (force_t * SIN[i] + force_n * COS[i]))
        right_side = (
            rotation * drag * velocity if sign > 0 else -rotation * drag * rotation.T * velocity
        )
        residuals["33"] += list(force - right_side)
    return residuals


def moments() -> Residuals:
    """Return Eqs. 44, 46 and 48, with the derived generalised forces for Q_3 to Q_5."""
    normal_accel = [Y_DD * COS[i] - X_DD * SIN[i] for i in range(sy.N)]
    m_ell2 = m * ell**2
    return {
        "44": [
            I_01 * A1
            + 2 * m * ell * normal_accel[0]
            + m_ell2 * (3 * A2 * C12 + A3 * C31)
            - (T[0] + Q[2] + m_ell2 * (-3 * W2**2 * S12 + W3**2 * S31))
        ],
        "46": [
            I_02 * A2
            + 3 * m * ell * normal_accel[1]
            + m_ell2 * (3 * A1 * C12 + 2 * A3 * C23)
            - ((T[1] - T[0]) + Q[3] + m_ell2 * (3 * W1**2 * S12 - 2 * W3**2 * S23))
        ],
        "48": [
            I_03 * A3
            + m * ell * normal_accel[2]
            + m_ell2 * (A1 * C31 + 2 * A2 * C23)
            - (-T[1] + Q[4] + m_ell2 * (-(W1**2) * S31 + 2 * W2**2 * S23))
        ],
    }


def generalised_forces(arm: sp.Expr) -> Residuals:
    """Return Eqs. 45, 47 and 49. The lever arm in Q_3 and Q_4 is printed as 1, and should be l."""
    q3 = -(FX[1] + FX[2]) * SIN[0] + (FY[1] + FY[2]) * COS[0]
    q4 = -(FX[1] + 2 * FX[2]) * SIN[1] + (FY[1] + 2 * FY[2]) * COS[1]
    q5 = -FX[2] * ell * SIN[2] + FY[2] * ell * COS[2]
    derived = [sy.lagrange_equations()[2 + i].expand().coeff(sy.theta_dd[i]) for i in range(sy.N)]
    errors = [value - shown for value, shown in zip(derived, (I_01, I_02, I_03), strict=True)]
    return {
        "45": [errors[0], Q[2] - arm * q3],
        "47": [errors[1], Q[3] - arm * q4],
        "49": [errors[2], Q[4] - q5],
    }


def matrix_form(row4_rate: sp.Symbol) -> Residuals:
    """Return the rows of Eq. 50. Row 4 is printed with the rate of theta_2; theta_1 is correct."""
    (s1, s2, s3), (c1, c2, c3) = SIN, COS
    m_ell, m_ell2 = m * ell, m * ell**2
    matrix = sp.Matrix(
        [
            [3 * m, 0, -2 * m_ell * s1, -3 * m_ell * s2, -m_ell * s3],
            [0, 3 * m, 2 * m_ell * c1, 3 * m_ell * c2, m_ell * c3],
            [-2 * m_ell * s1, 2 * m_ell * c1, I_01, 3 * m_ell2 * C12, m_ell2 * C31],
            [-3 * m_ell * s2, 3 * m_ell * c2, 3 * m_ell2 * C12, I_02, 2 * m_ell2 * C23],
            [-m_ell * s3, m_ell * c3, m_ell2 * C31, 2 * m_ell2 * C23, I_03],
        ]
    )
    torque = sp.Matrix([0, 0, T[0], T[1] - T[0], -T[1]])
    inertial = sp.Matrix(
        [
            m_ell * (2 * W1**2 * c1 + 3 * W2**2 * c2 + W3**2 * c3),
            m_ell * (2 * W1**2 * s1 + 3 * W2**2 * s2 + W3**2 * s3),
            m_ell2 * (-3 * W2**2 * S12 + W3**2 * S31),
            m_ell2 * (3 * row4_rate**2 * S12 - 2 * W3**2 * S23),
            m_ell2 * (-(W1**2) * S31 + 2 * W2**2 * S23),
        ]
    )
    residual = matrix * sp.Matrix(sy.qdd) - torque - inertial - sp.Matrix(Q)
    return {f"50 row {i + 1}": [row] for i, row in enumerate(residual)}


def as_printed() -> Residuals:
    """Return the equations as printed in the paper."""
    return moments() | friction(+1) | generalised_forces(sp.Integer(1)) | matrix_form(W2)


def corrected() -> Residuals:
    """Return the equations with all errata corrected."""
    return moments() | friction(-1) | generalised_forces(ell) | matrix_form(W1)
