"""Servos drawn anew where few of a kind explain a session's crawls.

Of some servos drawn from a kind often none moves weak joints as the films showed. Then more are
drawn where the crawls say: residuals are taken as normal, with what friction and amplitude leave in
doubt in their covariance, and their means as linear in the servos' unknowns. That posterior is
drawn from, by Student's distribution. Each servo counts by the kind's density over the mean density
of all draws.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from ...base.particles import Student, alike
from ...model.drives import Servo, ServoKind
from ..fitting.unknowns import Floats
from ..speeds import ServoEffects
from .posterior import CrawlPosterior

SERVO_DRAWS = 128
ENOUGH_SERVOS = 10.0  # alike ones: no more are drawn
_ROUNDS, _FRESH, _TRIED = 4, 64, 512  # of the latter some are possible
_FARTHEST = 6.0  # units: beyond, no voltage is told from the highest one
_PER_UNKNOWN = 3  # servos that count, for each slope's unknown


def with_near_ones(
    posterior: CrawlPosterior,
    x: Floats,
    kind: ServoKind,
    solve: Callable[[tuple[Servo, ...]], ServoEffects],
    seed: int,
) -> CrawlPosterior:
    """Return the posterior with other servos, too, where few of its own explain the crawls.

    x: some draws of the others' unknowns. solve: tells what further servos do.
    """
    effects = posterior.effects
    first, every = len(effects.servos), np.array([kind.units_of(s) for s in effects.servos])
    free = np.flatnonzero(np.ptp(every, axis=0) > 0.0)
    drawn_by: list[tuple[Student, int]] = []
    z = posterior.solved(x, seed)
    for part in range(_ROUNDS):
        off = _off(posterior, z)
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
        logs = [np.log(n) + by.log_density(units) for by, n in drawn_by]
        draws = np.logaddexp.reduce([np.log(first) + kinds, *logs])
        effects = replace(effects, log_weight=kinds + np.log(len(units)) - draws)
        posterior = replace(posterior, effects=effects)
    return posterior


def _off(posterior: CrawlPosterior, z: Floats) -> Floats:
    """Return each servo's residuals (S, R), independent ones of standard deviation 1."""
    rows = posterior.residuals(z)
    doubt = np.cov(rows.mean(axis=1).T).reshape((rows.shape[2],) * 2) + np.eye(rows.shape[2])
    return np.linalg.solve(np.linalg.cholesky(doubt), rows.mean(axis=0).T).T


def _near(units: Floats, off: Floats, log: Floats) -> Student:
    """Return what linear fits of what is left make of the posterior, near the best servos."""
    known = np.column_stack([np.ones(len(units)), units])
    root = np.sqrt(_softened(log, _PER_UNKNOWN * known.shape[1]))[:, None]
    fitted = np.linalg.lstsq(root * known, root * off, rcond=None)[0]
    rest = root * (off - known @ fitted)
    spread = np.linalg.inv(np.eye(off.shape[1]) + rest.T @ rest)
    slopes = fitted[1:]  # (D, R)
    covariance = np.linalg.inv(slopes @ spread @ slopes.T + np.eye(len(slopes)))
    return Student(-covariance @ slopes @ spread @ fitted[0], np.linalg.cholesky(covariance))


def _softened(log: Floats, least: float) -> Floats:
    """Return weights, sum 1, by the highest power of exp(log) that leaves so many alike."""
    power = 1.0
    while alike(power * log) < least:
        power /= 1.3
    weight = np.exp(power * (log - log.max()))
    return np.asarray(weight / weight.sum())


def _drawn(kind: ServoKind, near: Student, free: NDArray[np.intp], seed: int) -> tuple[Servo, ...]:
    """Return some servos that are possible."""
    rates = kind.updates_hz or (kind.servo.update_hz,)
    units = np.zeros((_TRIED, len(kind.units_of(kind.servo))))
    units[:, free] = np.clip(near.points(_TRIED, seed), -_FARTHEST, _FARTHEST)
    tried = (kind.at(row, rates[k % len(rates)]) for k, row in enumerate(units.tolist()))
    return tuple(islice(filter(None, tried), _FRESH))
