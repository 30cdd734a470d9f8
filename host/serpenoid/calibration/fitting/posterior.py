"""Readings of all kinds as one posterior: its mode, weighted draws, and what each reading does.

An unknown is a name with a prior. Nuisances count in standard deviations of their priors, so that
each is standard normal before the readings. Frictions count in their unit, and every value above 0
is as likely as any other. A block holds the readings of one kind: the unknowns that it needs, and
its residuals, each normal with standard deviation 1. Blocks that use the same name share it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...base.errors import NotConverged
from ...base.particles import Student, tempered
from .bends import Bends
from .unknowns import Floats, Unknown, Values, Whole

PROPOSED = 8192  # points drawn about the mode, a power of two
PARTICLES = 2048
_MANY = 256  # residuals: with so many an eighth of the points is enough
ENOUGH = 300.0  # independent draws
_STEP = 1e-5  # of an unknown, for slopes
_SCALE = 0.1  # of a friction: its step is of that, at least
_ROUNDS = 30  # of blocks that are linear about a point; most need 5, pushes that slip 8 to 15
_AT_ONCE = 2**15  # residuals: as many as the processor's own memory holds
_SETTLED = 1e-2  # standard deviations of a step: the next one is the square of that
_BEYOND = 0.25  # so much counts a draw with a friction below 0, for intervals of the others
_NOTHING = 1e-6  # of a friction's standard deviation
_EVALUATIONS = 200  # of the residuals, until the solver gives up


class Block(Protocol):
    """The readings of one kind."""

    @property
    def bends(self) -> Bends:
        """Return how the robot was bent in them."""
        ...

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return the unknowns that these readings depend on."""
        ...

    @property
    def numbers(self) -> Whole:
        """Return the number of the reading that each residual belongs to."""
        ...

    def residuals(self, values: Values) -> Floats:
        """Return the residuals (K, rows) at K values of each unknown."""
        ...

    def nuisances(self, values: Values) -> dict[str, Floats]:
        """Return what the readings share by the name that a fit gives it, in its unit."""
        ...

    @property
    def pool(self) -> tuple[tuple[str, ...], Floats]:
        """Return unknowns that are not normal before the readings, and draws of them, (N, names).

        Mean and covariance of the draws are those of a standard normal distribution.
        """
        ...

    def near(self, values: Values) -> Block:
        """Return the block made linear about a point, where it is; else itself."""
        ...


@dataclass(frozen=True)
class Mode:
    """The likeliest values x (D,), and residuals and their slopes there.

    Rows of a reading that is left out are 0.
    """

    posterior: Posterior
    x: Floats
    residuals: Floats
    slopes: Floats

    @property
    def chi2(self) -> float:
        """Return the sum of squares."""
        return float(self.residuals @ self.residuals)

    @cached_property
    def information(self) -> Floats:
        """Return the normal matrix (D, D)."""
        return np.asarray(self.slopes.T @ self.slopes)

    @cached_property
    def covariance(self) -> Floats:
        """Return the inverse of the information; raises NotConverged where it has none."""
        covariance = _inverse(self.information)
        if covariance is None:
            raise NotConverged("the readings contradict each other so far that no friction is told")
        return covariance

    @property
    def values(self) -> dict[str, Floats]:
        """Return (1,) of each unknown."""
        return self.posterior.by_name(self.x[None])

    def without(self, rows: NDArray[np.bool_]) -> tuple[float, Floats] | None:
        """Return chi2 and the unknowns' shift with some rows left out, by one linear step.

        None where the others leave an unknown open.
        """
        slopes, off = self.slopes[rows], self.residuals[rows]
        covariance = _inverse(self.information - slopes.T @ slopes)
        if covariance is None:
            return None
        pull = slopes.T @ off
        return self.chi2 - float(off @ off + pull @ covariance @ pull), covariance @ pull


@dataclass(frozen=True)
class Draws:
    """Draws x (N, D) of the unknowns with their weights (N,), which sum to 1.

    boundless: their weights if nothing had a limit; that of a draw beyond one is 0 otherwise.
    """

    posterior: Posterior
    x: Floats
    weight: Floats
    boundless: Floats

    @cached_property
    def values(self) -> dict[str, Floats]:
        """Return (N,) of each unknown."""
        return self.posterior.by_name(self.x)

    def weight_for(self, friction: int) -> Floats:
        """Return the weights (N,) by which an interval of one friction counts the draws.

        Without those in which another friction is below 0, intervals were too narrow in sessions
        where that friction is 0; with all of them, too wide.
        """
        below = self.x[:, : self.posterior.frictions] < 0.0
        others = np.delete(below, friction, axis=1).any(axis=1)
        weight = self.boundless * np.where(others, _BEYOND, 1.0) * ~below[:, friction]
        return np.asarray(weight / weight.sum())

    def alike(self, count: int) -> Draws:
        """Return draws of which each is as likely as any other."""
        steps = (np.arange(count) + 0.5) / count
        rows = np.minimum(np.searchsorted(np.cumsum(self.weight), steps), len(self.x) - 1)
        even = np.full(count, 1.0 / count)
        return replace(self, x=self.x[rows], weight=even, boundless=even)


