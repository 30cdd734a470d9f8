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
def _sign(v, width):
    return v / math.sqrt(v * v + width * width) if width > 0 else np.sign(v)


@njit(**_JIT)
def _along(v, p, dry):
    """Return the force along a link: ratchet wheels resist differently backwards."""
    force = -(p[CT] if v > 0 else p[CT_BACK]) * v
    if dry:
        force -= (p[FT0] if v > 0 else p[FT0_BACK]) * _sign(v, p[WIDTH])
    return force


@njit(**_JIT)
def explicit_rate(t, y, p, dy):
    """Fill dy of the exact model: three unknowns by sums over the links."""
    n, m, half, inertia, w = int(p[N]), p[M], p[L], p[INERTIA], p[OMEGA]
    dry = p[FT0] > 0 or p[FT0_BACK] > 0 or p[FN0] > 0
    st, ct = math.sin(w * t), math.cos(w * t)
    th, om, turn, vx, vy = y[2], y[5], 0.0, y[3], y[4]
    c, s = math.cos(th), math.sin(th)
    rx = ry = bx = by = Rx = Ry = rr = gx = gy = moment = turns = 0.0
    for i in range(n):
        if i > 0:
            a, b = p[HEAD - 1 + i], p[HEAD - 1 + n - 1 + i]
            sine, cosine = p[ALPHA] * (st * a + ct * b), p[ALPHA] * (ct * a - st * b)
            c0, s0, om0, turn0 = c, s, om, turn
            th += p[OFFSET] + sine
            om += w * cosine
            turn -= w * w * sine
            c, s = math.cos(th), math.sin(th)
            rx += half * (c0 + c)
            ry += half * (s0 + s)
            vx -= half * (om0 * s0 + om * s)
            vy += half * (om0 * c0 + om * c)
            bx -= half * (turn0 * s0 + om0 * om0 * c0 + turn * s + om * om * c)
            by += half * (turn0 * c0 - om0 * om0 * s0 + turn * c - om * om * s)
        vt, vn = c * vx + s * vy, c * vy - s * vx
        ft, fn = _along(vt, p, dry), -p[CN] * vn
        if dry:
            fn -= p[FN0] * _sign(vn, p[WIDTH])
        qx, qy = ft * c - fn * s - m * bx, ft * s + fn * c - m * by
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
    n, m, half, inertia, w = int(p[N]), p[M], p[L], p[INERTIA], p[OMEGA]
    dry = p[FT0] > 0 or p[FT0_BACK] > 0 or p[FN0] > 0
    st, ct = math.sin(w * t), math.cos(w * t)
    th, om, turn = y[4 * n], y[4 * n + 1], 0.0
    couple = turns = c0 = s0 = om0 = 0.0
    for i in range(n):
        if i > 0:
            a, b = p[HEAD - 1 + i], p[HEAD - 1 + n - 1 + i]
            sine, cosine = p[ALPHA] * (st * a + ct * b), p[ALPHA] * (ct * a - st * b)
            th += p[OFFSET] + sine
            om += w * cosine
            turn -= w * w * sine
        c, s = math.cos(th), math.sin(th)
        vx, vy = y[2 * n + i], y[3 * n + i]
        vt, vn = c * vx + s * vy, c * vy - s * vx
        ft, fn = _along(vt, p, dry), -p[CN] * vn
        if dry:
            fn -= p[FN0] * _sign(vn, p[WIDTH])
        ax, ay = (ft * c - fn * s) / m, (ft * s + fn * c) / m
        if i > 0:
            gap_x = y[i] - y[i - 1] - half * (c + c0)
            gap_y = y[n + i] - y[n + i - 1] - half * (s + s0)
            rate_x = vx - y[2 * n + i - 1] + half * (om * s + om0 * s0)
            rate_y = vy - y[3 * n + i - 1] - half * (om * c + om0 * c0)
            fx, fy = p[K] * gap_x + p[C] * rate_x, p[K] * gap_y + p[C] * rate_y
            couple += half * (fy * (c + c0) - fx * (s + s0))
            dy[2 * n + i - 1] += fx / m
            dy[3 * n + i - 1] += fy / m
            ax -= fx / m
            ay -= fy / m
        dy[i], dy[n + i], dy[2 * n + i], dy[3 * n + i] = vx, vy, ax, ay
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


@njit(**_JIT)
def rk4(implicit, y0, p, dt, steps):
    """Run the classical method at a fixed step and return the end state."""
    y = y0.copy()
    k1, k2, k3, k4, z = (
        np.empty_like(y),
        np.empty_like(y),
        np.empty_like(y),
        np.empty_like(y),
        np.empty_like(y),
    )
    for step in range(steps):
        t = step * dt
        fill_rate(implicit, t, y, p, k1)
        for i in range(y.size):
            z[i] = y[i] + dt / 2 * k1[i]
        fill_rate(implicit, t + dt / 2, z, p, k2)
        for i in range(y.size):
            z[i] = y[i] + dt / 2 * k2[i]
        fill_rate(implicit, t + dt / 2, z, p, k3)
        for i in range(y.size):
            z[i] = y[i] + dt * k3[i]
        fill_rate(implicit, t + dt, z, p, k4)
        for i in range(y.size):
            y[i] += dt / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i])
    return y


_A = np.ascontiguousarray(dop853.A[:12, :12])
_NODES = np.ascontiguousarray(dop853.C[:12])
_B, _E3, _E5 = dop853.B.copy(), dop853.E3[:12].copy(), dop853.E5[:12].copy()


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
        for stage in range(1, 12):
            for i in range(d):
                z[i] = y[i]
            for j in range(stage):
                a = h * _A[stage, j]
                if a != 0:
                    for i in range(d):
                        z[i] += a * k[j, i]
            fill_rate(implicit, t + _NODES[stage] * h, z, p, k[stage])
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
