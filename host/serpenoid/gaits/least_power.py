"""The gait that costs least power at a given speed (the paper's Figs. 8-11, for any ground)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..model.checks import check_choice, check_number
from ..model.core_model import check_parts
from ..model.errors import NotConverged, SerpenoidError
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, steady_gait
from ..periodic.sweep import sweep

COSTS = ("power", "abs_power", "positive_power")
_GRID_ALPHA = np.radians(np.arange(10.0, 81.0, 10.0))
_GRID_BETA = np.radians(np.arange(20.0, 131.0, 10.0))
_LOW, _HIGH = np.radians([2.0, 5.0]), np.radians([110.0, 175.0])


@dataclass(frozen=True, slots=True)
class LeastPower:
    """Hold the cheapest gait for a speed: the gait, the power that was made least, the speed."""

    gait: Gait
    power_w: float
    speed_m_s: float
    cost: str
    steady: Steady


class _Search:
    """Power as a function of shape alone: the rate is whatever gives the wanted speed."""

    def __init__(self, robot: Robot, ground: Ground, speed: float, cost: str, rtol: float) -> None:
        self.robot, self.ground, self.speed, self.cost = robot, ground, speed, cost
        self.rtol, self.omega = rtol, 1.0

    def solve(self, alpha: float, beta: float, omega: float) -> Steady:
        gait = Gait(alpha, beta, omega)
        powers = self.cost != "power"
        return steady_gait(self.robot, self.ground, gait, rtol=self.rtol, powers=powers)

    def at(self, shape: np.ndarray) -> Steady:
        """Return the state with the wanted speed: secant on log speed against log rate."""
        alpha, beta = shape
        x0, x1 = math.log(self.omega), math.log(self.omega) + 0.05
        goal = math.log(self.speed)
        s0 = self.solve(alpha, beta, math.exp(x0))
        y0 = math.log(max(s0.speed_m_s, 1e-300)) - goal
        for _ in range(60):
            s1 = self.solve(alpha, beta, math.exp(x1))
            y1 = math.log(max(s1.speed_m_s, 1e-300)) - goal
            if abs(y1) <= 10 * self.rtol:
                self.omega = math.exp(x1)
                return s1
            slope = (y1 - y0) / (x1 - x0)
            x0, y0 = x1, y1
            x1 -= min(max(y1 / slope if slope > 0.02 else math.copysign(0.5, y1), -0.7), 0.7)
        raise NotConverged(
            f"no rate gives {self.speed:g} m/s at alpha {math.degrees(alpha):.1f} deg, "
            f"beta {math.degrees(beta):.1f} deg; ask for another speed"
        )

    def watts(self, shape: np.ndarray) -> float:
        """Return the cost at this shape, infinite outside the search range or where none exists."""
        if np.any(shape < _LOW) or np.any(shape > _HIGH):
            return math.inf
        try:
            return getattr(self.at(shape), f"{self.cost}_w")
        except SerpenoidError:
            return math.inf


def _coarse(search: _Search) -> tuple[np.ndarray, float]:
    """Return the best shape and rate of a grid whose rates bracket the wanted speed."""
    wave = search.robot.link_length_m * search.robot.links
    # a dry gait takes a hundred times longer than a viscous one: fewer rates in the same range
    rates = search.speed / wave * np.geomspace(1.5, 60.0, 8 if search.ground.dry else 14)
    grid = sweep(
        search.robot, search.ground, alpha_rad=_GRID_ALPHA, beta_rad=_GRID_BETA, omega_rad_s=rates,
        rtol=1e-3, powers=search.cost != "power",
    )  # fmt: skip
    cost = getattr(grid, f"{search.cost}_w")
    best = (math.inf, _GRID_ALPHA[0], _GRID_BETA[0], rates[0])
    for i, alpha in enumerate(_GRID_ALPHA):
        for j, beta in enumerate(_GRID_BETA):
            v, p = grid.speed_m_s[i, j], cost[i, j]
            for k in range(rates.size - 1):
                if v[k] <= search.speed <= v[k + 1] and grid.converged[i, j, k : k + 2].all():
                    f = (search.speed - v[k]) / max(v[k + 1] - v[k], 1e-300)
                    watts = p[k] + f * (p[k + 1] - p[k])
                    rate = rates[k] + f * (rates[k + 1] - rates[k])
                    best = min(best, (watts, alpha, beta, rate))
    if not math.isfinite(best[0]):
        raise NotConverged(
            f"no gait of the search grid reaches {search.speed:g} m/s with rates from "
            f"{rates[0]:.3g} to {rates[-1]:.3g} rad/s; ask for another speed"
        )
    return np.array(best[1:3]), float(best[3])


def least_power_gait(
    robot: Robot,
    ground: Ground,
    *,
    speed_m_s: float,
    cost: str = "power",
    rtol: float | None = None,
) -> LeastPower:
    """Find alpha, beta and omega that give a speed for the least mean power, explicit model.

    cost: "power" (net; the paper's), "abs_power" or "positive_power" (a servo that does not
    regenerate). A grid of shapes first, then a simplex search in (alpha, beta) with the rate solved
    for the speed. rtol: accuracy of each evaluation (1e-10 viscous, 1e-5 dry unless given). Raises
    BadInput, NotConverged when no gait reaches the speed.
    """
    from scipy.optimize import minimize

    check_parts(robot, ground)
    check_number("speed_m_s", speed_m_s, 0.0, open_low=True)
    check_choice("cost", cost, COSTS)
    if rtol is None:
        rtol = 1e-5 if ground.dry else (1e-10 if cost == "power" else 1e-8)
    search = _Search(robot, ground, float(speed_m_s), cost, rtol)
    shape, search.omega = _coarse(search)
    found = minimize(
        search.watts, shape, method="Nelder-Mead",
        options={"initial_simplex": shape + np.radians([[0, 0], [4, 0], [0, 4]]),
                 "xatol": max(1e-6, 100 * rtol), "fatol": 10 * rtol * search.watts(shape),
                 "maxfev": 400},
    )  # fmt: skip
    best = search.at(found.x)
    return LeastPower(best.gait, getattr(best, f"{cost}_w"), best.speed_m_s, cost, best)