@dataclass(frozen=True)
class Posterior:
    """What some blocks of readings and the priors say together."""

    blocks: tuple[Block, ...]

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return every unknown once, the frictions first."""
        named = {u.name: u for block in self.blocks for u in block.unknowns}
        return tuple(sorted(named.values(), key=lambda u: not u.friction))

    @property
    def names(self) -> tuple[str, ...]:
        """Return the unknowns' names."""
        return tuple(u.name for u in self.unknowns)

    @property
    def frictions(self) -> int:
        """Return how many of the unknowns are frictions."""
        return sum(u.friction for u in self.unknowns)

    @property
    def low(self) -> Floats:
        """Return the least value of each unknown."""
        return np.array([0.0 if u.friction else u.low for u in self.unknowns])

    @cached_property
    def numbers(self) -> Whole:
        """Return the reading that each row belongs to; -1 for a prior."""
        priors = np.full(len(self.unknowns) - self.frictions, -1)
        return np.concatenate([*(block.numbers for block in self.blocks), priors])

    @property
    def rows(self) -> int:
        """Return how many residuals are the blocks': those of priors come after them."""
        return len(self.numbers) - len(self.unknowns) + self.frictions

    def nuisances(self, values: Values) -> dict[str, Floats]:
        """Return what readings share by the name that a fit gives it, in its unit."""
        return {
            name: part for block in self.blocks for name, part in block.nuisances(values).items()
        }

    def by_name(self, x: Floats) -> dict[str, Floats]:
        """Return values (K, D) by the unknowns' names."""
        return dict(zip(self.names, x.T, strict=True))

    def residuals(self, x: Floats) -> Floats:
        """Return the residuals (K, rows) at points (K, D): the blocks', then the priors'."""
        values = self.by_name(x)
        parts = [block.residuals(values) for block in self.blocks]
        return np.concatenate([*parts, x[:, self.frictions :]], axis=1)

    def slopes(self, x: Floats) -> Floats:
        """Return the residuals' slopes (rows, D) at a point (D,), by central differences."""
        step = _STEP * np.maximum(
            np.abs(x), np.where(np.arange(len(x)) < self.frictions, _SCALE, 1.0)
        )
        ends = self.residuals(np.concatenate([x + np.diag(step), x - np.diag(step)]))
        return np.asarray((ends[: len(x)] - ends[len(x) :]).T / (2 * step))

    def at(self, x: Floats, weight: Floats | float = 1.0) -> Mode:
        """Return residuals and slopes at a point (D,); weight: of each row."""
        root = np.sqrt(np.broadcast_to(weight, self.numbers.shape))
        return Mode(self, x, root * self.residuals(x[None])[0], root[:, None] * self.slopes(x))

    def near(self, x: Floats) -> Posterior:
        """Return the posterior with its blocks made linear about a point (D,), where they are."""
        values = self.by_name(x[None])
        return replace(self, blocks=tuple(block.near(values) for block in self.blocks))

    def start(self, frictions: Floats) -> Floats:
        """Return a point (D,) with these frictions and all else as it was before the readings."""
        return np.append(frictions, np.zeros(len(self.unknowns) - self.frictions))

    def mode(self, start: Floats, weight: Floats | float = 1.0) -> Mode:
        """Return the likeliest values, from a start (D,). Raises NotConverged.

        weight: of each row; a row of weight 0 does not count. Blocks that are linear about a point
        are made so about the answer.
        """
        posterior, x = self.near(start), start
        for _ in range(_ROUNDS):
            before, x = x, posterior._minimum(x, weight)
            linear, posterior = posterior, posterior.near(x)
            moved = np.abs(x - before) * np.linalg.norm(posterior.slopes(x), axis=0)
            if posterior.blocks == linear.blocks or moved.max() < _SETTLED:
                return posterior.at(posterior._at_limit(x), weight)
        raise NotConverged("the fit came to no end")

    def _minimum(self, start: Floats, weight: Floats | float) -> Floats:
        """Return where the weighted sum of squares is least; raises NotConverged."""
        from scipy.optimize import least_squares

        root = np.sqrt(np.broadcast_to(weight, self.numbers.shape))
        solved = least_squares(
            lambda x: root * self.residuals(x[None])[0],
            np.maximum(start, self.low + 1e-9),
            jac=lambda x: root[:, None] * self.slopes(x),  # pyright: ignore[reportArgumentType]
            bounds=(self.low, np.inf),
            x_scale="jac",
            **dict.fromkeys(("xtol", "ftol", "gtol"), 1e-12),
            max_nfev=_EVALUATIONS,
        )
        if not solved.success:
            raise NotConverged("the readings contradict each other")
        return np.asarray(solved.x)

    def _at_limit(self, x: Floats) -> Floats:
        """Return frictions as 0 that the solver left just inside their limit."""
        size = np.linalg.norm(self.slopes(x), axis=0)  # over 1: an unknown's sigma alone
        nothing = (np.arange(len(x)) < self.frictions) & (x * size < _NOTHING)
        return np.where(nothing, 0.0, x)

    def draws(self, mode: Mode, seed: int = 2005) -> Draws:
        """Return weighted draws: about the mode, or tempered particles where those are too few."""
        root = np.asarray(np.linalg.cholesky(mode.covariance), dtype=np.float64)
        about = Student(mode.x, root)
        x = about.points(PROPOSED if len(self.numbers) < _MANY else PROPOSED // 8, seed)
        log = self.log_density(x) - about.log_density(x)
        x = self._by_pools(mode, x, seed)
        weight, boundless = (
            _shares(np.where((x >= self.low).all(axis=1), log, -np.inf)),
            _shares(log),
        )
        if ENOUGH * np.sum(weight**2) <= 1.0:
            enough = ENOUGH * np.sum(boundless**2) <= 1.0
            return Draws(self, x, weight, boundless if enough else weight)
        return self._tempered(about, seed)

    def _by_pools(self, mode: Mode, x: Floats, seed: int) -> Floats:
        """Return points (K, D) in which the errors of a block's pool are those of it, not normal.

        To first order an estimate errs by C e, where e are these errors and C the unknowns'
        covariance with them, and by a part that is independent of e. A point d off the mode has
        e = d_e + n, n of covariance 1 - C_ee: that part of it is replaced.
        """
        rng = np.random.default_rng(seed)
        for names, pool in (block.pool for block in self.blocks):
            if not names:
                continue
            errors = [self.names.index(name) for name in names]
            gain = mode.covariance[:, errors]
            values, vectors = np.linalg.eigh(np.eye(len(errors)) - gain[errors])
            noise = rng.normal(size=(len(x), len(errors))) * np.sqrt(np.maximum(values, 0.0))
            normal = x[:, errors] - mode.x[errors] + noise @ vectors.T
            picked = pool[rng.permutation(len(x)) % len(pool)]
            x = x + (picked - normal) @ gain.T
        return x

    def _tempered(self, about: Student, seed: int) -> Draws:
        """Return draws by particles that begin about the mode, within the limits."""
        x = about.points(4 * PARTICLES, seed)
        inside = (x >= self.low).all(axis=1)
        x = x[inside] if inside.any() else np.maximum(x, self.low)
        x = np.resize(x, (PARTICLES, x.shape[1]))

        def ratio(x: Floats) -> Floats:
            inside = (x >= self.low).all(axis=1)
            log = self.log_density(np.maximum(x, self.low)) - about.log_density(x)
            return np.where(inside, log, -np.inf)

        x, _ = tempered(x, about.log_density, ratio, np.random.default_rng(seed))
        even = np.full(len(x), 1.0 / len(x))
        return Draws(self, x, even, even)

    def log_density(self, x: Floats) -> Floats:
        """Return its logarithm at points (K, D), but for a constant and limits.

        It is no number where a law has no value, beyond the limits.
        """
        pieces = max(len(x) * len(self.numbers) // _AT_ONCE, 1)
        with np.errstate(invalid="ignore", over="ignore"):
            return np.concatenate([self._log_density(x) for x in np.array_split(x, pieces)])

    def _log_density(self, x: Floats) -> Floats:
        return np.asarray(-0.5 * np.sum(self.residuals(x) ** 2, axis=1))


def _shares(log: Floats) -> Floats:
    """Return weights that sum to 1 from their logarithms; all in one where none is finite."""
    weight = np.exp(log - log.max()) if np.isfinite(log.max()) else np.eye(1, len(log))[0]
    return np.asarray(weight / weight.sum())


def _inverse(information: Floats) -> Floats | None:
    """Return the inverse; None where rounding errors are all that is left of it.

    A minimum far out, where a friction is 0 and a reading's whole error with it, has slopes of
    1e12 beside others of 1.
    """
    diagonal = np.diag(information)
    if not np.isfinite(information).all() or diagonal.min(initial=1.0) <= 0.0:
        return None
    scale = np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    if not values[0] > len(scale) * np.finfo(float).eps * values[-1]:
        return None
    return np.asarray((vectors / values) @ vectors.T / np.outer(scale, scale))
