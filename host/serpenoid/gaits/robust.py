"""The cheapest gait that still crawls when friction and servos are not what was thought.

It is the search for least power again: in place of the speed stands what all but the slowest of
sampled robots keep. Their speeds are solved, never linearised: near a cliff their spread is skewed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from ..model.checks import check_number
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, steady_gait
from .finder import ANY, Finder, LeastPower, finder
from .least_power import cheaper, directions
from .limits import GaitLimits
from .sampled_speeds import KEEP, Samples, low_speed, low_speed_error
from .shapes import Accuracy, Array, Point
from .uncertainty import Sample, Uncertainty

SAMPLES = 2048
_FOR_RANK, _FOR_SHAPE = 32, 512  # samples by which shapes are ranked, and the best is searched
_FOR_SHAPE_DRIVEN = 192  # the same with servos, which cost ten times as much
_DRIVEN = 512  # samples that are solved with their servos, which cost ten times as much
_ROUNDS = 3  # searches at most, each with what fresh samples showed of the one before
_DEARER = 1.1  # times the best: shapes that cost more nominally are not ranked
_WITHIN, _APART = 2.0, 0.1  # cost over the cheapest, and e-folds of shape, of shapes to rank
_SEARCHES = (0.1, 12), (0.04, 6)  # first simplex, e-folds of shape; one sample in so many, the
# slowest at the start, is followed: twice as many as make the percentile, then four times
_STATE_RTOL, _SETTLED = 1e-5, 1e-3  # accuracy of states, and of the last rate's speed
_STATES = 1e-3  # relative accuracy of sampled speeds
_ROUNDING = 1e-3  # e-folds beyond a limit: less than a hundredth of what robustness asks
_SURE = 2.0  # standard errors between two sets of samples: more is no chance


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
        5th percentile of the speed over the samples that set the rate, m/s.
    checked_low_m_s
        The same over other samples, which had no part in the choice, m/s.
    speeds_m_s : (S,)
        Speeds of the samples that set the rate, m/s, with their servos.
    fragile, fragile_low_m_s
        The least-power gait for the same speed, and its 5th percentile, m/s.
    active
        The limits that the gait has reached, in words.
    evaluations
        Periodic states solved in the search.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> robust = sn.robust_gait(robot, ground, speed_m_s=0.05, samples=256)
    >>> robust.low_speed_m_s > robust.fragile_low_m_s
    True
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
    speeds_m_s: Array
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

    @property
    def confirmed(self) -> bool:
        """Tell whether both sets of samples agree, to two standard errors of their difference."""
        apart = abs(self.checked_low_m_s - self.low_speed_m_s)
        return apart <= _SURE * math.sqrt(2) * self.low_error_m_s + _STATES * self.low_speed_m_s


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

    On the nominal ground the gait makes at least the wanted speed, to 1e-5 of it. Few samples
    choose the shape; then all of them, fresh ones, set the rate, and as many others check it. On a
    ratchet, waves from tail to head (beta below 0) are searched too.

    Parameters
    ----------
    robot, ground, cost, limits
        As in `least_power_gait`.
    speed_m_s
        The wanted speed, m/s.
    uncertainty
        How well friction and servos are known; the defaults of `Uncertainty` unless given.
    samples
        Number of sampled robots, 20 to 65536; with servos at most 512 of them are used.
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

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> robust = sn.robust_gait(robot, ground, speed_m_s=0.05, samples=256)
    >>> robust.low_speed_m_s > robust.fragile_low_m_s
    True
    """
    check_number("samples", samples, 20, 65536)
    uncertainty, wanted = uncertainty or Uncertainty(), float(speed_m_s)
    count = samples if uncertainty.servo is None else min(samples, _DRIVEN)
    few = min(count, _FOR_SHAPE if uncertainty.servo is None else _FOR_SHAPE_DRIVEN)
    finders = [finder(robot, on, [wanted], cost, limits) for on in directions(ground)]
    fronts = [one.front([wanted])[0] for one in finders]
    fragile = cheaper(finders, fronts)
    if isinstance(fragile, NotConverged):
        raise fragile

    def draw(part: int, size: int) -> list[Sample]:
        return uncertainty.samples(robot, ground, size, seed + part, skip=part * samples)

    best: tuple[Robustness, Point] | None = None
    for k, one in enumerate(finders):
        work = Robustness(one, wanted, [draw(2, few), draw(0, count)], k > 0)
        point = work.minimize()
        if point is not None and (best is None or point.value < best[1].value):
            best = work, point
    if best is None:
        raise NotConverged(
            f"no gait keeps 95 % of the sampled robots above {KEEP * wanted:.3g} m/s within the "
            f"limits ({limits.in_words()}); ask for less speed, or know friction and servos better"
        )
    work, point = best
    gait = work.as_sent(point)
    here = [Samples(robot, draw(part, count)) for part in (0, 1)]
    speeds, checked = (samples.speeds(gait) for samples in here)
    steady = steady_gait(robot, ground, gait, rtol=_STATE_RTOL)
    shapes = work.finder.shapes
    return RobustGait(
        gait,
        shapes.watts(steady),
        steady.speed_m_s,
        wanted,
        cost,
        steady,
        uncertainty,
        low_speed(speeds),
        low_speed(checked),
        speeds,
        fragile,
        low_speed(Samples(robot, here[0].samples[:_DRIVEN]).speeds(fragile.gait)),
        limits.active(gait, shapes.torque_nm(gait)),
        work.solved + shapes.evaluations + 2 * count + _DRIVEN,
    )


