"""Draws of the frictions and the joints' amplitude that speeds of crawls leave, whatever its shape.

Unknown are u, standard normal before the crawls: the logarithms of P frictions and the joints'
amplitude, D = P + 1; and which of some servos moves the joints. Where pushes measured the frictions
there is one minimum, and points about it are weighed by their posterior. Else speeds leave a curved
valley beside a cliff, with several minima: tempered particles reach all of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...model.particles import Student, tempered
from .data import LEAST_M_S, CrawlData
from .servos import ServoEffects, softened
from .speeds import Array, Speeds

_STEP = 0.02  # of an unknown, for slopes
_SHIFTS = np.linspace(-2.5, 2.0, 15)  # of the amplitude, in sigmas: the search begins at the best
_STARTS = 256  # further ones, all over, where there may be several minima
_SETTLED = 0.01  # of chi2
_SERVO_CHANGES = 4  # of the likeliest servo, while the likeliest frictions are searched
_POINTS, _ROUNDS = 1024, 3  # about the minimum, while too few of them count
_ENOUGH, _SOFT = 0.3, 0.2  # of these: as many independent ones; or softened, for moments
_PARTICLES, _MOVES = 1024, 2
_LOG_2PI = math.log(2 * math.pi)
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
    """What is left: draws of frictions (N, P) and amplitude (N,), all alike; the likeliest of them.

    servo: of each draw, its index among those given. best_whole, best_amplitude, best_servo: the
    likeliest. chi2: there, priors in it. effective: how many
    independent draws they are worth.
    """

    whole: Array
    amplitude: Array
    servo: NDArray[np.intp]
    best_whole: Array
    best_amplitude: float
    best_servo: int
    chi2: float
    effective: float


class Posterior:
    """Logarithm of the posterior over unknowns u, and its minima."""

    def __init__(self, data: CrawlData, before: Before, speeds: Speeds, effects: ServoEffects):
        self._data, self._before, self._speeds, self._effects = data, before, speeds, effects
        from scipy.special import log_softmax

        known = effects.log_weight
        self.size = len(before.mean) + 1
        self._log_weight = log_softmax(np.zeros(len(effects.share)) if known is None else known)

    def residuals(self, u: Array) -> Array:
        """Return (K, servos, gaits, films and further rows): predicted less measured, in sigmas.

        In logarithms of speed and LEAST_M_S together: at the foot of a cliff they still tell where
        it is, and what crawls slower than that is as good as at rest.
        """
        data, before, effects = self._data, self._before, self._effects
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
        return np.concatenate([crawled, swung, beside], axis=2)

    def by_servo(self, u: Array) -> Array:
        """Return the logarithm of the posterior with each servo, (K, servos)."""
        own = -0.5 * np.sum(self.residuals(u) ** 2, axis=2) + self._log_weight
        return np.asarray(own - 0.5 * np.sum(u**2, axis=1)[:, None])

    def log_density(self, u: Array) -> Array:
        """Return the logarithm of the posterior of unknowns (K, D).

        No residual's likelihood is 1, and the constant of the normal density is left out.
        """
        from scipy.special import logsumexp

        return np.asarray(logsumexp(self.by_servo(u), axis=1))

    def chi2(self, u: Array) -> Array:
        """Return the sum of squares (K,) at unknowns (K, D) with the best servo, priors in it."""
        squares = np.sum(self.residuals(u) ** 2, axis=2).min(axis=1)
        return np.asarray(squares + np.sum(u**2, axis=1))

    def _slopes(self, u: Array) -> tuple[Array, Array]:
        """Return residuals, (K, servos, R), and their slopes, (K, servos, R, D)."""
        ends = np.concatenate([u, *(u + _STEP * e for e in np.eye(self.size))])
        every = self.residuals(ends)
        every = every.reshape(self.size + 1, len(u), *every.shape[1:])
        return every[0], np.moveaxis(every[1:] - every[0], 0, -1) / _STEP

    def _about(self, u: Array) -> tuple[Array, Array, Array, Array]:
        """Return of each servo, linear about a point (D,): its residuals at its minimum, the step
        there, J'J + 1, and half chi2 there.
        """
        off, slopes = (part[0] for part in self._slopes(u[None]))
        normal = np.einsum("kgi,kgj->kij", slopes, slopes) + np.eye(self.size)
        gradient = np.einsum("kgi,kg->ki", slopes, off) + u
        step = -np.linalg.solve(normal, gradient[..., None])[..., 0]
        off = off + np.einsum("kgi,ki->kg", slopes, step)
        half = 0.5 * (np.sum(off**2, axis=1) + np.sum((u + step) ** 2, axis=1))
        return off, step, normal, half

    def left(self, u: Array) -> Array:
        """Return what each servo leaves, in sigmas, once the unknowns at a point (D,) follow."""
        off, step, *_ = self._about(u)
        return np.column_stack([off, u + step])

    def about(self, u: Array) -> Student:
        """Return a distribution with the moments of all servos' normal ones about a point (D,)."""
        _, step, normal, half = self._about(u)
        log = self._log_weight - half - 0.5 * np.linalg.slogdet(normal)[1]
        weight = np.exp(log - log.max())
        weight /= weight.sum()
        centre = weight @ step
        spread = np.linalg.inv(normal) + np.einsum("ki,kj->kij", step - centre, step - centre)
        root = np.linalg.cholesky(np.tensordot(weight, spread, 1))
        return Student(u + centre, np.asarray(root, dtype=np.float64))

    def minimum(self) -> Array:
        """Return the likeliest unknowns (D,), from the best of many starts.

        Speeds have several minima, and nothing leads back from the foot of their cliff.
        """
        starts = _SHIFTS[:, None] * np.eye(self.size)[-1]
        log = self.log_density(starts)
        edged = np.concatenate([[-np.inf], log, [-np.inf]])
        starts = starts[(log > edged[:-2]) & (log >= edged[2:])]
        if not self._before.narrow:
            further = np.random.default_rng(_STARTS).normal(size=(_STARTS, self.size))
            starts = np.vstack([starts, further[np.argmax(self.log_density(further))]])
        ends = np.array([self.minimum_near(start) for start in starts])
        return ends[np.argmin(self.chi2(ends))]

    def minimum_near(self, start: Array) -> Array:
        """Return the likeliest unknowns (D,) near a start (D,)."""
        from scipy.optimize import least_squares

        best = start
        for _ in range(_SERVO_CHANGES):
            followed = np.sum(self.left(best) ** 2, axis=1) - 2.0 * self._log_weight
            servo = int(np.argmin(followed))

            def rows(x: Array, servo: int = servo) -> Array:
                return np.append(self.residuals(x[None])[0, servo], x)

            def slopes(x: Array, servo: int = servo) -> Array:
                return np.vstack([self._slopes(x[None])[1][0, servo], np.eye(self.size)])

            u = np.asarray(
                least_squares(rows, best, jac=slopes, ftol=1e-3, xtol=1e-3, max_nfev=12).x  # pyright: ignore[reportArgumentType]
            )
            if self.chi2(u[None])[0] > self.chi2(best[None])[0] - _SETTLED:
                break
            best = u
        return best


