"""The two models written by hand for Numba: an implementation of their own, and the peers' kernels.

State, explicit: x, y, theta of link 1 and their rates. Implicit: x, y, vx, vy of all links (n
values each), then theta and its rate of link 1. Parameters: see `parameters`. Written from the
equations of motion, sharing nothing with the compiled core, so that agreement means something.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit  # pyright: ignore[reportMissingImports] (an optional extra)
from scipy.integrate._ivp import dop853_coefficients as dop853

from ..problems import Array, Problem

_JIT = {"cache": True, "error_model": "numpy", "nogil": True}
# places in `parameters`
(N, M, L, INERTIA, CT, CN, FT0, FN0, WIDTH, ALPHA, OMEGA, OFFSET, K, C, CT_BACK, FT0_BACK, HEAD) = (
    range(17)
)


def parameters(problem: Problem, width_m_s: float = 0.0) -> Array:
    """Pack a problem: scalars by the names above, then cos and sin of the joints' phase lags.

    width_m_s smooths the sign of dry friction: v / sqrt(v^2 + width^2).
    """
    robot, ground, gait = problem.robot, problem.ground, problem.gait
    lag = gait.beta_rad * np.arange(robot.links - 1)
    head = [
        robot.links,
        robot.link_mass_kg,
        robot.link_length_m / 2,
        robot.link_inertia_kg_m2,
        ground.ct_forward,
        ground.cn,
        ground.ft0_forward,
        ground.fn0,
        width_m_s,
        gait.alpha_rad,
        gait.omega_rad_s,
        gait.offset_rad,
        problem.stiffness_n_m,
        problem.damping_n_s_m,
        ground.ct_backward,
        ground.ft0_backward,
    ]
    return np.concatenate([head, np.cos(lag), np.sin(lag)])


@njit(**_JIT)
def _joint(i, st, ct, p):
    """Return the angle between links i - 1 and i, its rate, its acceleration; st: sin(omega t)."""
    a, b, w = p[HEAD - 1 + i], p[HEAD - 2 + int(p[N]) + i], p[OMEGA]
    sine, cosine = p[ALPHA] * (st * a + ct * b), p[ALPHA] * (ct * a - st * b)
    return p[OFFSET] + sine, w * cosine, -w * w * sine


@njit(**_JIT)
def _sign(v, width):
    return v / math.sqrt(v * v + width * width) if width > 0 else np.sign(v)


@njit(**_JIT)
def _ground(c, s, vx, vy, p):
    """Return the ground's force on a link: ratchet wheels resist differently backwards."""
    vt, vn = c * vx + s * vy, c * vy - s * vx
    ct, ft0 = (p[CT], p[FT0]) if vt > 0 else (p[CT_BACK], p[FT0_BACK])
    ft = -ct * vt - ft0 * _sign(vt, p[WIDTH])
    fn = -p[CN] * vn - p[FN0] * _sign(vn, p[WIDTH])
    return ft * c - fn * s, ft * s + fn * c


@njit(**_JIT)
def explicit_rate(t, y, p, dy):
    """Fill dy of the exact model: three unknowns by sums over the links."""
    n, m, half, inertia = int(p[N]), p[M], p[L], p[INERTIA]
    st, ct = math.sin(p[OMEGA] * t), math.cos(p[OMEGA] * t)
    th, om, turn, vx, vy = y[2], y[5], 0.0, y[3], y[4]
    c, s = math.cos(th), math.sin(th)
    rx = ry = bx = by = Rx = Ry = rr = gx = gy = moment = turns = 0.0
    for i in range(n):
        if i > 0:
            c0, s0, om0, turn0 = c, s, om, turn
            angle, rate, acceleration = _joint(i, st, ct, p)
            th += angle
            om += rate
            turn += acceleration
            c, s = math.cos(th), math.sin(th)
            rx += half * (c0 + c)
            ry += half * (s0 + s)
            vx -= half * (om0 * s0 + om * s)
            vy += half * (om0 * c0 + om * c)
            bx -= half * (turn0 * s0 + om0 * om0 * c0 + turn * s + om * om * c)
            by += half * (turn0 * c0 - om0 * om0 * s0 + turn * c - om * om * s)
        qx, qy = _ground(c, s, vx, vy, p)
        qx -= m * bx
        qy -= m * by
        gx += qx
        gy += qy
        moment += rx * qy - ry * qx
        Rx += rx
        Ry += ry
        rr += rx * rx + ry * ry
        turns += turn
    spin = (moment - inertia * turns + (Ry * gx - Rx * gy) / n) / (
        n * inertia + m * (rr - (Rx * Rx + Ry * Ry) / n)
    )
    dy[0], dy[1], dy[2] = y[3], y[4], y[5]
    dy[3] = (gx / m + Ry * spin) / n
    dy[4] = (gy / m - Rx * spin) / n
    dy[5] = spin


