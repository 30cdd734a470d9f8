"""The cheapest gait that still crawls when friction and servos are not what was thought.

It is the search for least power again: in place of the speed stands what all but the slowest of
sampled robots keep. Their speeds are solved, never linearised: near a cliff their spread is skewed.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import Any

from ..model.checks import check_number
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..model.rows import Result, Row, detail, two_digits
from ..periodic.steady import Steady, steady_gait
from .finder import ANY, FIRST, ROUGH, ROUNDS, Finder, LeastPower, cheapest
from .least_power import cheaper, directions
from .limits import GaitLimits
from .sampled_speeds import KEEP, Samples, low_speed, low_speed_error
from .shapes import FINE, STATES, Array, Point, better
from .uncertainty import Sample, Uncertainty

_RANKED = 0.1, 30  # e-folds of shape between those that are ranked, and how many they are
_CHANCE = 3.7  # standard errors of one set: sets differ by more once in a hundred
_DRIVEN = 320  # samples at most with servos, which cost ten times as much


@dataclass(frozen=True, slots=True)
class RobustGait(Result):
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
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> robust = sn.robust_gait(robot, ground, speed_m_s=0.1, samples=64)
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

    def in_words(self) -> str:
        """Return the gait, its power, and the speed that most robots reach."""
        low = two_digits(self.low_speed_m_s)
        return f"{cheapest(self.gait, self.power_w)} 95 % of the robots make {low} m/s or more."

    def rows(self) -> list[Row]:
        """Return what robustness gives, and what it costs."""
        more, per_metre = 100 * self.premium, 100 * self.premium_per_metre
        reached = ", ".join(self.active) or "none"
        return [
            Row("wanted speed", "m/s", self.wanted_m_s),
            Row("95 % of the sampled robots are faster than", "m/s", self.low_speed_m_s),
            Row("the same, of other samples", "m/s", self.checked_low_m_s),
            *self.steady.rows(),
            Row(self.cost, "W", self.power_w, detail=self.cost == "power"),
            Row("more power than the least-power gait", "%", more),
            detail("more energy for each metre", "%", per_metre),
            detail("95 % of the robots with that gait make", "m/s", self.fragile_low_m_s),
            Row("limits reached", "", words=reached),
            Row("taken as uncertain", "", words=self.uncertainty.in_words()),
        ]

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
        """Tell whether both sets of samples agree, but for what chance makes once in a hundred."""
        apart = abs(self.checked_low_m_s - self.low_speed_m_s)
        return apart <= _CHANCE * self.low_error_m_s + STATES * self.low_speed_m_s


def robust_gait(
    robot: Robot,
    ground: Ground,
    *,
    speed_m_s: float,
    uncertainty: Uncertainty | None = None,
    cost: str = "power",
    limits: GaitLimits = ANY,
    samples: int = 1024,
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
        Number of sampled robots, 20 to 65536; with servos at most 320 of them are used.
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
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> robust = sn.robust_gait(robot, ground, speed_m_s=0.1, samples=64)
    >>> robust.low_speed_m_s > robust.fragile_low_m_s
    True
    """
    check_number("samples", samples, 20, 65536)
    uncertainty, wanted = uncertainty or Uncertainty(), float(speed_m_s)
    driven = uncertainty.servo is not None
    count = min(samples, _DRIVEN) if driven else samples
    # so many choose the shape, and an eighth of them rank the shapes of the table
    for_shape = _DRIVEN // 4 if driven else _DRIVEN // 2
    finders = [Finder(robot, on, [wanted], cost, limits) for on in directions(ground)]
    fragile = cheaper(finders, [finder.front([wanted])[0] for finder in finders])
    if isinstance(fragile, NotConverged):
        raise fragile

    def draw(part: int) -> list[Sample]:
        return uncertainty.samples(robot, ground, count, seed + part, skip=part * count)

    rate_by, fresh, choose_by = draw(0), draw(1), draw(2)[:for_shape]
    ends = [
        _cheapest(finder, wanted, choose_by, rate_by, turned)
        for finder, turned in zip(finders, (False, True), strict=False)
    ]
    best = min((end for end in ends if end is not None), key=better, default=None)
    if best is None or best.gait is None:
        raise NotConverged(
            f"no gait keeps 95 % of the sampled robots above {KEEP * wanted:.3g} m/s within the "
            f"limits ({limits.in_words()}); ask for less speed, or know friction and servos better"
        )
    speeds, checked = (Samples(robot, drawn).speeds(best.gait) for drawn in (rate_by, fresh))
    steady = steady_gait(robot, ground, best.gait, rtol=FINE)
    return RobustGait(
        best.gait,
        finders[0].watts(steady),
        steady.speed_m_s,
        wanted,
        cost,
        steady,
        uncertainty,
        low_speed(speeds),
        low_speed(checked),
        speeds,
        fragile,
        Samples(robot, rate_by[:_DRIVEN]).low(fragile.gait, smooth=False),
        limits.active(best.gait, finders[0].torque_nm(best.gait)),
        sum(finder.solved["states"] for finder in finders),
    )


def _cheapest(
    nominal: Finder, wanted: float, few: list[Sample], many: list[Sample], turned: bool
) -> Point | None:
    """Return the best shape by a few samples, at the rate that many ask for, or None.

    Where that rate is beyond a limit, the search goes on with what the many showed. turned: the
    finder's robot has its tail called head.
    """
    if turned:
        few, many = ([sample.turned_round() for sample in part] for part in (few, many))
    choosing, setting = Samples(nominal.robot, few), Samples(nominal.robot, many)
    followed, optimism = [Samples(nominal.robot, few[: len(few) // 8])], 1.0

    def chosen_by(gait: Gait, state: Any) -> float:
        return min(state.speed_m_s, followed[-1].low(gait) / optimism / KEEP)

    def set_by(gait: Gait, state: Any) -> float:
        return min(state.speed_m_s, slowest.low(gait, smooth=False) / KEEP)

    search, settle = copy(nominal), copy(nominal)
    search.speed, settle.speed = chosen_by, set_by
    search.miss = 5 * STATES  # a line between rates puts it right
    starts = nominal.table.starts(wanted, *_RANKED)
    best = min((search.point(p.shape, wanted, p) for p in starts), key=better)
    for _ in range(ROUNDS):
        for size in (FIRST, FIRST / 2):
            if best.gait is None:
                return None
            followed.append(choosing.slowest(best.gait))
            best = search.descend(wanted, best, size, ROUGH)
        if best.gait is None:
            return None
        slowest = setting.slowest(best.gait)
        followed.append(slowest)
        best = settle.point(best.shape, wanted, best, STATES)
        if best.gait is not None and best.margin < 0:
            optimism *= choosing.low(best.gait) / slowest.low(best.gait)
            continue
        sampled = sum(samples.solved for samples in (choosing, setting, *followed))
        nominal.solved["states"] += sampled
        if best.gait is not None and turned:
            gait = replace(best.gait, beta_rad=-best.gait.beta_rad)
            return replace(best, gait=gait)
        return best
    return None
