"""The posterior of readings of all kinds: its MAP estimate, and samples of it.

A point x (D,) has the frictions in their unit, then the other parameters, transformed such that
their priors are standard normal: by their standard deviations, and for the errors of bends and
shared roundings by the root of their correlation. Residuals are standard normal: those of readings,
then those of priors.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..base.errors import NotConverged
from ..base.particles import explored, points_about
from .bends import BEND_ERROR, COMMON_ERROR, CORRELATION
from .parameters import FRICTIONS, ROUNDING, Floats, Integers, Parameter, Rows

if TYPE_CHECKING:
    from .pushes import Pushes
    from .stations import Stations

COUNT = len(FRICTIONS)
NEGATIVE_SAMPLE_WEIGHT = 0.25  # Weight of a sample in which another friction is negative. With 0,
# intervals were too narrow in sessions where that friction is 0, with 1 too wide.


@dataclass(frozen=True)
class Sampling:
    """Numbers of the sampling.

    count: importance samples about the estimate, with which an interval's end errs by 1 % of its
    half width. max_residuals, min_count: largest total of residuals, which reduces count, but not
    below min_count. min_independent: smallest effective number of importance samples; with less,
    `particles` particles make `moves` moves. spread: share of the particles that start at any
    sample with equal probability, so that not all start at one. block_residuals: number of
    residuals computed at a time, so that they fit into the processor's cache.
    """

    count: int = 32768
    max_residuals: int = 2**21
    min_count: int = 4096
    particles: int = 1024
    moves: int = 200
    spread: float = 0.1
    min_independent: float = 2000.0
    block_residuals: int = 2**15


@dataclass(frozen=True)
class Solving:
    """Numbers of the search for the MAP estimate.

    difference: relative step of the finite differences, of frictions over min_friction at least.
    max_rounds: most linearisations of films; most need 5, those of robots that slip 10.
    whole_rounds: rounds with whole steps; later ones take a half, a third and so on, because slip
    is not quite smooth. settled_sigmas: largest last step of a round; convergence is quadratic.
    zero_sigmas: frictions below this part of their sigma become 0. refit_steps, refit_sigmas: most
    steps of an estimate without some residuals, and its largest last step. max_evaluations: most
    evaluations of the residuals by the solver.
    """

    difference: float = 1e-5
    min_friction: float = 0.1
    max_rounds: int = 60
    whole_rounds: int = 6
    settled_sigmas: float = 1e-2
    zero_sigmas: float = 1e-6
    refit_steps: int = 12
    refit_sigmas: float = 1e-4
    max_evaluations: int = 200


SAMPLING, SOLVING = Sampling(), Solving()


@dataclass(frozen=True)
class MapEstimate:
    """The MAP estimate x (D,) with residuals (rows,) and slopes (rows, D), 0 in omitted rows."""

    posterior: Posterior
    x: Floats
    residuals: Floats
    slopes: Floats

    @property
    def chi2(self) -> float:
        """Return the sum of squared residuals."""
        return float(self.residuals @ self.residuals)

    @cached_property
    def covariance(self) -> Floats:
        """Return the covariance (D, D); raises NotConverged if a parameter is not determined.

        At a remote minimum a friction and the sigma of a reading may be 0. Its slopes of 1e12
        beside others of 1 leave only rounding errors.
        """
        information = self.slopes.T @ self.slopes
        scale = np.sqrt(np.diag(information))
        if np.isfinite(information).all() and scale.min() > 0.0:
            correlation = information / np.outer(scale, scale)
            if np.linalg.cond(correlation) * len(scale) * np.finfo(float).eps < 1.0:
                return np.asarray(np.linalg.inv(correlation) / np.outer(scale, scale))
        raise NotConverged("the readings contradict each other so far that no friction is told")

    def without(self, omitted: Rows) -> MapEstimate:
        """Return the estimate without some residuals; raises NotConverged.

        Films keep their linearisation. The search uses the slopes of this estimate, and the solver
        if that does not converge. omitted: (rows,).
        """
        posterior, x, weights = self.posterior, self.x, np.where(omitted, 0.0, 1.0)
        gain = posterior.estimate_at(x, weights).covariance @ self.slopes.T
        size = np.linalg.norm(self.slopes, axis=0)
        last_step = math.inf
        for _ in range(SOLVING.refit_steps):
            step = gain @ (weights * posterior.residuals(x[None])[0])
            x, largest = np.maximum(x - step, posterior.low), float((np.abs(step) * size).max())
            if not largest < last_step:
                break
            if largest < SOLVING.refit_sigmas and (x > posterior.low).all():
                return posterior.estimate_at(x, weights)
            last_step = largest
        return posterior.estimate_at(posterior.minimum(self.x, weights), weights)

    @property
    def values(self) -> dict[str, Floats]:
        """Return the parameters' values by name, (1,) each."""
        return self.posterior.by_name(self.x[None])


