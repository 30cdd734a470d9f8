"""The cheapest gait that still crawls when friction and servos are not what was thought.

Speeds of sampled robots are solved, never linearised: near a cliff their spread is skewed. The slow
samples and a smoothed percentile choose the shape; the percentile itself sets the rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.checks import check_number
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady
from .finder import ANY, Finder, LeastPower, finder
from .least_power import EitherWave
from .limits import GaitLimits
from .quadratic_search import Point
from .robust_search import KEEP, RobustSearch
from .sampled_speeds import (
    Places,
    SampledSpeeds,
    ServoShares,
    driven_speeds,
    low_speed,
    low_speed_error,
    percentile_rank,
)
from .shape_search import GaitShape, exact_solver
from .uncertainty import Sample, Uncertainty

SAMPLES = 2048
_FOR_SHAPE = (8, 2)  # one in so many samples chooses the shape, roughly and finely
_OF_FRAGILE, _DRIVEN = 512, 512
_NOMINAL = 1e-5  # accuracy of the wanted speed, where it is that which binds


@dataclass(frozen=True, slots=True)
class RobustGait:
    """Hold the cheapest gait whose slow cases are fast enough.

    Attributes
    ----------
    gait, power_w, speed_m_s
        The gait, its cost, W, and its speed, m/s, on the most likely ground.
    wanted_m_s, cost, uncertainty
        What was asked for: the speed, m/s, the kind of power, and what may vary.
    steady
        The exact model's periodic state.
    low_speed_m_s
        5th percentile of the speed over the samples that chose the gait, m/s.
    checked_low_m_s
        The same over other samples, which had no part in the choice, m/s.
    speeds_m_s : (S,)
        Speeds of the samples that chose the gait, m/s: near the percentile to 3e-3 or better, the
        others rough, without a bound, and partly from a rate up to 3 % away.
    fragile, fragile_low_m_s
        The least-power gait for the same speed, and its 5th percentile, m/s.
    active
        The limits that the gait has reached, in words.
    evaluations
        Periodic states solved in the search.
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
        """Return how much more power this gait takes than the fragile one, relative."""
        return self.power_w / self.fragile.power_w - 1

    @property
    def premium_per_metre(self) -> float:
        """Return how much more energy it takes per metre than the fragile one, relative."""
        return (1 + self.premium) * self.fragile.speed_m_s / self.speed_m_s - 1

    @property
    def low_error_m_s(self) -> float:
        """Return the standard error of the low speed that so many samples leave."""
        return low_speed_error(self.speeds_m_s)


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
    """Find the least power at which 95 % of the sampled robots keep 90 % of the speed.

    On the nominal ground the gait makes at least the wanted speed, to 1e-5 of it. Speeds are solved
    for sampled robots; as many other samples check the gait. On a ratchet, waves from tail to head
    (beta below 0) are searched too.

    Parameters
    ----------
    robot, ground, cost, limits
        As in `least_power_gait`.
    speed_m_s
        The wanted speed, m/s.
    uncertainty
        How well friction and servos are known; the defaults of `Uncertainty` unless given.
    samples
        Number of sampled robots, 20 to 65536.
    seed
        Of the samples.

    Returns
    -------
    RobustGait
        The gait, its power, the low speeds and the price of robustness.

    Raises
    ------
    BadInput
        For arguments out of range.
    NotConverged
        If no gait keeps the speed.
    """
    check_number("samples", samples, 20, 65536)
    uncertainty = uncertainty or Uncertainty()
    wanted = float(speed_m_s)
    waves = EitherWave(ground, lambda on: finder(robot, on, [speed_m_s], cost, limits))
    fragile = waves.minimize(wanted)
    drawn = uncertainty.samples(robot, ground, samples, seed)
    tables = _shares(robot, ground, uncertainty)
    best = _either_direction(waves, drawn, wanted, tables)
    if best is None:
        raise NotConverged(
            f"no gait keeps 95 % of the sampled robots above {KEEP * wanted:.3g} m/s within the "
            f"limits ({limits.in_words()}); ask for less speed, or know friction and servos better"
        )
    return _finished(best, ground, fragile, drawn, uncertainty, seed, tables[0])


Tables = tuple[ServoShares, ServoShares] | tuple[None, None]


