"""Crawls beside other readings: draws of what all of them leave, and the likeliest of all.

The other readings are a posterior of their own, from which particles begin: their unknowns, and the
joints' amplitude over the commanded one. The crawls' likelihood is its mean over a pool of servos,
of which one moves the joints. By this likelihood the particles are tempered, whatever its shape:
speeds alone leave a curved valley beside a cliff.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...base.particles import tempered
from ..fitting.bends import Bends, frictions_in
from ..fitting.posterior import Posterior
from ..fitting.shared import FRICTIONS
from ..fitting.unknowns import Floats, Unknown, Values, Whole
from ..speeds import AMPLITUDE_SIGMA, LEAST_M_S, ServoEffects, SpeedTable
from .data import CrawlData

MOVES = 2
NEVER = -1e300  # the logarithm of no chance: a number times 0 is 0
_SOLVED, _ROUNDS = 128, 4  # points at which speeds are solved for, and how often at so many more
# The same where frictions spread over decades.
_MOVES_WIDE, _SOLVED_WIDE = 10, 512
_CLOSE = 0.1  # sigmas of a measured speed: so good are those between
_STEP = 0.01  # of an unknown, for slopes
_NONE = np.empty(0)
_LEAST, _MOST = 0.05, 2.0  # of the joints' amplitude over the commanded one


@dataclass(frozen=True, eq=False)
class Beforehand:
    """Frictions as they are known without readings, a block of a posterior: log-normal ones.

    mean (P,), root (P, P): of their logarithms, and of these logarithms' covariance.
    """

    mean: Floats
    root: Floats

    pool = (), _NONE
    bends = Bends(_NONE, _NONE, np.empty(0, dtype=np.intp), np.empty((2, 0)), _NONE, _NONE)

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return the frictions."""
        return tuple(Unknown(name, friction=True) for name in FRICTIONS[: len(self.mean)])

    @property
    def numbers(self) -> Whole:
        """Return that none of the residuals is a reading's."""
        return np.full(len(self.mean), -1)

    def whole(self, u: Floats) -> Floats:
        """Return the frictions of standard normal unknowns (K, P)."""
        return np.exp(self.mean + u @ self.root.T)

    def residuals(self, values: Values) -> Floats:
        """Return the residuals (K, P)."""
        return np.linalg.solve(self.root, (np.log(frictions_in(values)) - self.mean).T).T

    def near(self, values: Values) -> Beforehand:
        """Return itself: nothing in it is made linear."""
        return self

    def nuisances(self, values: Values) -> dict[str, Floats]:
        """Return nothing."""
        return {}


@dataclass(frozen=True)
class CrawlPosterior:
    """The posterior of crawls and of other readings, which are one by themselves.

    Points z (K, D) are the others' unknowns, frictions by their logarithms, and last the joints'
    amplitude in sigmas. Where frictions are known beforehand every logarithm is as likely, else
    every friction. wide: frictions may spread over decades, as those of crawls alone.
    """

    others: Posterior
    data: CrawlData
    speeds: SpeedTable
    effects: ServoEffects
    amplitude_sigma: float = AMPLITUDE_SIGMA
    wide: bool = False

    @property
    def alone(self) -> bool:
        """Tell whether no other reading tells the frictions."""
        return any(isinstance(block, Beforehand) for block in self.others.blocks)

    def points(self, x: Floats, seed: int) -> Floats:
        """Return points with the others' unknowns (K, D - 1), and amplitudes drawn evenly."""
        from scipy.special import ndtri

        even = np.random.default_rng(seed).permutation((np.arange(len(x)) + 0.5) / len(x))
        of = self.others.frictions
        return np.column_stack([np.log(np.maximum(x[:, :of], 1e-12)), x[:, of:], ndtri(even)])

    def unknowns(self, z: Floats) -> Floats:
        """Return the others' unknowns (K, D - 1)."""
        of = self.others.frictions
        with np.errstate(over="ignore"):
            return np.column_stack([np.exp(z[:, :of]), z[:, of:-1]])

    def whole(self, z: Floats) -> Floats:
        """Return the frictions."""
        return np.exp(z[:, : self.others.frictions])

    def amplitude(self, z: Floats) -> Floats:
        """Return the joints' amplitudes over the commanded ones."""
        return np.clip(1.0 + self.amplitude_sigma * z[:, -1], _LEAST, _MOST)

    def before(self, z: Floats) -> Floats:
        """Return the logarithm of the density without crawls, but for a constant."""
        x, low = self.unknowns(z), self.others.low
        inside = np.asarray((x >= low).all(axis=1) & np.isfinite(x).all(axis=1))
        log = self.others.log_density(np.where(inside[:, None], x, 1.0)) - 0.5 * z[:, -1] ** 2
        if not self.alone:
            log += z[:, : self.others.frictions].sum(axis=1)
        return np.where(inside, log, NEVER)

    def residuals(self, z: Floats) -> Floats:
        """Return (K, servos, gaits and films): predicted less measured, in sigmas.

        Of speeds as `SpeedTable` has them: their logarithms.
        """
        data, effects, amplitude = self.data, self.effects, self.amplitude(z)
        ideal = self.speeds(self.whole(z), amplitude)
        predicted = np.log(ideal[:, None] * effects.shares(amplitude) + LEAST_M_S)
        measured = data.speed_m_s + LEAST_M_S
        sigma = np.hypot(data.sigma_m_s, effects.sigma * data.speed_m_s)
        crawled = (predicted - np.log(measured)) * (measured / sigma)
        swung = effects.gains(amplitude) - data.gain
        swung = swung / np.hypot(data.gain_sigma, effects.sigma)
        return np.concatenate([crawled, swung], axis=2)

    def by_servo(self, z: Floats) -> Floats:
        """Return the logarithm of the likelihood times each servo's chance, (K, servos).

        The likelihood of no residual is 1.
        """
        from scipy.special import log_softmax

        log = -0.5 * self.residuals(z) ** 2
        chance = log_softmax(np.zeros(len(self.effects.share)) + self.effects.log_weight)
        return np.einsum("ksr->ks", log) + chance

    def log_likelihood(self, z: Floats) -> Floats:
        """Return the logarithm of the likelihood, its mean over servos (K,)."""
        log = self.by_servo(z)
        most = log.max(axis=1)
        return most + np.log(np.exp(log - most[:, None]).sum(axis=1))

    def draw(self, x: Floats, seed: int) -> CrawlDraws:
        """Return as many draws as of the others' unknowns (N, D - 1), of which they are made.

        Speeds are solved for at some of them, until those between are as good.
        """
        first, rng = self.solved(x, seed), np.random.default_rng(seed)
        sigma = self.data.sigma_m_s / (self.data.speed_m_s + LEAST_M_S)

        def particles(moves: int) -> tuple[Floats, float]:
            return tempered(first, self.before, self.log_likelihood, rng, moves)

        z, evidence = particles(MOVES)
        for _ in range(_ROUNDS - 1):
            off = self._solve(z, rng) / sigma
            if np.sqrt(np.mean(off**2, axis=0)).max() < _CLOSE:
                break
            z, evidence = particles(MOVES)
        if self.wide:
            z, evidence = particles(_MOVES_WIDE)
        return CrawlDraws(self, z, evidence, seed)

    def solved(self, x: Floats, seed: int) -> Floats:
        """Return points with the others' unknowns, as `points`; at some speeds are solved for."""
        z = self.points(x, seed)
        if not self.speeds.known:
            self._solve(z, np.random.default_rng(seed))
        return z

    def _solve(self, z: Floats, rng: np.random.Generator) -> Floats:
        """Solve for speeds at some points; return by how much the table was off there."""
        some = rng.permutation(np.unique(z, axis=0))[: _SOLVED_WIDE if self.wide else _SOLVED]
        return self.speeds.add(self.whole(some), self.amplitude(some))


