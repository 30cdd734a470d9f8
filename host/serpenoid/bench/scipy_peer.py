"""SciPy's solve_ivp on both models written in plain NumPy: what a user has without this package.

State, explicit: x, y, theta of link 1 and their rates. Implicit: x, y, vx, vy of all links (n
values each), then theta and its rate of link 1. Written from the equations of motion, sharing
nothing with the compiled core. Dry friction: the sign is smoothed, v / sqrt(v^2 + width^2), since
solve_ivp wants a continuous right-hand side.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from .contender import TOLERANCES, Contender, Work
from .problems import Array, Problem

METHODS = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
WIDTHS_M_S = (1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6)
DRY_TOLERANCE = 1e-7  # with a smoothed sign: finer than what the widths leave
Rate = Callable[[float, Array], Array]


def running_sum(first: float, steps: Array) -> Array:
    """Return the sums of `first` and the leading steps, one more than there are steps."""
    return np.concatenate([[first], first + np.cumsum(steps)])


def neighbour_sum(values: Array) -> Array:
    """Return the sum of each value and the next one."""
    return values[:-1] + values[1:]


class Equations:
    """Hold a problem's equations of motion; width_m_s: of the smoothed sign, 0: none."""

    def __init__(self, problem: Problem, width_m_s: float = 0.0):
        self.problem, self.width_m_s = problem, width_m_s
        robot = problem.robot
        self.n, self.mass, self.half = robot.links, robot.link_mass_kg, robot.link_length_m / 2
        self.inertia = robot.inertia_kg_m2
        self.lag_rad = problem.gait.beta_rad * np.arange(self.n - 1)
        self.rate: Rate = self.implicit if problem.implicit else self.explicit

    def turned(self, t: float, theta: float, omega: float) -> tuple[Array, Array, Array]:
        """Return angles of all links, their rates, and accelerations but for that of link 1."""
        gait = self.problem.gait
        phase, w = gait.omega_rad_s * t + self.lag_rad, gait.omega_rad_s
        sine, cosine = gait.alpha_rad * np.sin(phase), gait.alpha_rad * np.cos(phase)
        angles = running_sum(theta, gait.offset_rad + sine)
        return angles, running_sum(omega, w * cosine), running_sum(0.0, -w * w * sine)

    def sign(self, v: Array) -> Array:
        """Return the sign of a speed, smoothed."""
        width = self.width_m_s
        return v / np.sqrt(v * v + width * width) if width > 0.0 else np.sign(v)

    def ground(self, c: Array, s: Array, vx: Array, vy: Array) -> tuple[Array, Array]:
        """Return the ground's force on each link, along x and y."""
        ground = self.problem.ground
        along, across = c * vx + s * vy, c * vy - s * vx
        ahead = along > 0.0
        ct = np.where(ahead, ground.ct_forward, ground.ct_backward)
        ft0 = np.where(ahead, ground.ft0_forward, ground.ft0_backward)
        ft = -ct * along - ft0 * self.sign(along)
        fn = -ground.cn * across - ground.fn0 * self.sign(across)
        return ft * c - fn * s, ft * s + fn * c

    def explicit(self, t: float, y: Array) -> Array:
        """Return y' of the exact model: three unknowns, by sums over the links."""
        n, m, half = self.n, self.mass, self.half
        angles, om, turn = self.turned(t, y[2], y[5])
        c, s = np.cos(angles), np.sin(angles)
        rx, ry = (running_sum(0.0, half * neighbour_sum(part)) for part in (c, s))
        vx = running_sum(y[3], -half * neighbour_sum(om * s))
        vy = running_sum(y[4], half * neighbour_sum(om * c))
        bx = running_sum(0.0, -half * neighbour_sum(turn * s + om * om * c))
        by = running_sum(0.0, half * neighbour_sum(turn * c - om * om * s))
        gx, gy = self.ground(c, s, vx, vy)
        gx, gy = gx - m * bx, gy - m * by
        x_sum, y_sum, force_x, force_y = rx.sum(), ry.sum(), gx.sum(), gy.sum()
        moment = (rx * gy - ry * gx).sum() - self.inertia * turn.sum()
        moment += (y_sum * force_x - x_sum * force_y) / n
        spread = (rx * rx + ry * ry).sum() - (x_sum * x_sum + y_sum * y_sum) / n
        spin = moment / (n * self.inertia + m * spread)
        ax, ay = (force_x / m + y_sum * spin) / n, (force_y / m - x_sum * spin) / n
        return np.array([y[3], y[4], y[5], ax, ay, spin])

    def implicit(self, t: float, y: Array) -> Array:
        """Return y' of the model with springs and dampers in the joints (Eqs. 51-56)."""
        n, half, problem = self.n, self.half, self.problem
        angles, om, turn = self.turned(t, y[4 * n], y[4 * n + 1])
        c, s = np.cos(angles), np.sin(angles)
        x, y_links, vx, vy = y[: 4 * n].reshape(4, n)
        gx, gy = self.ground(c, s, vx, vy)
        cosines, sines = neighbour_sum(c), neighbour_sum(s)
        gap_x, gap_y = np.diff(x) - half * cosines, np.diff(y_links) - half * sines
        rate_x = np.diff(vx) + half * neighbour_sum(om * s)
        rate_y = np.diff(vy) - half * neighbour_sum(om * c)
        fx = problem.stiffness_n_m * gap_x + problem.damping_n_s_m * rate_x
        fy = problem.stiffness_n_m * gap_y + problem.damping_n_s_m * rate_y
        for force, pull in ((gx, fx), (gy, fy)):
            force[:-1] += pull
            force[1:] -= pull
        couple = half * (fy * cosines - fx * sines).sum()
        spin = (couple - self.inertia * turn.sum()) / (n * self.inertia)
        return np.concatenate([vx, vy, gx / self.mass, gy / self.mass, [y[4 * n + 1], spin]])


def solve(problem: Problem, method: str, tolerance: float, width_m_s: float = 0.0) -> Array:
    """Return the end state by a method of solve_ivp; raises ArithmeticError where it fails."""
    from scipy.integrate import solve_ivp

    out = solve_ivp(
        Equations(problem, width_m_s).rate,
        (0, problem.duration_s),
        problem.first,
        method,
        rtol=max(tolerance, 1e-13),
        atol=tolerance / 10,
    )
    if not out.success:
        raise ArithmeticError(out.message)
    return out.y[:, -1]


def _work(problem: Problem, method: str, setting: float) -> Work:
    if problem.ground.dry:
        return partial(solve, problem, method, DRY_TOLERANCE, setting)
    return partial(solve, problem, method, setting)


def scipy(problem: Problem) -> list[Contender]:
    """Return the solvers of solve_ivp; on dry ground the width of the sign is the setting."""
    dry = problem.ground.dry
    kind, settings = ("width_m_s", WIDTHS_M_S) if dry else ("tolerance", TOLERANCES)
    return [
        Contender(f"SciPy {name}", "SciPy", kind, settings, partial(_work, problem, name))
        for name in METHODS
    ]