def _shares(robot: Robot, ground: Ground, uncertainty: Uncertainty) -> Tables:
    """Return tables of what servos leave, for waves from the head and from the tail."""
    if uncertainty.servo is None:
        return None, None
    return ServoShares(robot, ground), ServoShares(robot, ground.turned_round())


@dataclass(frozen=True)
class _Found:
    """A gait found with waves from head to tail, its cost, W, and the search that found it.

    turned: the search knew the robot's tail as its head.
    """

    gait: Gait
    watts: float
    work: RobustSearch
    turned: bool = False

    @property
    def as_sent(self) -> Gait:
        """Return the gait for the robot that has its head in front."""
        gait = self.gait
        return replace(gait, beta_rad=-gait.beta_rad) if self.turned else gait


def _either_direction(
    waves: EitherWave, drawn: list[Sample], wanted: float, tables: Tables
) -> _Found | None:
    """Return the cheapest robust gait of both directions of waves."""
    best: _Found | None = None
    for least_w, k in sorted(zip(waves.watts, range(2), strict=False)):
        if least_w >= (best.watts if best else math.inf):  # robust it would cost more still
            continue
        seen = [one.turned_round() for one in drawn] if k else drawn
        found = _one_direction(waves.searches[k], seen, wanted, tables[k])
        if found is not None and (best is None or found.watts < best.watts):
            best = replace(found, turned=k > 0)
    return best


def _one_direction(
    search: Finder, drawn: list[Sample], wanted: float, shares: ServoShares | None
) -> _Found | None:
    """Return the cheapest robust gait with waves from head to tail."""
    everyone = np.arange(len(drawn))
    few, many = (everyone[: max(20, len(drawn) // part)] for part in _FOR_SHAPE)
    work = RobustSearch(search, SampledSpeeds(search.robot, drawn, shares), wanted)
    start = work.coarse(few)
    if start is None:
        return None
    rough = work.polish(start, few, 0.1, 0.04)
    best = _settled(work, work.polish(rough, many, 0.04, 0.03), everyone)
    if best is None:
        return None
    state: Any = best.data
    return _Found(state.gait, search.search.watts(state), work)


def _settled(work: RobustSearch, best: Point, drawn: Places) -> Point | None:
    """Return the best shape at the rate that all samples ask for."""
    state: Any = best.data
    work.follow_slowest(drawn, state.gait)
    rate = work.rate(state.gait, near=1e-3, exact=True)
    if rate is None:
        return None
    gait = replace(state.gait, omega_rad_s=rate)
    at_rate = work.search.solve(gait, 1e-3)
    if at_rate.speed_m_s < work.wanted * (1 - _NOMINAL):
        found = work.search.at_speed(GaitShape(*best.at), work.wanted, rate, _NOMINAL)
        at_rate = found or state
    return replace(best, data=at_rate)


def _finished(
    best: _Found,
    ground: Ground,
    fragile: LeastPower,
    drawn: list[Sample],
    uncertainty: Uncertainty,
    seed: int,
    shares: ServoShares | None,
) -> RobustGait:
    """Solve the gait once more, and look at all samples and at fresh ones."""
    gait, work, search = best.as_sent, best.work, best.work.search
    robot = search.robot
    exact = exact_solver(robot, ground, powers=True)(gait, 1e-4)
    fresh = uncertainty.samples(robot, ground, len(drawn), seed + 1, skip=len(drawn))
    chosen = work.robots
    like = None if best.turned else chosen
    speeds = _all_speeds(chosen, best.gait, len(drawn))
    if shares is None:
        checked = _all_speeds(SampledSpeeds(robot, fresh, like=like), gait, len(fresh))
    else:
        checked = driven_speeds(robot, gait, fresh[:_DRIVEN])
    few = drawn[:_OF_FRAGILE]
    slow = _all_speeds(SampledSpeeds(robot, few, shares, like), fragile.gait, len(few))
    return RobustGait(
        gait,
        search.watts(exact),
        exact.speed_m_s,
        work.wanted,
        search.cost,
        exact,
        uncertainty,
        low_speed(speeds, speeds.size),
        low_speed(checked, checked.size),
        speeds,
        fragile,
        low_speed(slow, slow.size),
        search.limits.active(gait, search.torque_nm(best.gait)),
        chosen.solved + slow.size + checked.size + search.evaluations,
    )


def _all_speeds(robots: SampledSpeeds, gait: Gait, count: int) -> NDArray[np.float64]:
    return robots.near_percentile(gait, np.arange(count), percentile_rank(count))