class Robustness:
    """The search for the shape that costs least where its slow cases are fast enough.

    finder: of least power, for waves from head to tail; turned: of the robot that has its tail
    called head. drawn: samples that choose the shape, and fresh ones that set the rate.
    """

    def __init__(
        self, finder: Finder, wanted: float, drawn: Sequence[list[Sample]], turned: bool
    ) -> None:
        self.finder, self.wanted, self.turned = finder, wanted, turned
        drawn = [[s.turned_round() for s in part] if turned else part for part in drawn]
        self.few, self.many = (Samples(finder.robot, part) for part in drawn)
        self.optimism = 1.0  # low speed of the few over that of the many

    @property
    def solved(self) -> int:
        """Return the number of states of samples."""
        return self.few.solved + self.many.solved

    def as_sent(self, point: Point) -> Gait:
        """Return a gait for the robot that has its head in front."""
        assert point.gait is not None
        gait = point.gait
        return replace(gait, beta_rad=-gait.beta_rad) if self.turned else gait

    def minimize(self) -> Point | None:
        """Return the best shape at the rate that the many ask for, or None.

        Where that rate is beyond a limit, the search goes on with what the many showed.
        """
        best, slow = self._ranked(), self.few
        for _ in range(_ROUNDS):
            for box, part in _SEARCHES:
                if best is None or best.gait is None:
                    return None
                slow = self.few.slowest(best.gait, part)
                best = self._search(slow).descend(self.wanted, best, box)
            settled = self._settled(best)
            if settled is None or settled.gait is None or settled.margin >= -_ROUNDING:
                return settled
            self.optimism *= slow.low(settled.gait) / low_speed(self.many.speeds(settled.gait))
            best = settled
        return None

    def _ranked(self) -> Point | None:
        """Return the best of the table's shapes, by few samples.

        Shapes that cost more than the best even as they are thought to be are left out.
        """
        shapes = self._search(Samples(self.few.robot, self.few.samples[:_FOR_RANK])).shapes
        best: Point | None = None
        looked: list[Array] = []
        for start in self.finder.table.starts(self.wanted, _WITHIN):
            if best is not None and start.watts > _DEARER * math.exp(best.value):
                break
            at = np.array(start.shape)
            if any(math.dist(at, other) < _APART for other in looked):
                continue
            looked.append(at)
            point = shapes.point(at, self.wanted, start.omega_rad_s, self.finder.rough)
            if point.gait is not None and (best is None or point.better < best.better):
                best = point
        return best

    def _search(self, samples: Samples) -> Finder:
        """Return the finder by what samples keep in place of the speed."""
        finder = copy(self.finder)
        nominal = self.finder.shapes.solve

        def solve(gait: Gait, rtol: float) -> Steady | None:
            state = nominal(gait, rtol)
            if state is None:
                return None
            kept = samples.low(gait) / self.optimism / KEEP
            return replace(state, speed_m_s=min(state.speed_m_s, kept))

        finder.shapes = self.finder.shapes.solved_by(solve)
        return finder

    def _settled(self, best: Point | None) -> Point | None:
        """Return a shape at the rate that the many samples and the nominal ground ask for."""
        if best is None or best.gait is None:
            return None
        nominal = self.finder.shapes

        def solve(gait: Gait, rtol: float) -> Steady | None:
            state = nominal.solve(gait, rtol)
            if state is None:
                return None
            kept = low_speed(self.many.speeds(gait, rough=True)) / KEEP
            return replace(state, speed_m_s=min(state.speed_m_s, kept))

        how = Accuracy(_STATE_RTOL, _SETTLED)
        rate = best.gait.omega_rad_s
        found = nominal.solved_by(solve).point(best.at, self.wanted, rate, how)
        if found.gait is None:
            return None
        least = nominal.point(best.at, self.wanted, rate, Accuracy(_STATE_RTOL, _STATE_RTOL))
        enough = least.gait is None or found.gait.omega_rad_s >= least.gait.omega_rad_s
        return found if enough else least
