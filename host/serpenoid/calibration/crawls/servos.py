"""What servos do to a session's crawls, and servos drawn anew where few explain what was seen.

Of some servos drawn from a kind often none moves weak joints as the films showed. Then more are
drawn where the crawls say: what is left of speeds and amplitudes is taken as linear in the servos'
unknowns, and that posterior is drawn from, by Student's distribution. Each servo counts by the
kind's density over the mean density of all draws.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...model.drives import Servo, ServoKind
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...periodic.servo_steady import moved_by
from ...periodic.steady import steady_gait
from ..speed_samples import scaled
from .speeds import Array

SERVO_DRAWS = 128
SERVO_SIGMA = 0.005  # relative, of what a servo is predicted to do
GRAIN = 0.01  # the same, where few servos are drawn of many; a rough state is off by 0.003
ENOUGH_SERVOS = 10.0  # alike ones: no more are drawn
ENDS = 1 / 1.04, 1.04  # of the common amplitude, where it is known within some per cent
_ROUNDS, _FRESH = 4, 64
_FREEDOM, _WIDE = 5.0, 1.2  # of Student's distribution
_PER_UNKNOWN = 3  # servos that count, for each slope's unknown


@dataclass(frozen=True)
class ServoEffects:
    """What each of S servos does to G gaits.

    share: of the ideal speed, (S, G); where a film showed the joints, of that with the amplitude
    seen. amplitude: made over commanded, (S, films). Both with the joints' common amplitude as
    commanded; they change with its powers share_power and amplitude_power: a weak servo does not
    follow further. sigma: what both may be off by, relative.
    log_weight: (S,), of the kind's density over that of the draws; None: they are alike.
    """

    servos: tuple[Servo, ...]
    share: Array
    amplitude: Array
    sigma: float = SERVO_SIGMA
    log_weight: Array | None = None
    share_power: Array | float = 0.0
    amplitude_power: Array | float = 0.0

    @classmethod
    def none(cls, gaits: int, films: int) -> ServoEffects:
        """Return those of joints that follow the gait."""
        return cls((), np.ones((1, gaits)), np.ones((1, films)), 0.0)

    def shares(self, amplitude: Array) -> Array:
        """Return the shares with common amplitudes (K,): (K, S, G)."""
        return self.share * amplitude[:, None, None] ** self.share_power

    def gains(self, amplitude: Array) -> Array:
        """Return filmed over commanded amplitudes, with common ones (K,): (K, S, films)."""
        return self.amplitude * amplitude[:, None, None] ** (1.0 + self.amplitude_power)

    def some(self, servos: Any, gaits: Any, films: Any) -> ServoEffects:
        """Return what some of the servos do to some of the gaits and films, by their indices."""
        each = np.ix_(servos, gaits), np.ix_(servos, films)
        return ServoEffects(
            tuple(self.servos[k] for k in servos),
            self.share[each[0]],
            self.amplitude[each[1]],
            self.sigma,
            None,
            np.asarray(self.share_power)[each[0]],
            np.asarray(self.amplitude_power)[each[1]],
        )


Effects = Callable[[tuple[Servo, ...]], ServoEffects]


def effects_of(
    robot: Robot,
    ground: Ground,
    gaits: Sequence[Gait],
    seen: Sequence[bool],
    servos: tuple[Servo, ...],
    ends: tuple[float, float] = ENDS,
) -> ServoEffects:
    """Return what some servos do to commanded gaits; seen: those whose joints a film showed.

    ends: common amplitudes at which that is solved for.
    """
    own = list(dict.fromkeys(zip(gaits, seen, strict=True)))  # films of a gait have it alike
    many = len(servos) > 1
    jobs = [
        (steady_gait(robot, ground, scaled(g, end), rtol=1e-3, powers=False), film)
        for end in ends
        for g, film in own
    ]
    each = [(state, one, film, many) for state, film in jobs for one in servos]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = np.array(list(pool.map(lambda job: moved_by(*job), each)))
    rows = [own.index(pair) for pair in zip(gaits, seen, strict=True)]
    found = found.reshape(2, len(own), len(servos), 2)[:, rows].swapaxes(1, 2)
    logs = np.log(np.maximum(found, 1e-3))
    power = (logs[1] - logs[0]) / np.log(ends[1] / ends[0])
    middle = np.exp(logs[1] - power * np.log(ends[1]))
    films = np.asarray(seen, dtype=bool)
    return ServoEffects(
        servos,
        middle[..., 0],
        middle[:, films, 1],
        GRAIN if many else SERVO_SIGMA,
        None,
        power[..., 0],
        power[:, films, 1],
    )


def together(one: ServoEffects, other: ServoEffects) -> ServoEffects:
    """Return two sets of servos as one."""
    names = ("share", "amplitude", "share_power", "amplitude_power")
    both = {n: np.vstack([getattr(one, n), getattr(other, n)]) for n in names}
    return replace(one, servos=one.servos + other.servos, **both)


def alike(log: Array) -> float:
    """Return how many servos that are alike are worth as much as weights of such logarithms."""
    weight = np.exp(log - log.max())
    return float(weight.sum() ** 2 / np.sum(weight**2))


def with_near_ones(
    effects: ServoEffects,
    kind: ServoKind,
    left: Callable[[ServoEffects], Array],
    solve: Effects,
    seed: int,
) -> ServoEffects:
    """Return the servos with others that explain the crawls better, where few of them do.

    left: what each servo leaves of the crawls, in sigmas, frictions being let follow, (S, R).
    solve: tells what further servos do.
    """
    rng = np.random.default_rng([seed, 1])
    first = len(effects.servos)
    drawn_by: list[tuple[_Near, int]] = []
    for _ in range(_ROUNDS):
        off = left(effects)
        prior = np.zeros(len(off)) if effects.log_weight is None else effects.log_weight
        log = prior - 0.5 * np.sum(off**2, axis=1)
        if alike(log) >= ENOUGH_SERVOS:
            break
        near = _Near.to(kind, effects.servos, off, log)
        fresh = tuple(near.draw(kind, rng) for _ in range(_FRESH))
        effects = together(effects, solve(fresh))
        drawn_by.append((near, len(fresh)))
        effects = replace(effects, log_weight=_log_weight(kind, effects.servos, first, drawn_by))
    return effects


@dataclass(frozen=True)
class _Near:
    """Student's distribution of the servos' unknowns, (D,), and how likely each rate is."""

    free: list[int]
    centre: Array
    root: Array
    rates: dict[float, float]

    @classmethod
    def to(cls, kind: ServoKind, servos: Sequence[Servo], off: Array, log: Array) -> _Near:
        """Return what linear fits of what is left make of the posterior, near the best servos."""
        units = np.array([kind.units_of(one) for one in servos])
        free = np.flatnonzero(np.ptp(units, axis=0) > 0.0).tolist()
        weight = softened(log, _PER_UNKNOWN * (len(free) + 1))
        known = np.column_stack([np.ones(len(units)), units[:, free]])
        root = np.sqrt(weight)[:, None]
        fitted = np.linalg.lstsq(root * known, root * off, rcond=None)[0]
        rest = root * (off - known @ fitted)
        spread = np.linalg.inv(np.eye(off.shape[1]) + rest.T @ rest)
        slopes = fitted[1:]  # (D, R)
        normal = slopes @ spread @ slopes.T + np.eye(len(free))
        centre = -np.linalg.solve(normal, slopes @ spread @ fitted[0])
        rates = np.array([one.update_hz for one in servos])
        every = kind.updates_hz or (kind.servo.update_hz,)
        return cls(
            free,
            centre,
            _WIDE * np.linalg.cholesky(np.linalg.inv(normal)),
            {r: 0.5 / len(every) + 0.5 * float(weight[rates == r].sum()) for r in every},
        )

    def draw(self, kind: ServoKind, rng: np.random.Generator) -> Servo:
        """Return a servo that is possible."""
        rates = list(self.rates)
        while True:
            wide = np.sqrt(_FREEDOM / rng.chisquare(_FREEDOM))
            units = np.zeros(len(kind.units_of(kind.servo)))
            units[self.free] = self.centre + wide * self.root @ rng.normal(size=len(self.free))
            rate = rates[int(rng.choice(len(rates), p=list(self.rates.values())))]
            made = kind.at(units.tolist(), rate)
            if made is not None:
                return made

    def log_density(self, units: Array, rates: Array) -> Array:
        from scipy.stats import multivariate_t

        law = multivariate_t(self.centre, self.root @ self.root.T, df=int(_FREEDOM))
        return np.log([self.rates[r] for r in rates]) + law.logpdf(units[:, self.free])


def softened(log: Array, least: float) -> Array:
    """Return weights, sum 1, by the highest power of exp(log) that leaves so many alike."""
    power = 1.0
    while alike(power * log) < least:
        power /= 1.3
    weight = np.exp(power * (log - log.max()))
    return weight / weight.sum()


def _log_weight(
    kind: ServoKind, servos: Sequence[Servo], first: int, drawn_by: list[tuple[_Near, int]]
) -> Array:
    """Return the logarithm of the kind's density over the mean density of all draws."""
    units = np.array([kind.units_of(one) for one in servos])
    rates = np.array([one.update_hz for one in servos])
    free = drawn_by[0][0].free
    kinds = -0.5 * np.sum(units[:, free] ** 2 + np.log(2 * np.pi), axis=1)
    kinds = kinds - np.log(len(kind.updates_hz or (0,)))
    each = [
        np.log(first) + kinds,
        *(np.log(n) + near.log_density(units, rates) for near, n in drawn_by),
    ]
    return np.asarray(kinds + np.log(len(servos)) - np.logaddexp.reduce(each))
