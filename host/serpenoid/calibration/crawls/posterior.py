"""Draws of the frictions and the joints' amplitude that speeds of crawls leave, whatever its shape.

Unknown are u, standard normal before the crawls: the logarithms of four frictions and the joints'
amplitude. Where pushes told the frictions, one Newton search finds the likeliest. Points are drawn
about it, for each servo by the normal distribution that the slopes there make of it, and some from
what was known before. Else the posterior is no normal cloud: speeds tell a curved valley beside a
cliff, with several minima. The minima are then sought from the best of many points all over. If
that is not enough, points are drawn about the best ones drawn so far, by the curvature found there.
Every point counts by its posterior over the mean density of all that were drawn from (adaptive
multiple importance sampling, Cornuet et al. 2012): the answer does not hang on where they were
drawn.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .data import LEAST_M_S, CrawlData
from .servos import ServoEffects
from .speeds import Array, Speeds

UNKNOWNS = 5
_FREEDOM = 4.0  # of Student's distribution: long tails cover what a curvature misses
_STEP = 0.02  # of an unknown, for slopes
_STARTS, _NEWTON, _ROUNDS, _CENTRES = 8, 8, 8, 24
_ENOUGH = 300.0  # independent draws: no further round is needed
_WIDE = 1.3  # of the widths by the curvature
_NARROW = 0.2  # of a logarithm: frictions that are known so well leave one minimum
_NARROW_FREEDOM, _NARROW_WIDE = 8.0, 1.1
_DEFENSIVE = 1 / 16  # of the points about one minimum: drawn from what was known before


@dataclass(frozen=True)
class Before:
    """What was known before the crawls: log frictions' mean (4,), root of their covariance.

    amplitude_sigma: of the joints' amplitude over the commanded one. rows, values: further
    readings that leave frictions open; their chi2 is |rows f + values|^2 over frictions f.
    """

    mean: Array
    root: Array
    amplitude_sigma: float
    rows: Array = field(default_factory=lambda: np.zeros((0, 4)))
    values: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def narrow(self) -> bool:
        """Tell whether the frictions are known so well that there is one minimum."""
        known = np.sqrt(np.sum(self.root**2, axis=1))
        return not len(self.rows) and float(known.max()) < _NARROW

    def whole(self, u: Array) -> Array:
        """Return the frictions of unknowns (K, 5)."""
        return np.exp(self.mean + u[:, :4] @ self.root.T)

    def amplitude(self, u: Array) -> Array:
        """Return the joints' amplitudes over the commanded ones."""
        return np.clip(1.0 + self.amplitude_sigma * u[:, 4], 0.05, 2.0)


@dataclass(frozen=True)
class Drawn:
    """What is left: draws of frictions (N, 4) and amplitude (N,), all alike; the likeliest of them.

    servo: of each draw, its index among those given. best_whole, best_amplitude, best_servo: the
    likeliest. chi2: there, priors in it. effective: how many
    independent draws they are worth. starts_lost: share of the minima found that is not believed.
    """

    whole: Array
    amplitude: Array
    servo: NDArray[np.intp]
    best_whole: Array
    best_amplitude: float
    best_servo: int
    chi2: float
    effective: float
    starts_lost: float