@njit(**_JIT)
def implicit_rate(t, y, p, dy):
    """Fill dy of the model with springs and dampers in the joints (Eqs. 51-56)."""
    n, m, half, inertia = int(p[N]), p[M], p[L], p[INERTIA]
    st, ct = math.sin(p[OMEGA] * t), math.cos(p[OMEGA] * t)
    th, om, turn = y[4 * n], y[4 * n + 1], 0.0
    couple = turns = c0 = s0 = om0 = 0.0
    for i in range(n):
        if i > 0:
            angle, rate, acceleration = _joint(i, st, ct, p)
            th += angle
            om += rate
            turn += acceleration
        c, s = math.cos(th), math.sin(th)
        vx, vy = y[2 * n + i], y[3 * n + i]
        gx, gy = _ground(c, s, vx, vy, p)
        if i > 0:
            gap_x = y[i] - y[i - 1] - half * (c + c0)
            gap_y = y[n + i] - y[n + i - 1] - half * (s + s0)
            rate_x = vx - y[2 * n + i - 1] + half * (om * s + om0 * s0)
            rate_y = vy - y[3 * n + i - 1] - half * (om * c + om0 * c0)
            fx, fy = p[K] * gap_x + p[C] * rate_x, p[K] * gap_y + p[C] * rate_y
            couple += half * (fy * (c + c0) - fx * (s + s0))
            dy[2 * n + i - 1] += fx / m
            dy[3 * n + i - 1] += fy / m
            gx -= fx
            gy -= fy
        dy[i], dy[n + i], dy[2 * n + i], dy[3 * n + i] = vx, vy, gx / m, gy / m
        turns += turn
        c0, s0, om0 = c, s, om
    dy[4 * n] = y[4 * n + 1]
    dy[4 * n + 1] = (couple - inertia * turns) / (n * inertia)


@njit(**_JIT)
def fill_rate(implicit, t, y, p, dy):
    """Fill dy with the rate of either model."""
    if implicit:
        implicit_rate(t, y, p, dy)
    else:
        explicit_rate(t, y, p, dy)


_RK4_A = np.array([[0, 0, 0, 0], [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1.0, 0]])
_RK4_B, _RK4_NODES = np.array([1, 2, 2, 1]) / 6, np.array([0, 0.5, 0.5, 1])
_A, _NODES = np.ascontiguousarray(dop853.A[:12, :12]), dop853.C[:12].copy()
_B, _E3, _E5 = dop853.B.copy(), dop853.E3[:12].copy(), dop853.E5[:12].copy()


@njit(**_JIT)
def _stages(implicit, t, h, y, p, a, nodes, k, z):
    """Fill k with the rates of a step's stages behind the first one, which is there."""
    for stage in range(1, nodes.size):
        for i in range(y.size):
            z[i] = y[i]
        for j in range(stage):
            if a[stage, j] != 0:
                for i in range(y.size):
                    z[i] += h * a[stage, j] * k[j, i]
        fill_rate(implicit, t + nodes[stage] * h, z, p, k[stage])


@njit(**_JIT)
def rk4(implicit, y0, p, dt, steps):
    """Run the classical method at a fixed step and return the end state."""
    y, z, k = y0.copy(), np.empty_like(y0), np.empty((4, y0.size))
    for step in range(steps):
        fill_rate(implicit, step * dt, y, p, k[0])
        _stages(implicit, step * dt, dt, y, p, _RK4_A, _RK4_NODES, k, z)
        for j in range(4):
            for i in range(y.size):
                y[i] += dt * _RK4_B[j] * k[j, i]
    return y


@njit(**_JIT)
def dop853_run(implicit, y0, p, end, rtol, atol, most):
    """Run Dormand and Prince's 8(5,3) pair with step control; the second value is steps, or -1."""
    y, z, d = y0.copy(), np.empty_like(y0), y0.size
    k = np.empty((12, d))
    t, h, steps = 0.0, end * 1e-4, 0
    fill_rate(implicit, t, y, p, k[0])
    while t < end:
        steps += 1
        if steps > most:
            return y, -1
        h = min(h, end - t)
        _stages(implicit, t, h, y, p, _A, _NODES, k, z)
        e3 = e5 = 0.0
        for i in range(d):
            rise = err3 = err5 = 0.0
            for j in range(12):
                rise += _B[j] * k[j, i]
                err3 += _E3[j] * k[j, i]
                err5 += _E5[j] * k[j, i]
            z[i] = y[i] + h * rise
            scale = atol + rtol * max(abs(y[i]), abs(z[i]))
            e3 += (err3 / scale) ** 2
            e5 += (err5 / scale) ** 2
        error = h * e5 / math.sqrt((e5 + 0.01 * e3) * d) if e5 > 0 else 0.0
        if not error < np.inf:
            h *= 0.1
            continue
        if error <= 1:
            t = end if h >= end - t else t + h
            y[:] = z
            fill_rate(implicit, t, y, p, k[0])
        h *= min(10.0, max(0.2, 0.9 * error ** (-0.125))) if error > 0 else 10.0
    return y, steps


@njit(**_JIT)
def rate_array(implicit, t, y, p):
    """Return the rate as a new array: what a general solver calls."""
    dy = np.empty_like(y)
    fill_rate(implicit, t, y, p, dy)
    return dy