@dataclass(frozen=True)
class Samples:
    """Samples x (N, D) with their weights (N,), which sum to 1.

    unlimited: their weights if frictions could be negative; that of such a sample is 0 otherwise.
    """

    x: Floats
    weight: Floats
    unlimited: Floats

    def weight_for(self, friction: int) -> Floats:
        """Return the samples' weights (N,) for the interval of one friction, by its index."""
        negative = self.x[:, :COUNT] < 0.0
        other_errors = np.delete(negative, friction, axis=1).any(axis=1)
        weight = self.unlimited * np.where(other_errors, NEGATIVE_SAMPLE_WEIGHT, 1.0)
        weight = weight * ~negative[:, friction]
        return np.asarray(weight / weight.sum())


@dataclass(frozen=True)
class Posterior:
    """The posterior density of the parameters.

    kinds: the readings of each kind, with their parameters, numbers and residuals, and their
    linearisation. roundings_rad: samples (N, errors) of the shared rounding errors, whose prior is
    not normal.
    """

    kinds: tuple[Stations | Pushes, ...]
    roundings_rad: Floats

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Return every parameter once, the frictions first, roundings last."""
        parameters = itertools.chain.from_iterable(kind.parameters for kind in self.kinds)
        named = {parameter.name: parameter for parameter in parameters}
        return tuple(sorted(named.values(), key=lambda p: p.name.startswith(ROUNDING)))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return the parameters' names."""
        return tuple(p.name for p in self.parameters)

    @cached_property
    def low(self) -> Floats:
        """Return the least value of each coordinate."""
        parts = [(p.low - p.mean) / (p.sigma or 1.0) for p in self.parameters[COUNT:]]
        return np.concatenate([np.zeros(COUNT), parts])

    @cached_property
    def numbers(self) -> Integers:
        """Return the reading that each residual belongs to; -1 for a prior."""
        priors = np.full(len(self.names) - COUNT, -1)
        return np.concatenate([*(kind.numbers for kind in self.kinds), priors])

    @property
    def readings(self) -> list[int]:
        """Return the numbers of the readings, in their order."""
        return list(dict.fromkeys(self.numbers[self.numbers >= 0].tolist()))

    @cached_property
    def _by_coordinate(self) -> Floats:
        """Return the parameters' errors but frictions by the coordinates, (D - 4, D - 4)."""
        names, root = self.names[COUNT:], np.eye(len(self.names) - COUNT)
        if COMMON_ERROR in names:
            bends = [k for k, name in enumerate(names) if name.startswith(BEND_ERROR)]
            root[bends, bends] = math.sqrt(1.0 - CORRELATION)
            root[bends, names.index(COMMON_ERROR)] = math.sqrt(CORRELATION)
        first = len(root) - self.roundings_rad.shape[1]
        root[first:, first:] = self._rounding_root
        return np.array([p.sigma for p in self.parameters[COUNT:]])[:, None] * root

    @cached_property
    def _rounding_root(self) -> Floats:
        """Return the root of the roundings' correlation, (errors, errors)."""
        unit = self.roundings_rad / self.roundings_rad.std(axis=0)
        correlation = unit.T @ unit / len(unit)
        # less than a ten thousandth of it is a set point's alone, or many points had no inverse
        return np.linalg.cholesky(correlation + 1e-4 * np.eye(len(correlation)))

    def by_name(self, x: Floats) -> dict[str, Floats]:
        """Return the parameters' values at points (K, D), by their names."""
        means = [p.mean for p in self.parameters[COUNT:]]
        other_values = means + x[:, COUNT:] @ self._by_coordinate.T
        return dict(zip(self.names, (*x.T[:COUNT], *other_values.T), strict=True))

    def residuals(self, x: Floats) -> Floats:
        """Return the residuals (K, rows) at points (K, D): of readings, then of priors."""
        values = self.by_name(x)
        parts = [kind.residuals(values) for kind in self.kinds]
        return np.concatenate([*parts, x[:, COUNT:]], axis=1)

    def slopes(self, x: Floats) -> Floats:
        """Return the residuals' slopes (rows, D) at a point (D,), by central differences."""
        scale = np.where(np.arange(len(x)) < COUNT, SOLVING.min_friction, 1.0)
        step = SOLVING.difference * np.maximum(np.abs(x), scale)
        ends = self.residuals(np.concatenate([x + np.diag(step), x - np.diag(step)]))
        return np.asarray((ends[: len(x)] - ends[len(x) :]).T / (2 * step))

    def linear_about(self, x: Floats) -> Posterior:
        """Return the posterior with readings made linear about a point (D,), where they are."""
        values = self.by_name(x[None])
        return replace(self, kinds=tuple(kind.linear_about(values) for kind in self.kinds))

    def start(self, frictions: Sequence[float] | Floats) -> Floats:
        """Return a point (D,) with these frictions and all else as it was before the readings."""
        return np.append(frictions, np.zeros(len(self.names) - COUNT))

    def estimate(self, start: Floats) -> MapEstimate:
        """Return the MAP estimate from a start (D,), films linear about it. Or NotConverged."""
        posterior, x = self.linear_about(start), start
        for done in range(SOLVING.max_rounds):
            step = (posterior.minimum(x) - x) / max(done - SOLVING.whole_rounds, 1)
            x = x + step
            kinds, posterior = posterior.kinds, posterior.linear_about(x)
            moved = np.abs(step) * np.linalg.norm(posterior.slopes(x), axis=0)
            if posterior.kinds == kinds or moved.max() < SOLVING.settled_sigmas:
                return posterior.estimate_at(x)
        raise NotConverged("the fit came to no end")

    def minimum(self, start: Floats, weights: Floats | float = 1.0) -> Floats:
        """Return where the sum of squares is least (D,); weights: as for `estimate_at`."""
        from scipy.optimize import least_squares

        solved = least_squares(
            lambda x: weights * self.residuals(x[None])[0],
            np.maximum(start, self.low + 1e-9),
            jac=lambda x: (weights * self.slopes(x).T).T,  # pyright: ignore[reportArgumentType]
            bounds=(self.low, np.inf),
            x_scale="jac",
            **dict.fromkeys(("xtol", "ftol", "gtol"), 1e-12),
            max_nfev=SOLVING.max_evaluations,
        )
        if not solved.success:
            raise NotConverged("the readings contradict each other")
        # The solver stops just inside a limit of 0.
        size = np.linalg.norm(self.slopes(solved.x), axis=0)
        zero = (np.arange(len(size)) < COUNT) & (solved.x * size < SOLVING.zero_sigmas)
        return np.where(zero, 0.0, solved.x)

    def estimate_at(self, x: Floats, weights: Floats | float = 1.0) -> MapEstimate:
        """Return residuals and slopes at a point (D,); weights: (rows,), 0 for omitted ones."""
        residuals = weights * self.residuals(x[None])[0]
        return MapEstimate(self, x, residuals, (weights * self.slopes(x).T).T)

    def samples(self, estimate: MapEstimate, seed: int) -> Samples:
        """Return importance samples about an estimate, or particles if these are too few."""
        count = min(
            SAMPLING.count, max(SAMPLING.max_residuals // len(self.numbers), SAMPLING.min_count)
        )
        root = np.asarray(np.linalg.cholesky(estimate.covariance), dtype=np.float64)
        rng, normal = np.random.default_rng(seed), self.roundings_rad.shape[1]
        points, log_about = points_about(estimate.x, root, normal, count, rng)
        log = self.log_density(points) - log_about
        x = self._with_roundings(estimate, points, seed)
        weight = _shares(np.where((x >= self.low).all(axis=1), log, -np.inf))
        unlimited = _shares(log)
        if _independent(weight) >= SAMPLING.min_independent:
            enough = _independent(unlimited) >= SAMPLING.min_independent
            return Samples(x, weight, unlimited if enough else weight)
        x = self._explored(points, unlimited, rng)
        return Samples(x, *np.full((2, len(x)), 1.0 / len(x)))

    def _with_roundings(self, estimate: MapEstimate, x: Floats, seed: int) -> Floats:
        """Return points (K, D) whose rounding errors are sawteeth instead of normal.

        To first order the error of an estimate is C e, where e are the rounding errors and C is the
        covariance of the parameters with them, plus a part independent of e. A point at d from the
        estimate has e = d_e + n, where n has the covariance 1 - C_ee. This part is replaced.
        """
        samples, count = self.roundings_rad, self.roundings_rad.shape[1]
        if not count:
            return x
        rng, gain = np.random.default_rng([seed, 1]), estimate.covariance[:, -count:]
        values, vectors = np.linalg.eigh(np.eye(count) - gain[-count:])
        noise = rng.normal(size=(len(x), count)) * np.sqrt(np.maximum(values, 0.0))
        normal = x[:, -count:] - estimate.x[-count:] + noise @ vectors.T
        standard = np.linalg.solve(self._rounding_root, (samples / samples.std(axis=0)).T).T
        sawtooth = standard[rng.integers(len(samples), size=len(x))]
        return np.asarray(x + (sawtooth - normal) @ gain.T)

    def _explored(self, points: Floats, weight: Floats, rng: np.random.Generator) -> Floats:
        """Return samples (N, D) of particles that start from points with weights (K,)."""
        shares = (1.0 - SAMPLING.spread) * weight + SAMPLING.spread / len(weight)
        start = rng.choice(len(points), SAMPLING.particles, p=shares)

        def log_density(x: Floats) -> Floats:
            log = self.log_density(np.maximum(x, self.low))
            return np.where((x >= self.low).all(axis=1), log, -np.inf)

        x = np.maximum(points[start], self.low)
        return np.concatenate(explored(x, log_density, SAMPLING.moves, rng))

    def log_density(self, x: Floats) -> Floats:
        """Return the log density (K,) at points (K, D), up to a constant and without limits.

        It is NaN outside the limits where the residuals have no value.
        """
        pieces = max(len(x) * len(self.numbers) // SAMPLING.block_residuals, 1)
        with np.errstate(invalid="ignore", over="ignore"):
            parts = [np.sum(self.residuals(x) ** 2, axis=1) for x in np.array_split(x, pieces)]
        return -0.5 * np.concatenate(parts)


def _shares(log: Floats) -> Floats:
    """Return weights that sum to 1 from their logarithms; one has all if none is finite."""
    log = np.where(np.isnan(log), -np.inf, log)
    weight = np.exp(log - log.max()) if np.isfinite(log.max()) else np.eye(1, len(log))[0]
    return np.asarray(weight / weight.sum())


def _independent(weight: Floats) -> float:
    """Return the effective number of independent samples of given weights."""
    return float(1.0 / np.sum(weight**2))