class Posterior:
    """Logarithm of the posterior over unknowns u, and its minima."""

    def __init__(self, data: CrawlData, before: Before, speeds: Speeds, effects: ServoEffects):
        self._data, self._before, self._speeds, self._effects = data, before, speeds, effects
        known = effects.log_weight
        self._log_weight = np.zeros(len(effects.share)) if known is None else known

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
        further = whole @ before.rows.T + before.values
        shape = (*crawled.shape[:2], further.shape[1])
        beside = np.broadcast_to(further[:, None], shape)
        return np.concatenate([crawled, swung, beside], axis=2)

    def by_servo(self, u: Array) -> Array:
        """Return the logarithm of the posterior with each servo, (K, servos), up to a constant."""
        own = -0.5 * np.sum(self.residuals(u) ** 2, axis=2) + self._log_weight
        return np.asarray(own - 0.5 * np.sum(u**2, axis=1)[:, None])

    def _slopes(self, u: Array) -> tuple[Array, Array]:
        """Return residuals, (K, servos, R), and their slopes, (K, servos, R, 5)."""
        ends = np.concatenate([u, *(u + _STEP * e for e in np.eye(UNKNOWNS))])
        every = self.residuals(ends)
        every = every.reshape(UNKNOWNS + 1, len(u), *every.shape[1:])
        return every[0], np.moveaxis(every[1:] - every[0], 0, -1) / _STEP

    def curvature(
        self, u: Array, servo: NDArray[np.intp] | None = None
    ) -> tuple[Array, Array, Array]:
        """Return J'J + 1 (K, 5, 5), the gradient (K, 5) and half chi2 (K,), at the best servo.

        servo: (K,), at these instead.
        """
        off, slopes = self._slopes(u)
        best = np.argmin(np.sum(off**2, axis=2), axis=1) if servo is None else servo
        each = np.arange(len(u)), best
        return _expanded(off[each], slopes[each], u)

    def left(self, u: Array) -> Array:
        """Return what each servo leaves, in sigmas, once the unknowns at a point (5,) follow."""
        off, slopes = (part[0] for part in self._slopes(u[None]))
        normal, gradient, _ = _expanded(off, slopes, np.broadcast_to(u, (len(off), UNKNOWNS)))
        step = -np.linalg.solve(normal, gradient[..., None])[..., 0]
        return np.column_stack([off + np.einsum("kgi,ki->kg", slopes, step), u + step])

    def about(self, u: Array) -> tuple[Array, Array, Array]:
        """Return each servo's normal approximation about a point (5,): weight, mean, J'J + 1."""
        off, slopes = (part[0] for part in self._slopes(u[None]))
        normal, gradient, cost = _expanded(off, slopes, np.broadcast_to(u, (len(off), UNKNOWNS)))
        step = -np.linalg.solve(normal, gradient[..., None])[..., 0]
        log = self._log_weight - cost - 0.5 * np.sum(step * gradient, axis=1)
        log = log - 0.5 * np.linalg.slogdet(normal)[1]
        weight = np.exp(log - log.max())
        return weight / weight.sum(), u + step, normal

    def minima(self, u: Array) -> Array:
        """Return where damped Newton steps from some points end."""
        damping = np.full(len(u), 1e-2)
        normal, gradient, cost = self.curvature(u)
        for _ in range(_NEWTON):
            damped = normal * (1.0 + damping[:, None, None] * np.eye(UNKNOWNS))
            step = -np.linalg.solve(damped, gradient[..., None])[..., 0]
            tried = u + np.clip(step, -1.0, 1.0)
            after = self.curvature(tried)
            better = after[2] < cost
            u = np.where(better[:, None], tried, u)
            normal = np.where(better[:, None, None], after[0], normal)
            gradient = np.where(better[:, None], after[1], gradient)
            gained = np.where(better, cost - after[2], 0.0)
            cost = np.where(better, after[2], cost)
            damping = np.where(better, damping / 5, damping * 10)
            if gained.max() < 0.01 and better.any():
                break
        return u


def _expanded(off: Array, slopes: Array, u: Array) -> tuple[Array, Array, Array]:
    """Return J'J + 1 (K, 5, 5), the gradient (K, 5) and half chi2 (K,) of residuals (K, R)."""
    normal = np.einsum("kgi,kgj->kij", slopes, slopes) + np.eye(UNKNOWNS)
    gradient = np.einsum("kgi,kg->ki", slopes, off) + u
    return normal, gradient, 0.5 * (np.sum(off**2, axis=1) + np.sum(u**2, axis=1))


def draw(posterior: Posterior, before: Before, count: int, seed: int, first: int = 512) -> Drawn:
    """Draw from the posterior; first: points drawn at once; count: draws given back."""
    rng = np.random.default_rng(seed)
    points, lost = _Points(posterior), 0.0
    if before.narrow:
        found = posterior.minima(np.zeros((1, UNKNOWNS)))
        mixture = _Mixture.by_servo(posterior, found[0])
    else:
        mixture, lost = _all_over(points, first, seed)
    for _ in range(_ROUNDS):
        points.add(mixture, mixture.draw(rng, first))
        weights = points.weights
        if 1.0 / np.sum(weights**2) > _ENOUGH:
            break
        chosen = rng.choice(len(weights), _CENTRES, p=weights)
        mixture = _Mixture.about(posterior, points.u[chosen], _one_each(points.each[chosen], rng))
    u, each, weights = points.u, points.each, points.weights
    best = posterior.minima(u[[int(np.argmax(each.max(axis=1)))]])
    likely = posterior.by_servo(best)[0]
    picked = _evenly(weights, count, rng)
    return Drawn(
        before.whole(u[picked]),
        before.amplitude(u[picked]),
        _one_each(each[picked], rng),
        before.whole(best)[0],
        float(before.amplitude(best)[0]),
        int(np.argmax(likely)),
        2.0 * float(posterior.curvature(best)[2][0]),
        1.0 / float(np.sum(weights**2)),
        lost,
    )


class _Points:
    """Points that were drawn so far, what they were drawn from, and their posterior by servo."""

    def __init__(self, posterior: Posterior):
        self.posterior = posterior
        self.u, self.each = np.empty((0, UNKNOWNS)), np.empty((0, 0))
        self._drawn_from: list[tuple[_Mixture, int]] = []

    def add(self, mixture: _Mixture, u: Array) -> None:
        """Take in points that were drawn from a mixture."""
        each = self.posterior.by_servo(u)
        self.u = np.concatenate([self.u, u])
        self.each = np.concatenate([self.each.reshape(-1, each.shape[1]), each])
        self._drawn_from.append((mixture, len(u)))

    @property
    def weights(self) -> Array:
        """Return each point's posterior over the mean density that it was drawn from, sum 1."""
        from scipy.special import logsumexp

        sizes = np.array([size for _, size in self._drawn_from])
        each = np.array([mixture.log_density(self.u) for mixture, _ in self._drawn_from])
        density = logsumexp(each + np.log(sizes / sizes.sum())[:, None], axis=0)
        weight = _summed(self.each) - np.asarray(density)
        weight = np.exp(weight - weight.max())
        return weight / weight.sum()


