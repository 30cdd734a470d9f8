"""The search for the gait of least power at a speed: a table of shapes, then Nelder-Mead.

A shape is an amplitude and a phase lag. Its rate follows from the wanted speed, so two coordinates
are searched. A coarse table gives the cheapest shapes. Nelder-Mead follows the lowest few, and
starts again at the best, with a smaller simplex each time, until that gains nothing.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar

from .. import _core
from ..base.errors import SerpenoidError
from ..base.long_calls import threads_to_use
from ..base.vectors import Array
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import speed_floor_m_s, state_near
from ..simulation.steady_springs import steady_springs
from .limits import GaitLimits, peak_torque_nm, speed_shares

COSTS = ("power", "abs_power", "positive_power")  # Mean powers that a search makes least.
ROUGH_RTOL = 1e-3  # Accuracy of dry states, and of springs, while shapes are compared.
FINE_RTOL = 1e-5  # Accuracy of dry states near the optimum.
SMOOTH_RTOL = 1e-8  # Accuracy of viscous states.
ALPHAS_RAD = np.radians(np.geomspace(6.0, 150.0, 15))  # Amplitudes: gaits outside hardly travel.
MAX_LAG_RAD = math.radians(175.0)  # Largest phase lag: a standing wave, of 180 deg, goes nowhere.
START_PENALTY = 8.0  # Slope of ln cost over ln excess beyond a limit: a start may lie beyond one.
FIRST_END = 0.02  # E-folds of the simplex at which the first descents end.
ON_LIMIT = 1e-6  # E-folds from a limit that count as on it.


@dataclass(frozen=True)
class Point:
    """Hold a shape and its gait at the wanted speed.

    log_shape: ln alpha and ln tan(beta / 2). gait: None where no periodic state was found.
    log_cost: ln of the cost in W. margin: e-folds to the nearest limit, below 0 beyond it or where
    no rate gives the speed. share_margin: the same of the share of speed that is to be kept; the
    search may end below it, where no gait keeps the share. angle_margin: the same of the joint
    angle, which is a bound of the shapes. state: where to begin states near it.
    """

    log_shape: Array
    gait: Gait | None = None
    log_cost: float = 1e3
    margin: float = -1.0
    share_margin: float = math.inf
    angle_margin: float = math.inf
    state: Any = None

    @property
    def price(self) -> float:
        """Return what the search makes least: ln cost, and more beyond a limit."""
        # Slopes of ln cost over ln excess: cost never falls as fast as 300 beyond a limit. That of
        # the share of speed is smaller, as this limit gives way to the others.
        lack = 300.0 * min(self.margin, 0.0) + 30.0 * min(self.share_margin, 0.0)
        return self.log_cost - lack


def log_shape(alpha_rad: float, beta_rad: float) -> Array:
    """Return the coordinates of a shape, (2,)."""
    return np.log([alpha_rad, math.tan(beta_rad / 2)])


def angles_of(shape: Array) -> tuple[float, float]:
    """Return amplitude and phase lag of a shape's coordinates, rad."""
    alpha, tangent = np.exp(shape).tolist()
    return alpha, 2 * math.atan(tangent)


