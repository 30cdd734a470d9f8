"""The cheapest gait that still crawls when friction and servos are not what was thought."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.checks import check_number
from ..model.errors import NotConverged, SerpenoidError
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, steady_gait
from .gait_cloud import Candidate
from .least_power import ANY, LeastPower, finder
from .limits import GaitLimits
from .quadratic_search import Array, Point, least
from .shape_search import exact_solver, on_threads
from .uncertainty import Sample, Uncertainty

KEEP, QUANTILE = 0.9, 0.05
SAMPLES = 128
_KEPT = 24  # of the samples, those that the search follows: the slowest where it starts
_RTOL = 3e-3
_MOST_OVER = 2.5  # a shape that needs so many times its nominal rate is given up


@dataclass(frozen=True, slots=True)
class RobustGait:
    """Hold the cheapest gait whose slow cases are fast enough.

    gait, power_w, speed_m_s: at the ground as it is thought to be. low_speed_m_s: 5th percentile
    of the speed over the samples that chose the gait, speeds_m_s (S,); checked_low_m_s: over
    other samples that had no part in it. fragile: the least-power gait for the same speed;
    fragile_low_m_s: its 5th percentile. premium: power of this one over that, less 1.
    """

    gait: Gait
    power_w: float
    speed_m_s: float
    wanted_m_s: float
    cost: str
    steady: Steady
    uncertainty: Uncertainty
    low_speed_m_s: float
    checked_low_m_s: float
    speeds_m_s: NDArray[np.float64]
    fragile: LeastPower
    fragile_low_m_s: float
    active: tuple[str, ...]
    evaluations: int

    @property
    def premium(self) -> float:
        """Return what robustness costs, as a fraction of the fragile gait's power."""
        return self.power_w / self.fragile.power_w - 1


def sampled_speeds(robot: Robot, gait: Gait, samples: Sequence[Sample]) -> Array:
    """Return the speed of each sampled robot under one command, m/s; 0 where none was found."""

    def speed(sample: Sample) -> float:
        try:
            return steady_gait(
                robot, sample.ground, sample.gait(gait), rtol=_RTOL, powers=False
            ).speed_m_s
        except NotConverged as error:
            return error.best.speed_m_s if error.best is not None else 0.0
        except SerpenoidError:
            return 0.0

    return np.array(on_threads(speed, samples))


def low_speed(speeds: Array, count: int) -> float:
    """Return the 5th percentile of `count` speeds of which these are the slowest."""
    order = np.sort(speeds)
    at = QUANTILE * (count - 1)
    k = min(int(at), order.size - 2)
    return float(order[k] + (at - k) * (order[k + 1] - order[k]))


class _Robust:
    """Cost of a shape at the lowest rate at which its slow cases are fast enough."""

    def __init__(self, found: Any, robot: Robot, samples: list[Sample], wanted: float) -> None:
        self.search, self.robot, self.wanted = found.search, robot, wanted
        self.samples, self.count = samples, len(samples)
        self.evaluations = 0

    def keep_slowest(self, gait: Gait) -> None:
        """Go on with the samples that are slowest under a gait."""
        order = np.argsort(sampled_speeds(self.robot, gait, self.samples))
        self.samples = [self.samples[i] for i in order[:_KEPT]]

    def low(self, gait: Gait) -> float:
        self.evaluations += len(self.samples)
        return low_speed(sampled_speeds(self.robot, gait, self.samples), self.count)

    def at(self, at: Array, guess: float, most_w: float = math.inf) -> Point:
        """Return ln of the cost; a shape that costs more than most_w even nominally is left."""
        search, goal = self.search, KEEP * self.wanted
        base = search.point(at, self.wanted, guess, 1e-3)
        if base.better[0] and not math.isfinite(base.value):
            return base
        if base.value > math.log(most_w):
            return Point(at, math.inf, -1.0)
        nominal: Any = base.data
        rate, last = nominal.gait.omega_rad_s, None
        for _ in range(8):
            gait = Gait(nominal.gait.alpha_rad, nominal.gait.beta_rad, rate)
            y = math.log(max(self.low(gait), 1e-6 * goal) / goal)
            if y >= -2e-3 and (last is None or y < 6e-3):
                return self.priced(at, gait, base if last is None else None)
            slope = 1.0 if last is None else (y - last[1]) / math.log(rate / last[0])
            step = min(max(-y / min(max(slope, 0.5), 6.0), -0.3), 0.4)
            last = (rate, y)
            rate = max(rate * math.exp(step), nominal.gait.omega_rad_s)
            if rate > _MOST_OVER * nominal.gait.omega_rad_s:
                break
            if rate == last[0]:
                return base
        return Point(at, math.inf, -1.0)

    def priced(self, at: Array, gait: Gait, base: Point | None) -> Point:
        """Return the point of a gait that is fast enough."""
        if base is not None:
            return base
        state = self.search.solve(gait, 1e-3)
        room = self.search.limits.room(gait, self.search.torque_nm(gait)).values()
        watts = getattr(state, f"{self.search.cost}_w")
        return Point(at, math.log(watts), min(room, default=math.inf), state)