def _all_over(points: _Points, first: int, seed: int) -> tuple[_Mixture, float]:
    """Return what to draw from about all minima, and the share of them that is not believed."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    posterior = points.posterior
    sobol = qmc.Sobol(UNKNOWNS, seed=seed)  # pyright: ignore[reportCallIssue]
    points.add(_Mixture.normal(), ndtri(sobol.random(first)))
    found = posterior.minima(points.u[_apart(points.u, _summed(points.each), _STARTS)])
    costs = posterior.curvature(found)[2]
    lost = float(np.mean(costs > costs.min() + 8.0))
    return _Mixture.about(posterior, found[costs < costs.min() + 12.0]), lost


def _summed(each: Array) -> Array:
    """Return the logarithm of each row's sum."""
    from scipy.special import logsumexp

    return np.asarray(logsumexp(each, axis=1))


def _one_each(log: Array, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return one column's index a row, drawn by the logarithms of their weights."""
    gumbel = -np.log(-np.log(rng.uniform(1e-12, 1.0, size=log.shape)))
    return np.argmax(log + gumbel, axis=1)


@dataclass(frozen=True)
class _Mixture:
    """Student's distributions about some centres; freedom infinite: normal ones.

    shares: of each, all alike unless given.
    """

    centres: Array
    roots: Array
    freedom: float
    shares: Array | None = None

    @classmethod
    def normal(cls) -> _Mixture:
        return cls(np.zeros((1, UNKNOWNS)), np.eye(UNKNOWNS)[None], np.inf)

    @classmethod
    def about(
        cls, posterior: Posterior, centres: Array, servo: NDArray[np.intp] | None = None
    ) -> _Mixture:
        return cls(centres, _WIDE * _roots(posterior.curvature(centres, servo)[0]), _FREEDOM)

    @classmethod
    def by_servo(cls, posterior: Posterior, u: Array) -> _Mixture:
        """Return what the slopes at a minimum make of the posterior, and a share of what was."""
        weight, means, normal = posterior.about(u)
        counts = weight > 1e-6 * weight.max()
        weight, means, normal = weight[counts] / weight[counts].sum(), means[counts], normal[counts]
        return cls(
            np.vstack([means, np.zeros(UNKNOWNS)]),
            np.concatenate([_NARROW_WIDE * _roots(normal), np.eye(UNKNOWNS)[None]]),
            _NARROW_FREEDOM,
            np.append((1.0 - _DEFENSIVE) * weight, _DEFENSIVE),
        )

    def draw(self, rng: np.random.Generator, count: int) -> Array:
        of = rng.choice(len(self.centres), size=count, p=self.shares)
        wide = np.sqrt(self.freedom / rng.chisquare(self.freedom, size=count))
        units = rng.normal(size=(count, UNKNOWNS)) * wide[:, None]
        return self.centres[of] + np.einsum("kij,kj->ki", self.roots[of], units)

    def log_density(self, u: Array) -> Array:
        from scipy.special import gammaln, logsumexp

        off = u[:, None] - self.centres
        inverse = np.linalg.inv(self.roots)
        far = np.sum(np.einsum("cij,kcj->kci", inverse, off) ** 2, axis=2)
        volume = np.log(np.abs(np.linalg.det(self.roots)))
        d, n = UNKNOWNS, self.freedom
        if np.isinf(n):
            each = -0.5 * far - 0.5 * d * np.log(2 * np.pi) - volume
        else:
            head = gammaln((n + d) / 2) - gammaln(n / 2) - 0.5 * d * np.log(n * np.pi)
            each = head - volume - 0.5 * (n + d) * np.log1p(far / n)
        shares = np.full(len(volume), 1.0 / len(volume)) if self.shares is None else self.shares
        return np.asarray(logsumexp(each, axis=1, b=shares))


def _roots(normal: Array) -> Array:
    return np.asarray(np.linalg.cholesky(np.linalg.inv(normal)), dtype=np.float64)


def _apart(u: Array, log: Array, count: int) -> list[int]:
    """Return the best points that are some way from each other."""
    kept: list[int] = []
    for k in np.argsort(-log).tolist():
        if all(np.sum((u[k] - u[other]) ** 2) > 1.0 for other in kept):
            kept.append(k)
        if len(kept) == count:
            break
    return kept


def _evenly(weights: Array, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return indices drawn by weight, as evenly as can be, in no order."""
    at = (np.arange(count) + rng.random()) / count
    picked = np.searchsorted(np.cumsum(weights) / weights.sum(), at)
    return rng.permutation(np.minimum(picked, len(weights) - 1))
