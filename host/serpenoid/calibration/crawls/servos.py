"""Servos drawn anew where few of a kind explain a session's crawls.

Of some servos drawn from a kind often none moves weak joints as the films showed. Then more are
drawn where the crawls say: what is left of speeds and amplitudes is taken as linear in the servos'
unknowns, and that posterior is drawn from, by Student's distribution. Each servo counts by the
kind's density over the mean density of all draws.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from ...model.drives import Servo, ServoKind
from ...model.particles import Student, alike
from ..speeds import ServoEffects
from .posterior import Posterior, softened

Array = NDArray[np.float64]
SERVO_DRAWS = 128
ENOUGH_SERVOS = 10.0  # alike ones: no more are drawn
_ROUNDS, _FRESH, _TRIED = 4, 64, 512  # of the latter some are possible
_FARTHEST = 6.0  # units: beyond, no voltage is told from the highest one
_PER_UNKNOWN = 3  # servos that count, for each slope's unknown


def with_near_ones(
    effects: ServoEffects,
    kind: ServoKind,
    posterior: Callable[[ServoEffects], Posterior],
    solve: Callable[[tuple[Servo, ...]], ServoEffects],
    seed: int,
) -> ServoEffects:
    """Return the servos with others that explain the crawls better, where few of them do.

    posterior: of the crawls, with some servos. solve: tells what further servos do.
    """
    first, every = len(effects.servos), np.array([kind.units_of(s) for s in effects.servos])
    free = np.flatnonzero(np.ptp(every, axis=0) > 0.0)
    drawn_by: list[tuple[Student, int]] = []
    for part in range(_ROUNDS):
        crawls = posterior(effects)
        off = crawls.left(crawls.minimum())
        log = effects.log_weight - 0.5 * np.sum(off**2, axis=1)
        if alike(log) >= ENOUGH_SERVOS:
            break
        near = _near(every[:, free], off, log)
        fresh = _drawn(kind, near, free, seed + part)
        effects = effects.beside(solve(fresh))
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