def _coarse(work: _Robust, starts: list[Candidate]) -> Point | None:
    """Return the best of the cloud's shapes; those that cost too much even nominally are left."""
    best = None
    for start in starts:
        most = math.inf if best is None else math.exp(best.value)
        if start.watts > 1.1 * most:
            break
        point = work.at(np.array(start.shape), start.omega_rad_s, most)
        if math.isfinite(point.value) and (best is None or point.better < best.better):
            best = point
    return best


def robust_gait(
    robot: Robot,
    ground: Ground,
    *,
    speed_m_s: float,
    uncertainty: Uncertainty | None = None,
    cost: str = "power",
    limits: GaitLimits = ANY,
    samples: int = SAMPLES,
    seed: int = 2005,
) -> RobustGait:
    """Find the least power such that 95 % of the robots that may be real keep 90 % of the speed.

    On the ground as it is thought to be the gait makes the wanted speed or more. Speeds are solved
    for sampled robots, never linearised: at a cliff their spread is skewed. The gait is then
    checked on as many other samples. Raises BadInput, and NotConverged when no gait will do.
    """
    check_number("samples", samples, 20, 4096)
    uncertainty = uncertainty or Uncertainty()
    found = finder(robot, ground, [speed_m_s], cost, limits)
    fragile = found.cheapest(float(speed_m_s))
    drawn = uncertainty.samples(robot, ground, samples, seed)
    work = _Robust(found, robot, drawn, float(speed_m_s))
    work.samples = drawn[:: max(1, samples // 16)]  # a rough percentile is enough to rank shapes
    work.count = len(work.samples)
    start = _coarse(work, found.cloud.cheapest_shapes(float(speed_m_s), within=2.0))
    if start is None:
        raise NotConverged(
            f"no gait keeps 95 % of the sampled robots above {KEEP * speed_m_s:.3g} m/s within the "
            f"limits ({limits.in_words()}); ask for less speed, or know friction better"
        )
    best = _polish(work, _polish(work, start, drawn, 0.1), drawn, 0.04)
    work.samples = drawn
    state: Any = best.data
    best = work.at(best.at, state.gait.omega_rad_s)  # its rate, by all samples
    return _finished(robot, ground, best, work, fragile, drawn, uncertainty, seed)


def _polish(work: _Robust, start: Point, drawn: list[Sample], radius: float) -> Point:
    """Return the best shape near a start by the samples that are slowest there."""
    state: Any = start.data
    rate = state.gait.omega_rad_s
    work.samples, work.count = drawn, len(drawn)
    work.keep_slowest(state.gait)
    low, high = work.search.bounds()
    first = work.at(start.at, rate)
    if not math.isfinite(first.value):
        return start
    return least(lambda shapes: [work.at(s, rate) for s in shapes], first, radius, 0.03, low, high)[
        0
    ]


def _finished(
    robot: Robot, ground: Ground, best: Point, work: _Robust, fragile: LeastPower,
    drawn: list[Sample], uncertainty: Uncertainty, seed: int,
) -> RobustGait:  # fmt: skip
    """Solve the gait once more, and look at all samples and at fresh ones."""
    rough: Any = best.data
    gait, search = rough.gait, work.search
    exact = exact_solver(robot, ground, powers=True)(gait, 1e-4)
    speeds = sampled_speeds(robot, gait, drawn)
    fresh = uncertainty.samples(robot, ground, len(drawn), seed + 1)
    return RobustGait(
        gait, getattr(exact, f"{search.cost}_w"), exact.speed_m_s, work.wanted, search.cost, exact,
        uncertainty, low_speed(speeds, len(drawn)),
        low_speed(sampled_speeds(robot, gait, fresh), len(fresh)), speeds, fragile,
        low_speed(sampled_speeds(robot, fragile.gait, drawn), len(drawn)),
        search.limits.active(gait, search.torque_nm(gait)),
        work.evaluations + search.evaluations + 3 * len(drawn),
    )  # fmt: skip
