"""Draws of the frictions and the joints' amplitude that speeds of crawls leave, whatever its shape.

Unknown are u, standard normal before the crawls: the logarithms of P frictions and the joints'
amplitude, D = P + 1; and which of some servos moves the joints. Where pushes measured the frictions
there is one minimum, and a distribution follows the moments of points of the posterior. Else speeds
leave a curved valley beside a cliff, with several minima: tempered particles reach all of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...model.particles import LogDensity, Student, alike, tempered
from ..fitting.posterior import BAD_CHANCE, BAD_WIDTH
from ..speeds import Array, ServoEffects, Speeds
from .data import LEAST_M_S, CrawlData

_STEP = 0.02  # of an unknown, for slopes
_SHIFTS = np.linspace(-2.5, 2.0, 15)  # of the amplitude, in sigmas: the search begins at the peaks
_STARTS = 256  # further ones, all over, where frictions are in doubt
_SETTLED = 0.005  # of the logarithm of a density
_SERVO_CHANGES = 4  # of the likeliest servo, while the likeliest frictions are searched
POINTS, ROUGH_POINTS, _MOVES = 1024, 256, 2
_LOG_2PI = math.log(2 * math.pi)
_EVEN = math.sqrt(2 * math.log((1 / BAD_CHANCE - 1) * BAD_WIDTH) / (1 - BAD_WIDTH**-2.0))
ENOUGH = 0.3  # of the points: as many independent ones
_SOFT, _ROUNDS = 0.2, 5  # of the points, softened, for moments; and how often those are taken
_NARROW = 0.2  # of a logarithm: frictions that are known so well leave one minimum


@dataclass(frozen=True)
class Before:
    """What was known before the crawls: log frictions' mean (P,), root of their covariance.

    amplitude_sigma: of the joints' amplitude over the commanded one. rows, values: further
    readings that leave frictions open; their chi2 is |rows f + values|^2 over frictions f.
    """

    mean: Array
    root: Array
    amplitude_sigma: float
    rows: Array = field(default_factory=lambda: np.zeros((0, 0)))
    values: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def narrow(self) -> bool:
        """Tell whether the frictions are known so well that there is one minimum."""
        known = np.sqrt(np.sum(self.root**2, axis=1))
        return not len(self.rows) and float(known.max()) < _NARROW

    def whole(self, u: Array) -> Array:
        """Return the frictions of unknowns (K, D)."""
        return np.exp(self.mean + u[:, :-1] @ self.root.T)

    def amplitude(self, u: Array) -> Array:
        """Return the joints' amplitudes over the commanded ones."""
        return np.clip(1.0 + self.amplitude_sigma * u[:, -1], 0.05, 2.0)


@dataclass(frozen=True)
class Drawn:
    """Points u (N, D) of a posterior and their weights, which sum to 1; the likeliest of all.

    evidence: the logarithm of the crawls' likelihood, its mean over what was known before and all
    servos; that of no residual is 0. best: the likeliest unknowns (D,).
    """

    posterior: Posterior
    u: Array
    weight: Array
    evidence: float
    best: Array

    @cached_property
    def best_servo(self) -> int:
        """Return the likeliest servo there."""
        return int(np.argmax(self.posterior.by_servo(self.best[None])[0]))

    @cached_property
    def best_whole(self) -> Array:
        """Return the likeliest frictions (P,)."""
        return self.posterior.before.whole(self.best[None])[0]

    @property
    def best_amplitude(self) -> float:
        """Return the likeliest amplitude of the joints over the commanded one."""
        return float(self.posterior.before.amplitude(self.best[None])[0])

    @cached_property
    def misread(self) -> NDArray[np.bool_]:
        """Return of each crawl's and film's residual whether it is held for misread."""
        return np.abs(self._rows[: self.posterior.crawls]) > self.posterior.doubted

    @property
    def chi2(self) -> float:
        """Return the sum of squares of the others and of priors."""
        counted = np.delete(self._rows, np.flatnonzero(self.misread))
        return float(counted @ counted + self.best @ self.best)

    @cached_property
    def _rows(self) -> Array:
        return np.asarray(self.posterior.residuals(self.best[None])[0, self.best_servo])

    @property
    def effective(self) -> float:
        """Return how many independent draws they are worth."""
        return 1.0 / float(np.sum(self.weight**2))

    def alike(self, count: int, seed: int) -> tuple[Array, Array, NDArray[np.intp]]:
        """Return frictions (N, P), amplitudes and servos (N,) of draws as likely as any other."""
        rng, before = np.random.default_rng(seed), self.posterior.before
        steps = (np.arange(count) + rng.random()) / count
        rows = np.minimum(np.searchsorted(np.cumsum(self.weight), steps), len(self.u) - 1)
        u = self.u[rng.permutation(rows)]
        each = self.posterior.by_servo(u)
        servo = np.argmax(each + rng.gumbel(size=each.shape), axis=1)
        return before.whole(u), before.amplitude(u), servo


