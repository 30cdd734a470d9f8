"""The search for a robust gait: sampled speeds, their low percentile, the rate that lifts it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..model.core_model import core_model
from ..model.drives import Servo
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.grid import threads_to_use
from ..periodic.servo_steady import servo_speeds
from ..periodic.steady import MAX_ELEMENTS, Steady, steady_gait
from .quadratic_search import Array, Point, minimize
from .shape_search import GaitShape
from .uncertainty import SERVOS, Sample

if TYPE_CHECKING:
    from .finder import Finder
    from .gait_table import Candidate

KEEP, QUANTILE = 0.9, 0.05
_RTOL, _IDEAL_RTOL, _LEAST_M_S = 3e-3, 1e-3, 1e-9
_RANKED = 32  # samples by which the shapes of the cloud are ranked
_KEPT = 8  # one in so many samples is followed: the slowest where the search starts
_MOST_OVER = 2.5  # a shape that needs so many times its nominal rate is given up
_STEP, _SERVO_STEP = 0.4, 0.15  # of ln rate; servos have a fastest rate, soon overstepped
_NEAR = 0.03  # of the low speed: closer than this the rate is corrected by the slope known


def sampled_speeds(
    robot: Robot, gait: Gait, samples: Sequence[Sample], shares: ServoShares | None = None
) -> Array:
    """Return the speed of each sampled robot under one command, m/s; 0 where none was found.

    shares: what each sample's servo leaves of it; None: ideal joints.
    """
    models = [core_model(robot, sample.ground, sample.gait(gait)) for sample in samples]
    threads = min(threads_to_use(None), len(models))
    states = _core.neighbours(models[0], models, _RTOL, False, MAX_ELEMENTS, threads)
    speeds = np.nan_to_num([s.speed for s in states])
    return speeds if shares is None else speeds * shares.of(gait, samples)


class ServoShares:
    """The speed with a servo over that of ideal joints, on one ground.

    A servo costs several times an ideal gait, and few are among the slowest samples. So the share
    of each servo is solved for roughly, once a gait, on the nominal ground, and serves all samples.
    That is 3 to 4 % off in the median; the check of a robust gait solves each robot for itself.
    """

    def __init__(self, robot: Robot, ground: Ground) -> None:
        self._robot, self._ground = robot, ground
        self._known: dict[Gait, dict[Servo, float]] = {}

    def of(self, gait: Gait, samples: Sequence[Sample]) -> Array:
        """Return the share of each sample's servo, 1 where it has none."""
        known = self._known.setdefault(gait, {})
        new = list({s.servo: None for s in samples if s.servo is not None and s.servo not in known})
        if new:
            ideal = steady_gait(self._robot, self._ground, gait, rtol=_IDEAL_RTOL, powers=False)
            speeds = servo_speeds(((ideal, one) for one in new), rough=True)
            shares = np.nan_to_num(speeds) / max(ideal.speed_m_s, _LEAST_M_S)
            known.update(zip(new, shares.tolist(), strict=True))
        return np.array([1.0 if s.servo is None else known[s.servo] for s in samples])


def driven_speeds(robot: Robot, gait: Gait, samples: Sequence[Sample]) -> Array:
    """Return each sampled robot's speed with its own servo, m/s; 0 where none was found."""
    speeds = np.zeros(len(samples))
    pairs: dict[int, tuple[Steady, Servo]] = {}
    for k, sample in enumerate(samples):
        try:
            own = sample.gait(gait)
            ideal = steady_gait(robot, sample.ground, own, rtol=_IDEAL_RTOL, powers=False)
        except NotConverged:
            continue
        speeds[k] = ideal.speed_m_s
        if sample.servo is not None:
            pairs[k] = (ideal, sample.servo)
    if pairs:
        speeds[list(pairs)] = np.nan_to_num(servo_speeds(pairs.values()))
    return speeds


def low_speed(speeds: Array, count: int) -> float:
    """Return the 5th percentile of `count` speeds of which these are the slowest."""
    order = np.sort(speeds)
    at = QUANTILE * (count - 1)
    k = min(int(at), order.size - 2)
    return float(order[k] + (at - k) * (order[k + 1] - order[k]))


def smooth_low_speed(speeds: Array, count: int) -> float:
    """Return the same percentile as Harrell and Davis estimate it: a mean over its neighbours.

    Less scattered than one sample, and smooth as the gait changes.
    """
    from scipy.stats import beta

    order = np.sort(speeds)
    a, b = (count + 1) * QUANTILE, (count + 1) * (1 - QUANTILE)
    weight = np.diff(beta.cdf(np.arange(order.size + 1) / count, a, b))
    return float(weight @ order / weight.sum())


def low_speed_error(speeds: Array) -> float:
    """Return the standard error of the 5th percentile of samples, from those around it."""
    order, count = np.sort(speeds), speeds.size
    spread = math.sqrt(count * QUANTILE * (1 - QUANTILE))
    low, high = (int(np.clip(QUANTILE * count + s * spread, 0, count - 1)) for s in (-1, 1))
    return float(order[high] - order[low]) / 2