@dataclass(frozen=True)
class Search:
    """Finds the cheapest gait of one robot on one ground at one speed.

    springs: stiffness and damping of the implicit formulation's joints; None: the exact model.
    """

    robot: Robot
    ground: Ground
    speed_m_s: float
    cost: str
    limits: GaitLimits
    springs: tuple[float, float] | None = None

    @property
    def smooth(self) -> bool:
        """Tell whether states are known to many digits."""
        return self.ground.smooth and self.springs is None

    @property
    def accuracy(self) -> tuple[float, float]:
        """Return the accuracy of states near the optimum, and of shapes, e-folds."""
        if self.springs is not None:
            return ROUGH_RTOL, FIRST_END / 4
        return (SMOOTH_RTOL, 1e-4) if self.smooth else (FINE_RTOL, 1e-3)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the least and greatest coordinates of a shape, (2,) each."""
        low = log_shape(ALPHAS_RAD[0] / 6, min(0.08, 0.8 / self.robot.links))
        return low, log_shape(min(self.limits.joint_angle_rad, ALPHAS_RAD[-1]), MAX_LAG_RAD)

    def grid(self) -> tuple[Array, Array]:
        """Return the amplitudes and phase lags of the table, rad."""
        widest, n = math.exp(self.bounds[1][0]), self.robot.links
        alphas = np.append(ALPHAS_RAD[widest > ALPHAS_RAD], widest)
        lowest = min(math.radians(22), 2.2 / n)
        many_links = 8  # Longer robots have several narrow valleys.
        return alphas, np.geomspace(lowest, MAX_LAG_RAD, 20 if n > many_links else 14)

    # States of gaits.

    def state(self, gait: Gait, rtol: float, start: Any = None) -> Any:
        """Return a gait's periodic state, also one that is a near miss, or None.

        start: a state near it, from which the first state found on dry ground will do.
        """
        if self.springs is None:
            begin = start if not self.ground.smooth else None
            powers = self.cost != "power"
            state = state_near(self.robot, self.ground, gait, rtol=rtol, powers=powers, start=begin)
            # A state with ten times the error asked for still ranks shapes.
            accepted = begin is not None or state.error_estimate < 10 * rtol
            return state if accepted else None
        stiffness, damping = self.springs
        with suppress(SerpenoidError):
            return steady_springs(
                self.robot,
                self.ground,
                gait,
                joint_stiffness_n_m=stiffness,
                joint_damping_n_s_m=damping,
                rtol=rtol,
            )
        return None

    def watts(self, state: Any) -> float:
        """Return the cost of a state, W."""
        return getattr(state, f"{self.cost}_w")

    def margin(self, gait: Gait) -> float:
        """Return by how many e-folds a gait is within its nearest limit, below 0 beyond it."""
        return min(self.limits.margins(gait, self.torque_nm(gait)).values(), default=math.inf)

    def torque_nm(self, gait: Gait) -> float:
        """Return the gait's peak torque where there is a limit to it, else 0."""
        if self.limits.servo_torque_nm == math.inf:
            return 0.0
        return peak_torque_nm(self.robot, self.ground, gait)

    def share_margin(self, gait: Gait, rtol: float, state: Any = None) -> float:
        """Return ln of the share of speed that a gait keeps, over the share that it is to keep."""
        if self.limits.kept_speed_share == 0:
            return math.inf
        start_state = state if self.springs is None else None
        shares = speed_shares(self.robot, self.ground, gait, rtol=rtol, state=start_state)
        # A gait that keeps less than a thousandth counts as one that stops.
        share = max(min(shares), 1e-3) if math.isfinite(sum(shares)) else 1e-3
        return math.log(share / self.limits.kept_speed_share)

    def rates(
        self, gait: Gait, rtol: float, start: Any = None, chained: bool = False
    ) -> list[tuple[float, float, Any]]:
        """Return rates around the wanted speed: ln rate, ln speed ratio and state, nearest first.

        A secant method in logarithms, kept between rates that are too slow and too fast where both
        are known. gait: its rate is where to begin. chained: each state begins at the one before.
        """
        x, slope = math.log(gait.omega_rad_s), 1.0
        tried: list[tuple[float, float, Any]] = []
        slow, fast, rounding = -math.inf, math.inf, 1e-12
        # The safeguarded secant method takes 12 states at most.
        for _ in range(12):
            state = self.state(replace(gait, omega_rad_s=math.exp(x)), rtol, start)
            if state is None:
                break
            start = state if chained else None
            miss = math.log(max(state.speed_m_s / self.speed_m_s, 1e-4))
            tried.append((x, miss, state))
            if abs(miss) < rtol / 10:
                break
            slow, fast = (max(slow, x), fast) if miss < 0 else (slow, min(fast, x))
            if len(tried) > 1 and tried[-2][0] != x:
                slope = (miss - tried[-2][1]) / (x - tried[-2][0])
            # Beyond these slopes of ln speed over ln rate 1 is as good a guess.
            low, high = 0.1, 10.0
            step = -miss / (slope if low < slope < high else 1.0)
            x += min(max(step, -0.5), 0.5)
            if slow < fast and not slow < x < fast:
                x = (slow + fast) / 2
            if fast - slow < rounding:
                break
        return sorted(tried, key=lambda trial: abs(trial[1]))

    def point(self, shape: Array, neighbour: Point, rtol: float) -> Point:
        """Return a shape at the rate that gives the speed, found from another's.

        The last small miss is put right by a straight line.
        """
        assert neighbour.gait is not None
        gait = Gait(*angles_of(shape), neighbour.gait.omega_rad_s)
        tried = self.rates(gait, rtol, neighbour.state, chained=True)
        if not tried:
            return Point(shape)
        cost, *next_costs = [math.log(max(self.watts(state), 1e-300)) for *_, state in tried[:2]]
        (x, miss, state), *next_rates = tried
        if abs(miss) >= rtol:
            gait = replace(gait, omega_rad_s=math.exp(x))
            return Point(shape, gait, cost, -abs(miss), state=state)
        if next_rates and next_rates[0][1] != miss:
            part = miss / (miss - next_rates[0][1])
            x += part * (next_rates[0][0] - x)
            cost += part * (next_costs[0] - cost)
        else:
            cost -= 2 * miss  # about a square law
        gait = replace(gait, omega_rad_s=math.exp(x))
        share = self.share_margin(gait, rtol, state)
        angle = float(self.bounds[1][0] - shape[0])
        return Point(shape, gait, cost, self.margin(gait) + ON_LIMIT, share, angle, state)

    # Where to begin.

    def starts(self) -> list[Point]:
        """Return the cheapest shapes of a coarse table, in different valleys, cheapest first."""
        # The robustness of the 60 cheapest shapes is looked at.
        points = sorted(self._table(), key=lambda point: point.log_cost)[:60]
        points = [self._with_share(point) for point in points]
        points.sort(key=lambda point: point.log_cost)
        starts: list[Point] = []
        least_distance = 0.35  # E-folds between two starts, so that they lie in different valleys.
        for point in points:
            distances = (math.dist(point.log_shape, start.log_shape) for start in starts)
            # The coarse table may hide a factor of 1.6 of the cost.
            cheap = not starts or point.log_cost < starts[0].log_cost + math.log(1.6)
            if cheap and min(distances, default=math.inf) > least_distance:
                starts.append(point)
        return starts[:4]

    def _with_share(self, point: Point) -> Point:
        """Return a start made dearer by what it lacks of the share of speed that is to be kept."""
        assert point.gait is not None
        lack = -min(self.share_margin(point.gait, ROUGH_RTOL), 0.0)
        return replace(point, log_cost=point.log_cost + START_PENALTY * lack)

    def _table(self) -> list[Point]:
        """Return shapes of a grid at the rates that give the speed, about; limits make dearer."""
        alphas, lags = self.grid()
        points: list[Point] = []
        # The middle lags are the likeliest: what they cost leaves out most of the others.
        for beta in lags[np.argsort(abs(np.log(lags * self.robot.links / 9)))].tolist():
            cheapest = min((point.log_cost for point in points), default=math.inf)
            points += self._column(beta, alphas, cheapest)
        return points

    def _column(self, beta_rad: float, alphas: Array, cheapest: float) -> list[Point]:
        """Return the shapes of one lag, upwards in rate while they may be cheap and do not reach.

        A wave travels at no more than omega L / beta, so slower rates are left out.
        """
        limits = self.limits
        # The first rate is 1.05 times that at which the wave travels at the wanted speed.
        lowest = 1.05 * self.speed_m_s * beta_rad / self.robot.link_length_m
        lowest = max(lowest, limits.omega_low_rad_s)
        rate_step = 1.45  # Factor between rates: lines between them err by a few per cent.
        shapes = [(alpha, beta_rad) for alpha in alphas.tolist()]
        last: list[tuple[float, float, float] | None] = [None] * len(shapes)
        active = [
            k
            for k, (alpha, _) in enumerate(shapes)
            if lowest < rate_step * min(limits.servo_speed_rad_s / alpha, limits.omega_high_rad_s)
        ]
        points = []
        # 28 rates span a factor of 20 000. Four are solved together, before shapes that cost too
        # much are left out.
        for first in range(0, 28, 4):
            if not active:
                break
            rates = lowest * rate_step ** np.arange(first, first + 4)
            rows = self._solved([shapes[k] for k in active], rates)
            unreached = []
            for k, row in zip(active, rows, strict=True):
                for rate, (miss, cost) in zip(rates.tolist(), row.tolist(), strict=True):
                    if math.isnan(miss):
                        continue
                    if miss >= 0:
                        points.append(self._crossing(shapes[k], last[k], (rate, miss, cost)))
                        break
                    last[k] = rate, miss, cost
                else:
                    highest = min(limits.servo_speed_rad_s / shapes[k][0], limits.omega_high_rad_s)
                    below = last[k]
                    dear = below is not None and below[2] > cheapest
                    if not dear and rates[-1] < rate_step * highest:
                        unreached.append(k)
            active = unreached
            cheapest = min([cheapest, *(point.log_cost for point in points)])
        return points

    def _solved(self, shapes: list[tuple[float, float]], rates: NDArray[Any]) -> Array:
        """Return ln of speed over the wanted one, and ln of the cost, (shapes, rates, 2)."""
        models = [core_model(self.robot, self.ground, Gait(*shape, 1.0)) for shape in shapes]
        powers = self.cost != "power"
        rows = _core.sweep(
            models, rates.tolist(), ROUGH_RTOL, powers, threads_to_use(), None, rough=True
        )
        noise = ROUGH_RTOL * rates * speed_floor_m_s(self.robot, 1.0)
        speed = np.where(rows[..., 0] > noise, rows[..., 0], 1e-300)
        cost = rows[..., 1 + COSTS.index(self.cost)]
        solved = (rows[..., 10] > 0) & (cost > 0)
        with np.errstate(all="ignore"):
            logs = np.log(np.stack([speed / self.speed_m_s, cost], axis=-1))
        return np.where(solved[..., None], logs, np.nan)

    def _crossing(
        self,
        shape: tuple[float, float],
        below: tuple[float, float, float] | None,
        above: tuple[float, float, float],
    ) -> Point:
        """Return a shape's point by a straight line between two rates, or from one that is fast.

        below, above: rate, ln speed ratio, ln cost.
        """
        rate, miss, cost = above
        if below is None:
            x, cost = math.log(rate) - miss, cost - 2 * miss
        else:
            part = miss / (miss - below[1])
            x = math.log(rate) - part * math.log(rate / below[0])
            cost -= part * (cost - below[2])
        gait = Gait(*shape, math.exp(x))
        margin = min(self.limits.margins(gait).values(), default=0.0)
        cost += START_PENALTY * max(-margin, 0.0)
        return Point(log_shape(*shape), gait, cost)

    # The descent.

    def descend(self, start: Point, size: float, end: float, rtol: float) -> Point:
        """Return the lowest point that Nelder-Mead finds from a start.

        size: of the simplex, e-folds; below 0 it looks the other way. end: e-folds.
        """
        low, high = self.bounds
        points = [self.point(start.log_shape, start, rtol)]
        if points[0].gait is None:
            points[0] = replace(points[0], gait=start.gait, state=start.state)

        steps = np.full(2, size)
        beyond = (start.log_shape + steps > high) | (start.log_shape + steps < low)
        steps[beyond] *= -1
        minimize(
            lambda shape: self._joined(points, shape, rtol).price,
            start.log_shape,
            method="Nelder-Mead",
            bounds=list(zip(low, high, strict=True)),
            options={
                "initial_simplex": start.log_shape + np.vstack([np.zeros(2), np.diag(steps)]),
                "xatol": end,
                "fatol": end**2,
                "maxfev": 90,
            },
        )
        return min(points, key=lambda point: point.price)

    def _joined(self, points: list[Point], shape: Array, rtol: float) -> Point:
        """Return a shape's point, found from the nearest of some points, which it joins."""
        neighbour = min(points, key=lambda point: math.dist(point.log_shape, shape))
        point = self.point(np.clip(shape, *self.bounds), neighbour, rtol)
        if point.gait is not None:
            points.append(point)
        return point

    def along_limit(self, margin: str, start: Point, size: float, rtol: float) -> Point:
        """Return the lowest point on the limit that a start has reached, near it.

        margin: the attribute of Point that is 0 there.

        By Brent's method along the limit's tangent; each shape is put onto the limit along its
        normal. Nelder-Mead alone ends early at such an edge.
        """
        points = [start]
        probe = 1e-3  # E-folds of shape between two margins that give the limit's direction.

        shapes = start.log_shape + probe * np.eye(2)
        margins = [getattr(self._joined(points, shape, rtol), margin) for shape in shapes]
        gradient = (np.array(margins) - getattr(start, margin)) / probe
        steepness = float(np.hypot(*gradient))
        if not 0 < steepness < math.inf:
            return start
        normal = gradient / steepness
        tangent = np.array([-normal[1], normal[0]])

        def price(along: float) -> float:
            shape = start.log_shape + along * tangent
            best = math.inf
            for _ in range(4):
                end = self._joined(points, shape, rtol)
                best = min(best, end.price)
                if abs(getattr(end, margin)) < ON_LIMIT:
                    break
                across = getattr(end, margin) / steepness
                shape = shape - np.clip(across, -abs(size), abs(size)) * normal
            return best

        minimize_scalar(
            price, bracket=(0.0, size), method="brent", options={"xtol": 1e-3, "maxiter": 14}
        )
        return min(points, key=lambda end: end.price)

    def best(self) -> tuple[Point, float] | None:
        """Return the cheapest point and what the last two restarts gained, e-folds of cost.

        None where no shape of the table reaches the speed.
        """
        starts = self.starts()
        if not starts:
            return None
        exact = replace(self, springs=None)
        rtol = SMOOTH_RTOL if exact.smooth else ROUGH_RTOL
        first_size = 0.15  # E-folds of the first simplex: half a step of the table.
        ends = [exact.descend(start, first_size, FIRST_END, rtol) for start in starts]
        best = min(ends, key=lambda point: point.price)
        rtol, end = self.accuracy
        best = self.point(best.log_shape, best, rtol)
        size, gains = -first_size / 2, [math.inf, math.inf]
        near_limit = 0.02  # E-folds within a limit: from here the limit itself is followed.
        for _ in range(8):
            lower = self.descend(best, size, end, rtol)
            for margin in ("margin", "share_margin", "angle_margin"):
                if abs(getattr(lower, margin)) < near_limit:
                    lower = self.along_limit(margin, lower, size, rtol)
            gains.append(abs(best.price - lower.price))
            best = lower
            # Two restarts that gain less than 1e-7 of the cost end a search of exact states.
            if sum(gains[-2:]) < max(rtol, 1e-7):
                break
            size *= -0.6
        return best, sum(gains[-2:])

    def fastest(self) -> Point | None:
        """Return the fastest gait of the table within angles and rates; log_cost is -ln speed."""
        limits, fastest = self.limits, None
        alphas, lags = self.grid()
        for alpha in alphas.tolist():
            top = min(limits.servo_speed_rad_s / alpha, limits.omega_high_rad_s)
            if top == math.inf:
                # Where no limit bounds the rate, 1000 times speed over link length does.
                top = 1e3 * self.speed_m_s / self.robot.link_length_m
            rates = top * np.array([0.25, 0.5, 1.0])
            misses = self._solved([(alpha, beta) for beta in lags.tolist()], rates)[..., 0]
            if np.isnan(misses).all():
                continue
            k, j = np.unravel_index(np.nanargmax(misses), misses.shape)
            if fastest is None or -misses[k, j] < fastest.log_cost:
                gait = Gait(alpha, float(lags[k]), float(rates[j]))
                fastest = Point(log_shape(alpha, lags[k]), gait, -float(misses[k, j]))
        return fastest