class Posterior:
    """Logarithm of the posterior over unknowns u, its minimum, and draws.

    misread: a reading may be a misreading.
    """

    def __init__(
        self,
        data: CrawlData,
        before: Before,
        speeds: Speeds,
        effects: ServoEffects,
        misread: bool = False,
    ):
        self._data, self.before, self._speeds, self.effects = data, before, speeds, effects
        from scipy.special import log_softmax

        self.size, self._misread = len(before.mean) + 1, misread
        self.crawls = len(data) + len(data.gain)
        self._log_weight = log_softmax(np.zeros(len(effects.share)) + effects.log_weight)

    def residuals(self, u: Array) -> Array:
        """Return (K, servos, gaits, films and further rows): predicted less measured, in sigmas.

        In logarithms of speed and LEAST_M_S together: at the foot of a cliff they still tell where
        it is, and what crawls slower than that is as good as at rest.
        """
        data, before, effects = self._data, self.before, self.effects
        whole, amplitude = before.whole(u), before.amplitude(u)
        ideal = self._speeds(whole, amplitude)
        predicted = np.log(ideal[:, None] * effects.shares(amplitude) + LEAST_M_S)
        measured = data.speed_m_s + LEAST_M_S
        sigma = np.hypot(data.sigma_m_s, effects.sigma * data.speed_m_s)
        crawled = (predicted - np.log(measured)) * (measured / sigma)
        swung = effects.gains(amplitude) - data.gain
        swung = swung / np.hypot(data.gain_sigma, effects.sigma)
        further = whole[:, : before.rows.shape[1]] @ before.rows.T + before.values
        shape = (*crawled.shape[:2], further.shape[1])
        beside = np.broadcast_to(further[:, None], shape)
        rows = np.concatenate([crawled, swung], axis=2)
        return np.concatenate([_in_doubt(rows) if self._misread else rows, beside], axis=2)

    @property
    def doubted(self) -> float:
        """Return the residual beyond which a misreading is likelier."""
        return float(_in_doubt(np.array(_EVEN))) if self._misread else math.inf

    def by_servo(self, u: Array) -> Array:
        """Return the logarithm of the posterior with each servo, (K, servos)."""
        own = -0.5 * np.sum(self.residuals(u) ** 2, axis=2) + self._log_weight
        return np.asarray(own + _log_normal(u)[:, None])

    def log_density(self, u: Array) -> Array:
        """Return the logarithm of the posterior of unknowns (K, D).

        No residual's likelihood is 1.
        """
        from scipy.special import logsumexp

        return np.asarray(logsumexp(self.by_servo(u), axis=1))

    def _slopes(self, u: Array) -> tuple[Array, Array]:
        """Return residuals at a point (D,), (servos, R), and their slopes, (servos, R, D)."""
        ends = self.residuals(u + _STEP * np.vstack([np.zeros(self.size), np.eye(self.size)]))
        return ends[0], np.moveaxis(ends[1:] - ends[0], 0, -1) / _STEP

    def _following(self, u: Array) -> tuple[Array, Array, Array]:
        """Return of each servo, the unknowns at a point (D,) following: residuals, u, normal."""
        off, slopes = self._slopes(u)
        normal = np.einsum("kgi,kgj->kij", slopes, slopes) + np.eye(self.size)
        gradient = np.einsum("kgi,kg->ki", slopes, off) + u
        step = -np.linalg.solve(normal, gradient[..., None])[..., 0]
        return off + np.einsum("kgi,ki->kg", slopes, step), u + step, normal

    def left(self, u: Array) -> Array:
        """Return what each servo leaves, in sigmas, once the unknowns at a point (D,) follow."""
        return np.column_stack(self._following(u)[:2])

    def _about(self, u: Array) -> Student:
        """Return a distribution with the moments of all servos' normal ones about a point (D,)."""
        from scipy import special

        off, ends, normal = self._following(u)
        half = 0.5 * (np.sum(off**2, axis=1) + np.sum(ends**2, axis=1))
        weight = special.softmax(self._log_weight - half - 0.5 * np.linalg.slogdet(normal)[1])
        centre = weight @ ends
        spread = np.linalg.inv(normal) + np.einsum("ki,kj->kij", ends - centre, ends - centre)
        return Student(centre, np.linalg.cholesky(np.tensordot(weight, spread, 1)))

    def minimum(self) -> Array:
        """Return the likeliest unknowns (D,), from each amplitude better than those beside it.

        Nothing leads back from the foot of a cliff.
        """
        starts = _SHIFTS[:, None] * np.eye(self.size)[-1]
        beside = np.pad(self.log_density(starts), 1, constant_values=-np.inf)
        peaks = (beside[1:-1] > beside[:-2]) & (beside[1:-1] >= beside[2:])
        starts = starts[peaks]
        if not self.before.narrow:
            further = np.random.default_rng(_STARTS).normal(size=(_STARTS, self.size))
            starts = np.vstack([starts, further[np.argmax(self.log_density(further))]])
        ends = np.array([self.minimum_near(start) for start in starts])
        return ends[np.argmax(self.by_servo(ends).max(axis=1))]

    def minimum_near(self, start: Array) -> Array:
        """Return the likeliest unknowns (D,) near a start (D,)."""
        from scipy.optimize import least_squares

        best, most = start, float(self.by_servo(start[None]).max())
        for _ in range(_SERVO_CHANGES):
            followed = np.sum(self.left(best) ** 2, axis=1) - 2.0 * self._log_weight
            servo = int(np.argmin(followed))

            def rows(x: Array, servo: int = servo) -> Array:
                return np.append(self.residuals(x[None])[0, servo], x)

            def slopes(x: Array, servo: int = servo) -> Array:
                return np.vstack([self._slopes(x)[1][servo], np.eye(self.size)])

            found = least_squares(rows, best, jac=slopes, ftol=1e-3, xtol=1e-3, max_nfev=12)  # pyright: ignore[reportArgumentType]
            before, most = most, float(self.by_servo(found.x[None]).max())
            if most < before + _SETTLED:
                break
            best = np.asarray(found.x)
        return best

    def about_minimum(self, seed: int, points: int = POINTS) -> Drawn:
        """Return weighted draws where there is one minimum; points: a power of two."""
        best = self.minimum()
        return Drawn(self, *adapted(self._about(best), self.log_density, seed, points), best)

    def by_particles(self, seed: int, points: int = POINTS) -> Drawn:
        """Return draws by tempered particles that begin as what was known before."""
        rng = np.random.default_rng(seed)
        u = rng.normal(size=(points, self.size))
        u, evidence = tempered(u, _log_normal, self.log_density, rng, _MOVES)
        best = self.minimum_near(u[np.argmax(self.log_density(u))])
        return Drawn(self, u, np.full(points, 1.0 / points), evidence, best)

    def draw(self, seed: int, points: int = POINTS) -> Drawn:
        """Return draws of whatever shape."""
        if self.before.narrow:
            drawn = self.about_minimum(seed, points)
            if drawn.effective > ENOUGH * points:
                return drawn
        return self.by_particles(seed, points)