@dataclass(frozen=True)
class CrawlDraws:
    """Draws z (N, D), each as likely as any other; the likeliest of all is sought from them.

    evidence: the logarithm of the crawls' likelihood, its mean over all that was known before.
    """

    posterior: CrawlPosterior
    z: Floats
    evidence: float
    seed: int

    @cached_property
    def _by_servo(self) -> Floats:
        return self.posterior.by_servo(self.z)

    @cached_property
    def servo(self) -> NDArray[np.intp]:
        """Return which servo goes with each draw."""
        rng = np.random.default_rng(self.seed)
        return np.argmax(self._by_servo + rng.gumbel(size=self._by_servo.shape), axis=1)

    @cached_property
    def _best(self) -> tuple[int, int]:
        """Return the likeliest draw and servo."""
        log = self._by_servo + self.posterior.before(self.z)[:, None]
        draw, servo = np.unravel_index(np.argmax(log), log.shape)
        return int(draw), int(servo)

    @property
    def best_servo(self) -> int:
        """Return the likeliest servo."""
        return self._best[1]

    def _rows(self, z: Floats) -> Floats:
        """Return the residuals of all readings with the likeliest servo, then the amplitude's."""
        others = self.posterior.others.residuals(self.posterior.unknowns(z))
        return np.column_stack([others, self.posterior.residuals(z)[:, self.best_servo], z[:, -1]])

    @cached_property
    def best(self) -> Floats:
        """Return the likeliest point (D,) near the likeliest draw."""
        from scipy.optimize import least_squares

        start = self.z[self._best[0]]

        def slopes(z: Floats) -> Floats:
            ends = self._rows(z + _STEP * np.vstack([np.zeros(len(z)), np.eye(len(z))]))
            return (ends[1:] - ends[0]).T / _STEP

        solved = least_squares(
            lambda z: self._rows(z[None])[0],
            start,
            jac=slopes,  # pyright: ignore[reportArgumentType]
            ftol=1e-3,
            xtol=1e-3,
            max_nfev=12,
        )
        low = np.append(self.posterior.others.low, -np.inf)
        low[: self.posterior.others.frictions] = -np.inf
        return np.maximum(np.asarray(solved.x), low)

    @property
    def best_whole(self) -> Floats:
        """Return the likeliest frictions (P,)."""
        return self.posterior.whole(self.best[None])[0]

    @property
    def best_amplitude(self) -> float:
        """Return the likeliest amplitude of the joints over the commanded one."""
        return float(self.posterior.amplitude(self.best[None])[0])

    @property
    def chi2(self) -> float:
        """Return the sum of squares of all rows there."""
        return float(np.sum(self._rows(self.best[None])[0] ** 2))
