"""What servos do to a session's crawls, and servos drawn anew where few explain what was seen.

Of some servos drawn from a kind often none moves weak joints as the films showed. Then more are
drawn where the crawls say: what is left of speeds and amplitudes is taken as linear in the servos'
unknowns, and that posterior is drawn from, by Student's distribution. Each servo counts by the
kind's density over the mean density of all draws.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.drives import Servo, ServoKind
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.particles import Student, alike
from ...model.robot import Robot
from ...periodic.servo_steady import moved_by
from ...periodic.steady import steady_gait
from ..speed_samples import in_threads, scaled
from .adapted import softened

Array = NDArray[np.float64]
SERVO_DRAWS = 128
SERVO_SIGMA = 0.005  # relative, of what a servo is predicted to do
GRAIN = 0.01  # the same, where few servos are drawn of many; a rough state is off by 0.003
ENOUGH_SERVOS = 10.0  # alike ones: no more are drawn
ENDS = 1 / 1.04, 1.04  # of the common amplitude, where it is known within some per cent
_ROUNDS, _FRESH, _TRIED = 4, 64, 512  # of the latter some are possible
_FARTHEST = 6.0  # units: beyond, no voltage is told from the highest one
_PER_UNKNOWN = 3  # servos that count, for each slope's unknown


@dataclass(frozen=True)
class ServoEffects:
    """What each of S servos does to G gaits.

    share: of the ideal speed, (S, G); where a film showed the joints, of that with the amplitude
    seen. amplitude: made over commanded, (S, films). Both with the joints' common amplitude as
    commanded; they change with its powers share_power and amplitude_power: a weak servo does not
    follow further. sigma: what both may be off by, relative.
    log_weight: (S,), of the kind's density over that of the draws.
    """

    servos: tuple[Servo, ...]
    share: Array
    amplitude: Array
    sigma: float = SERVO_SIGMA
    share_power: Array | float = 0.0
    amplitude_power: Array | float = 0.0
    log_weight: Array | float = 0.0

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
        by_gait, by_film = np.ix_(servos, gaits), np.ix_(servos, films)
        return replace(
            self,
            servos=tuple(self.servos[k] for k in servos),
            share=self.share[by_gait],
            amplitude=self.amplitude[by_film],
            share_power=np.asarray(self.share_power)[by_gait],
            amplitude_power=np.asarray(self.amplitude_power)[by_film],
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
    found = np.array(in_threads(lambda job: moved_by(*job), each))
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
        power[..., 0],
        power[:, films, 1],
    )


def together(one: ServoEffects, other: ServoEffects) -> ServoEffects:
    """Return two sets of servos as one."""
    names = ("share", "amplitude", "share_power", "amplitude_power")
    both = {n: np.vstack([getattr(one, n), getattr(other, n)]) for n in names}
    return replace(one, servos=one.servos + other.servos, **both)


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
    first, every = len(effects.servos), np.array([kind.units_of(s) for s in effects.servos])
    free = np.flatnonzero(np.ptp(every, axis=0) > 0.0)
    drawn_by: list[tuple[Student, int]] = []
    for part in range(_ROUNDS):
        off = left(effects)
        log = effects.log_weight - 0.5 * np.sum(off**2, axis=1)
        if alike(log) >= ENOUGH_SERVOS:
            break
        near = _near(every[:, free], off, log)
        fresh = _drawn(kind, near, free, seed + part)
        effects = together(effects, solve(fresh))
        drawn_by.append((near, len(fresh)))
        every = np.array([kind.units_of(s) for s in effects.servos])
        units = every[:, free]
        kinds = -0.5 * np.sum(units**2 + np.log(2 * np.pi), axis=1)
        each = [np.log(n) + by.log_density(units) for by, n in drawn_by]
        draws = np.logaddexp.reduce([np.log(first) + kinds, *each])
        effects = replace(effects, log_weight=kinds + np.log(len(units)) - draws)
    return effects


def _near(units: Array, off: Array, log: Array) -> Student:
    """Return what linear fits of what is left make of the posterior, near the best servos."""
    known = np.column_stack([np.ones(len(units)), units])
    root = np.sqrt(softened(log, _PER_UNKNOWN * known.shape[1]))[:, None]
    fitted = np.linalg.lstsq(root * known, root * off, rcond=None)[0]
    rest = root * (off - known @ fitted)
    spread = np.linalg.inv(np.eye(off.shape[1]) + rest.T @ rest)
    slopes = fitted[1:]  # (D, R)
    covariance = np.linalg.inv(slopes @ spread @ slopes.T + np.eye(len(slopes)))
    return Student(-covariance @ slopes @ spread @ fitted[0], np.linalg.cholesky(covariance))


def _drawn(kind: ServoKind, near: Student, free: NDArray[np.intp], seed: int) -> tuple[Servo, ...]:
    """Return some servos that are possible."""
    rates = kind.updates_hz or (kind.servo.update_hz,)
    units = np.zeros((_TRIED, len(kind.units_of(kind.servo))))
    units[:, free] = np.clip(near.points(_TRIED, seed), -_FARTHEST, _FARTHEST)
    tried = (kind.at(row, rates[k % len(rates)]) for k, row in enumerate(units.tolist()))
    return tuple(islice(filter(None, tried), _FRESH))