def softened(log: Array, least: float) -> Array:
    """Return weights, sum 1, by the highest power of exp(log) that leaves so many alike."""
    power = 1.0
    while alike(power * log) < least:
        power /= 1.3
    weight = np.exp(power * (log - log.max()))
    return np.asarray(weight / weight.sum())


def adapted(about: Student, last: LogDensity, seed: int, count: int) -> tuple[Array, Array, float]:
    """Return points (N, D) of a density with one mode, their weights, and its log integral.

    They are drawn from a distribution about the mode, which then follows their moments, until
    enough of them count. count: a power of two.
    """
    most, best = 0.0, None
    for part in range(_ROUNDS):
        x = about.points(count, seed + part)
        log = last(x) - about.log_density(x)
        if alike(log) > most:
            weight, most = np.exp(log - log.max()), alike(log)
            best = x, weight / weight.sum(), float(log.max()) + math.log(weight.mean())
        if most >= ENOUGH * count:
            break
        soft = softened(log, _SOFT * count)
        root = np.linalg.cholesky(np.cov(x.T, aweights=soft))
        about = Student(soft @ x, np.asarray(root, dtype=np.float64))
    assert best is not None  # one round at least
    return best


def _log_normal(u: Array) -> Array:
    return np.asarray(-0.5 * np.sum(u**2 + _LOG_2PI, axis=1))


def _in_doubt(rows: Array) -> Array:
    """Return residuals whose squares say how likely readings are that may be misread."""
    fine = math.log(1.0 - BAD_CHANCE) - 0.5 * rows**2
    misread = math.log(BAD_CHANCE / BAD_WIDTH) - 0.5 * (rows / BAD_WIDTH) ** 2
    most = math.log(1.0 - BAD_CHANCE + BAD_CHANCE / BAD_WIDTH)
    return np.copysign(np.sqrt(2.0 * np.maximum(most - np.logaddexp(fine, misread), 0.0)), rows)
