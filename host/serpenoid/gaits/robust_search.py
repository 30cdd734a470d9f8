"""The search for a robust gait: sampled speeds, their low percentile, the rate that lifts it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..model.gait import Gait
from ..periodic.near_states import LocalFit
from .quadratic_search import Array, Point, minimize
from .sampled_speeds import FollowedSamples, Places, SampledSpeeds, low_speed, percentile_rank
from .shape_search import GaitShape
from .uncertainty import SERVOS

if TYPE_CHECKING:
    from .finder import Finder
    from .shape_search import Candidate

KEEP = 0.9
_RANKED = 32  # samples by which the shapes of the cloud are ranked
_KEPT = 6  # one in so many samples is followed: the slowest where the search starts
_DRIFT = 0.005  # e-folds: a best that loses more to samples not followed is searched anew
_ROUNDS = 3
_GUESS = 3e-3  # accuracy of the nominal speed from which the rate is guessed
_STEP, _SERVO_STEP = 0.4, 0.15  # of ln rate; servos have a fastest rate, soon overstepped
_MOST_OVER = 2.5  # a shape that needs so many times its nominal rate is given up
_BESIDE = 0.1  # e-folds of shape: the rates of shapes so near tell that of one
_NEAR = 0.03  # of the low speed: closer than this the rate is corrected by the slope known


class RobustSearch:
    """Cost of a shape at the lowest rate at which its slow cases are fast enough."""

    def __init__(self, found: Finder, robots: SampledSpeeds, wanted: float) -> None:
        self.search, self.robots, self.wanted = found.search, robots, wanted
        self.goal = KEEP * wanted
        self.cloud = found.cloud
        self.slope = 1.3  # of ln low speed against ln rate, where it was looked at last
        self.nominal = 0.0  # speed, m/s, of the last gait that was just fast enough
        self.rates = LocalFit(2, 1)  # ln rates that shapes needed
        self.follow_all(np.arange(0))

    def follow_all(self, drawn: Places) -> None:
        """Go on with all of these samples."""
        self._follow(drawn, drawn.size)

    def _follow(self, which: Places, count: int) -> None:
        self.followed, self.drawn_count = which, count
        self.low = FollowedSamples(self.robots, which, count)

    def follow_slowest(self, drawn: Places, gait: Gait, count: int = 0) -> Places:
        """Go on with those samples that are slowest under a gait; return twice as many of them.

        count: of all samples, of which the drawn are those that may be slow.
        """
        count = count or drawn.size
        order = drawn[np.argsort(self.robots.ranked(gait, drawn))]
        kept = max(count // _KEPT, 12)
        self._follow(order[:kept], count)
        return order[: 2 * kept]

    def off(self, gait: Gait, exact: bool = False) -> float:
        """Return ln of the low speed over what it must be; exact: of the percentile itself."""
        if exact:
            rank = percentile_rank(self.drawn_count)
            speeds = self.robots.near_percentile(gait, self.followed, rank)
            low = low_speed(speeds, self.drawn_count)
        else:
            low = self.low.low(gait)
        return math.log(max(low, 1e-6 * self.goal) / self.goal)

    def rate(self, gait: Gait, near: float = _NEAR, exact: bool = False) -> float | None:
        """Return the rate that makes a shape fast enough, by secants from a gait's own."""
        first = last = gait.omega_rad_s
        x, before = math.log(first), None
        servos = self.robots.shares is not None
        most = _SERVO_STEP if servos else _STEP
        for _ in range(8):
            y = self.off(replace(gait, omega_rad_s=math.exp(x)), exact)
            if servos and before is not None and y < before[1] and x > before[0]:
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
        rate = self.rate(Gait(shape.alpha_rad, shape.beta_rad, self.guess(at, guess)))
        if rate is None:
            return nowhere
        self.rates.add(at[None], np.array([[math.log(rate)]]))
        state = self.search.solve(Gait(shape.alpha_rad, shape.beta_rad, rate), 1e-3)
        self.nominal = state.speed_m_s
        if state.speed_m_s < self.wanted:  # as it is thought to be it must make the speed, too
            state = self.search.at_speed(shape, self.wanted, rate, 1e-3)
        if state is None:
            return nowhere
        watts = self.search.watts(state)
        if watts > most_w:
            return nowhere
        margin = min(self.search.margins(state.gait).values(), default=math.inf)
        return Point(at, math.log(max(watts, 1e-300)), margin, state)

    def guess(self, at: Array, omega_rad_s: float) -> float:
        """Return the rate that shapes beside this one lead to expect.

        Where none is known: that at which it is nominally as fast as the last one had to be.
        """
        if self.rates.nearest(at) < _BESIDE:
            return math.exp(float(self.rates.expect(at[None])[0, 0]))
        if not self.nominal:
            return omega_rad_s
        state = self.search.at_speed(GaitShape(*at), self.nominal, omega_rad_s, _GUESS)
        return omega_rad_s if state is None else state.gait.omega_rad_s

    def coarse(self, drawn: Places) -> Point | None:
        """Return the best of the cloud's shapes by a rough percentile.

        Shapes that cost more than the best even as they are thought to be are left out.
        """
        best: Point | None = None
        # the slowest servos decide
        ranked = _RANKED if self.robots.shares is None else 2 * SERVOS
        self.follow_all(drawn[:: max(1, len(drawn) // ranked)])
        for start in self.cloud.shapes_within(self.wanted, within=2.0):
            most = math.inf if best is None else math.exp(best.value)
            if start.watts > 1.1 * most:
                break
            point = self.from_candidate(start, most)
            if math.isfinite(point.value) and (best is None or point.better < best.better):
                best = point
        return best

    def from_candidate(self, start: Candidate, most_w: float) -> Point:
        """Return the point of a shape of the cloud, from the rate that it needs nominally."""
        self.nominal = 0.0
        base = self.search.point(np.array(start.shape), self.wanted, start.omega_rad_s, 1e-3)
        state: Any = base.data
        if state is None or base.value > math.log(most_w):
            return Point(base.at, math.inf, -1.0)
        return self.at(base.at, state.gait.omega_rad_s, most_w)

    def polish(self, start: Point, drawn: Places, radius: float, smallest: float) -> Point:
        """Return the best shape near a start by the samples that are slowest there.

        At the best other samples may be slow: then the search goes on with those.
        """
        best, slow = self.anew(start, drawn, drawn.size)
        for _ in range(_ROUNDS):
            if not math.isfinite(best.value):
                return start
            state: Any = best.data
            rate, (low, high) = state.gait.omega_rad_s, self.search.bounds()
            found, *_ = minimize(
                lambda shapes, rate=rate: [self.at(s, rate) for s in shapes],
                best,
                radius,
                smallest,
                low,
                high,
            )
            among = slow if radius < _BESIDE else drawn
            start, (best, slow) = best, self.anew(found, among, drawn.size)
            if best.value < found.value + _DRIFT:
                break
        return min(start, best, key=lambda point: point.better)

    def anew(self, point: Point, drawn: Places, count: int) -> tuple[Point, Places]:
        """Return a point by the samples that are slowest there, and go on with those.

        The second value is as of `follow_slowest`.
        """
        state: Any = point.data
        slow = self.follow_slowest(drawn, state.gait, count)
        return self.at(point.at, state.gait.omega_rad_s), slow