class RobustSearch:
    """Cost of a shape at the lowest rate at which its slow cases are fast enough."""

    def __init__(
        self, found: Finder, samples: list[Sample], wanted: float, shares: ServoShares | None = None
    ) -> None:
        self.search, self.robot, self.wanted = found.search, found.robot, wanted
        self.goal, self.shares = KEEP * wanted, shares
        self.cloud = found.cloud
        self.drawn = self.samples = samples
        self.slope = 1.3  # of ln low speed against ln rate, where it was looked at last
        self.evaluations = 0

    def keep_slowest(self, drawn: list[Sample], gait: Gait) -> None:
        """Go on with the samples that are slowest under a gait."""
        self.drawn = drawn
        kept = max(self.drawn_count // _KEPT, 12)
        speeds = sampled_speeds(self.robot, gait, self.drawn, self.shares)
        self.evaluations += self.drawn_count
        self.samples = [self.drawn[i] for i in np.argsort(speeds)[:kept]]

    @property
    def drawn_count(self) -> int:
        """Return the number of samples, of which those followed are the slowest."""
        return len(self.drawn)

    def off(self, gait: Gait, smooth: bool = True) -> float:
        """Return ln of the low speed over what it must be."""
        self.evaluations += len(self.samples)
        speeds = sampled_speeds(self.robot, gait, self.samples, self.shares)
        low = (smooth_low_speed if smooth else low_speed)(speeds, self.drawn_count)
        return math.log(max(low, 1e-6 * self.goal) / self.goal)

    def rate(self, gait: Gait, near: float = _NEAR, smooth: bool = True) -> float | None:
        """Return the rate that makes a shape fast enough, by secants from a gait's own."""
        first = last = gait.omega_rad_s
        x, before = math.log(first), None
        most = _STEP if self.shares is None else _SERVO_STEP
        for _ in range(8):
            y = self.off(replace(gait, omega_rad_s=math.exp(x)), smooth)
            if self.shares is not None and before is not None and y < before[1] and x > before[0]:
                return None  # faster than the slow servos turn
            if before is not None and abs(x - before[0]) > 1e-3:
                self.slope = min(max((y - before[1]) / (x - before[0]), 0.5), 6.0)
            before = (x, y)
            x += min(max(-y / self.slope, -most), most)
            last = math.exp(x)
            if abs(y) < near:
                return last
            if last > _MOST_OVER * first:
                return None
        return None

    def at(self, at: Array, guess: float, most_w: float = math.inf) -> Point:
        """Return ln of the cost of a shape; one that costs more than most_w is left."""
        shape, nowhere = GaitShape(*at), Point(at, math.inf, -1.0)
        if not 0 < shape.alpha_rad <= math.pi:
            return nowhere
        rate = self.rate(Gait(shape.alpha_rad, shape.beta_rad, guess))
        if rate is None:
            return nowhere
        state = self.search.solve(Gait(shape.alpha_rad, shape.beta_rad, rate), 1e-3)
        if state.speed_m_s < self.wanted:  # as it is thought to be it must make the speed, too
            state = self.search.at_speed(shape, self.wanted, rate, 1e-3)
        if state is None:
            return nowhere
        watts = self.search.watts(state)
        if watts > most_w:
            return nowhere
        margin = min(self.search.margins(state.gait).values(), default=math.inf)
        return Point(at, math.log(max(watts, 1e-300)), margin, state)

    def coarse(self) -> Point | None:
        """Return the best of the cloud's shapes by a rough percentile.

        Shapes that cost more than the best even as they are thought to be are left out.
        """
        drawn, best = self.drawn, None
        ranked = _RANKED if self.shares is None else 2 * SERVOS  # the slowest servos decide
        self.drawn = self.samples = drawn[:: max(1, len(drawn) // ranked)]
        for start in self.cloud.shapes_within(self.wanted, within=2.0):
            most = math.inf if best is None else math.exp(best.value)
            if start.watts > 1.1 * most:
                break
            point = self.from_candidate(start, most)
            if math.isfinite(point.value) and (best is None or point.better < best.better):
                best = point
        self.drawn = self.samples = drawn
        return best

    def from_candidate(self, start: Candidate, most_w: float) -> Point:
        """Return the point of a shape of the cloud, from the rate that it needs nominally."""
        base = self.search.point(np.array(start.shape), self.wanted, start.omega_rad_s, 1e-3)
        state: Any = base.data
        if state is None or base.value > math.log(most_w):
            return Point(base.at, math.inf, -1.0)
        return self.at(base.at, state.gait.omega_rad_s, most_w)

    def polish(self, start: Point, drawn: list[Sample], radius: float, smallest: float) -> Point:
        """Return the best shape near a start by the samples that are slowest there."""
        state: Any = start.data
        rate = state.gait.omega_rad_s
        self.keep_slowest(drawn, state.gait)
        low, high = self.search.bounds()
        first = self.at(start.at, rate)
        if not math.isfinite(first.value):
            return start
        return minimize(
            lambda shapes: [self.at(s, rate) for s in shapes], first, radius, smallest, low, high
        )[0]