def draw(posterior: Posterior, before: Before, count: int, seed: int) -> Drawn:
    """Draw from the posterior; count: draws that are returned."""
    rng = np.random.default_rng(seed)
    drawn = about_minimum(posterior, seed) if before.narrow else None
    if drawn is None or drawn.effective < _ENOUGH * _POINTS:
        drawn = by_particles(posterior, seed)
    u, weight = drawn.u, drawn.weight
    each = posterior.by_servo(u)
    best = posterior.minimum_near(drawn.best)
    servo = int(np.argmax(posterior.by_servo(best[None])[0]))
    steps = (np.arange(count) + rng.random()) / count
    rows = rng.permutation(np.minimum(np.searchsorted(np.cumsum(weight), steps), len(u) - 1))
    gumbel = -np.log(-np.log(rng.uniform(1e-12, 1.0, size=(count, each.shape[1]))))
    return Drawn(
        before.whole(u[rows]),
        before.amplitude(u[rows]),
        np.argmax(each[rows] + gumbel, axis=1),
        before.whole(best[None])[0],
        float(before.amplitude(best[None])[0]),
        servo,
        float(posterior.chi2(best[None])[0]),
        drawn.effective,
    )


@dataclass(frozen=True)
class Weighted:
    """Points u (N, D) of a posterior and their weights, which sum to 1.

    evidence: the logarithm of the crawls' likelihood, its mean over what was known before and all
    servos; that of no residual is 0. best: the likeliest point (D,).
    """

    u: Array
    weight: Array
    evidence: float
    best: Array

    @property
    def effective(self) -> float:
        """Return how many independent draws they are worth."""
        return 1.0 / float(np.sum(self.weight**2))


def about_minimum(
    posterior: Posterior, seed: int, count: int = _POINTS, rounds: int = _ROUNDS
) -> Weighted:
    """Return points about the minimum, each by its posterior; count: a power of two.

    Where few of them count, further ones are drawn by the moments of these, some rounds long.
    """
    best = posterior.minimum()
    about, most = posterior.about(best), None
    for part in range(rounds):
        u = about.points(count, seed + part)
        log = posterior.log_density(u) - about.log_density(u)
        weight = np.exp(log - log.max())
        evidence = float(log.max()) + math.log(weight.mean()) - 0.5 * len(best) * _LOG_2PI
        drawn = Weighted(u, weight / weight.sum(), evidence, best)
        most = drawn if most is None or drawn.effective > most.effective else most
        if most.effective >= _ENOUGH * count:
            break
        soft = softened(log, _SOFT * count)
        root = np.linalg.cholesky(np.cov(u.T, aweights=soft))
        about = Student(soft @ u, np.asarray(root, dtype=np.float64))
    assert most is not None  # one round at least
    return most


def by_particles(posterior: Posterior, seed: int) -> Weighted:
    """Return tempered particles that begin as what was known before."""
    rng = np.random.default_rng(seed)
    u = rng.normal(size=(_PARTICLES, posterior.size))
    u, evidence = tempered(
        u, lambda u: -0.5 * np.sum(u**2, axis=1), posterior.log_density, rng, _MOVES
    )
    best = u[np.argmax(posterior.log_density(u))]
    return Weighted(u, np.full(_PARTICLES, 1.0 / _PARTICLES), evidence, best)
