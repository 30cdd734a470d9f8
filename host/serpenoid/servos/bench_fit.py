"""The fit of a bench test: whether the model describes the table, and which servos it leaves.

The likeliest parameters come by least squares from several starts, for each rate that a loop of the
kind may have, and for a continuous loop. Samples about each maximum have the intervals. Where the
model does not describe the table, the noise is taken as large as what is left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ..base.errors import BadInput
from ..base.maxima import LOG_DENSITY_RANGE, Maximum, log_density, maxima
from ..base.particles import about_a_maximum
from ..model.drives import ServoKind
from .bench_test import UNREPORTED, Array, BenchModel, BenchTest, Values

# With 100 moves of each sample the tails of friction and dead band were too short.
SAMPLES, MOVES, KEPT = 256, 250, 128
DRAWN_STARTS, BEST_STARTS = 1024, 8  # servos drawn; least squares start from the best of them
START_SIGMAS = 1.5  # width of what starts are drawn from, in standard deviations of the priors
MIN_P_VALUE = 0.01  # below it the model does not describe the table
BLOCK_ROWS, MIN_BLOCKS = 8, 5  # rows whose mean residual is tested; blocks beyond the parameters
MAX_SIGMA_RATIO = 0.6  # of the prior's sigma: a value that keeps more is open
FAR_SIGMAS = 3.0  # standard deviations of the prior: values beyond are named


class Measured(NamedTuple):
    """The median of a value, its 95 % interval, and its standard deviation without and with a test.

    Standard deviations are those of the logarithm; of a value that may be 0 or below, its own.
    """

    value: float
    low: float
    high: float
    prior_sigma: float
    sigma: float

    @property
    def is_determined(self) -> bool:
        """Tell whether the test determines it."""
        return self.sigma < MAX_SIGMA_RATIO * self.prior_sigma


class Verdict(NamedTuple):
    """Whether the model describes a table: p-value, and the rows where residuals are largest.

    variance_ratio: the residuals' variance over that of the noise, at least 1; chi2: over the
    stated noise.
    """

    p_value: float
    worst_s: float
    worst_rad: float
    variance_ratio: float
    chi2: float

    @property
    def describes(self) -> bool:
        """Tell whether the p-value is large enough."""
        return self.p_value >= MIN_P_VALUE


@dataclass(frozen=True)
class MeasuredServo:
    """What a test leaves of a kind of servo.

    values: by name; outside: names of those far from what is usual for the kind, with by how many
    of its standard deviations.
    """

    kind: ServoKind
    values: dict[str, Measured]
    verdict: Verdict
    outside: dict[str, float]

    @property
    def determined(self) -> dict[str, Measured]:
        """Return what the test determines."""
        return {name: one for name, one in self.values.items() if one.is_determined}

    @property
    def open(self) -> list[str]:
        """Return the names of what the test leaves open."""
        return [name for name in self.values if name not in self.determined]


class _Fit(NamedTuple):
    """A model, the noise that its residuals are measured by, and maxima of its posterior."""

    model: BenchModel
    noise_rad: float
    maxima: list[Maximum]

    def residuals(self, x: Array) -> Array:
        """Return (K, T) what the model has above the table, over the noise."""
        return (self.model.angles(x) - self.model.test.angle_rad) / self.noise_rad

    def improved(self, starts: Array) -> _Fit:
        """Return the fit with the maxima that least squares reach from starts."""
        return self._replace(maxima=maxima(self.residuals, starts))

    @property
    def log_density(self) -> float:
        """Return the logarithm of the highest density."""
        return self.maxima[0].log_density


def _searched(fit: _Fit, continuous: _Fit | None, rng: np.random.Generator) -> _Fit:
    """Return the fit of a model from the best of many servos that are drawn.

    continuous: the fit of a continuous loop, whose zero, gain and delays the drawn ones have.
    """
    from scipy.special import ndtri
    from scipy.stats import qmc

    model = fit.model
    even = qmc.Sobol(model.size, seed=rng).random(DRAWN_STARTS)  # pyright: ignore[reportCallIssue] (older SciPy)
    starts = START_SIGMAS * ndtri(np.clip(even, 1e-9, 1 - 1e-9))
    first_step = len(model.names)
    starts[:, first_step:] = 0.0
    if continuous is not None:
        x = continuous.maxima[0].x
        delay = model.names.index("delay_s")
        for column in (model.names.index(name) for name in ("zero_rad", "gain", "start_rad")):
            starts[:, column] = x[column]
        starts[:, delay] = x[delay] - 0.5 * model.period_s / model.priors["delay_s"].sigma
        ratio = continuous.model.step_sigma_s / model.step_sigma_s
        starts[:, first_step:] = ratio * x[first_step:]
    misfit = np.sum(fit.residuals(starts) ** 2, axis=1)
    return fit.improved(starts[np.argsort(misfit)[:BEST_STARTS]])


def _verdict(fit: _Fit) -> Verdict:
    """Return whether residuals are as large as the noise, and have no pattern.

    Two tests: the sum of squares over the noise that was stated; and means of neighbouring rows,
    which scatter as their rows do if errors of rows are independent. The two are independent, so
    that the smaller one of their p-values p occurs by chance with 1 - (1 - p)^2.
    """
    from scipy.special import chdtrc, fdtrc

    test, best = fit.model.test, fit.maxima[0]
    residual = -fit.residuals(best.x[None])[0]
    chi2 = float(np.sum(residual**2))
    freedom = max(residual.size - best.determined, 1.0)
    blocks = np.array_split(residual, max(residual.size // BLOCK_ROWS, 1))
    means = np.array([block.mean() * math.sqrt(block.size) for block in blocks])
    between_freedom = len(blocks) - best.determined
    within_freedom = residual.size - len(blocks)
    p_values, ratio = [], max(chi2 / freedom, 1.0)
    if between_freedom >= MIN_BLOCKS:
        floor = (test.resolution_rad / fit.noise_rad) ** 2 / 12
        within = max((chi2 - float(means @ means)) / within_freedom, floor, 1e-18)
        between = float(means @ means) / between_freedom
        p_values.append(float(fdtrc(between_freedom, within_freedom, between / within)))
        ratio = max(ratio, between)
    if test.sigma_rad is not None or not p_values:
        p_values.append(float(chdtrc(freedom, chi2)))
    worst = int(np.argmax(np.abs(means)))
    row = sum(block.size for block in blocks[:worst]) + blocks[worst].size // 2
    return Verdict(
        -math.expm1(len(p_values) * math.log1p(-min(*p_values, 1 - 1e-15))),
        float(test.t_s[row]),
        float(blocks[worst].mean()) * fit.noise_rad,
        ratio,
        chi2,
    )


def servo_of_test(
    test: BenchTest, like: ServoKind, *, name: str = "measured", seed: int = 0
) -> MeasuredServo:
    """Return what a test of one joint leaves of a kind of servo. Raises BadInput."""
    if like.exact or like.drawn:
        raise BadInput(
            f"servo {like.name!r} has no uncertainty to fit; take `hobby`, or a data sheet's"
        )
    rng = np.random.default_rng(seed)
    continuous = _searched(_Fit(BenchModel(test, like, 0.0), test.noise_rad, []), None, rng)
    fits = [continuous]
    for update_hz in sorted({*(like.updates_hz or (like.servo.update_hz,))} - {0.0}):
        fit = _Fit(BenchModel(test, like, update_hz), test.noise_rad, [])
        fits.append(_searched(fit, continuous, rng))
    best = max(fits, key=lambda fit: fit.log_density)
    verdict = _verdict(best)
    if not verdict.describes:
        noise_rad = test.noise_rad * math.sqrt(verdict.variance_ratio)
        fits = [
            fit._replace(noise_rad=noise_rad).improved(np.array([one.x for one in fit.maxima]))
            for fit in fits
        ]
        best = max(fits, key=lambda fit: fit.log_density)
    parts = _sampled(fits, best.log_density, rng)
    kept = [servo for fit, x in parts for servo in fit.model.servos(fit.model.samples(x, rng), rng)]
    kept = [kept[k] for k in rng.permutation(len(kept))[:KEPT]]
    typical = best.model.servos(best.model.values(best.maxima[0].x[None]), rng)[0]
    source = f"a bench test of one joint, from {like.name}"
    kind = ServoKind(name, typical, {}, (), source, tuple(kept))
    return MeasuredServo(kind, _measured(parts, rng), verdict, _outside(parts))


def _sampled(
    fits: list[_Fit], highest: float, rng: np.random.Generator
) -> list[tuple[_Fit, Array]]:
    """Return samples (K, P) about each maximum of the fits, by the mass about it."""
    pairs = [
        (fit, one)
        for fit in fits
        for one in fit.maxima
        if one.log_density > highest - LOG_DENSITY_RANGE
    ]
    masses = np.array([one.log_mass for _, one in pairs])
    share = np.cumsum(np.exp(masses - masses.max()))
    counts = np.diff(np.round(SAMPLES * share / share[-1]), prepend=0.0).astype(int)
    parts = []
    for (fit, one), count in zip(pairs, counts.tolist(), strict=True):
        if count:
            density = partial(log_density, fit.residuals)
            seed = int(rng.integers(2**31))
            parts.append((fit, about_a_maximum(one.x, one.root, density, count, MOVES, seed)))
    return parts


def _measured(parts: list[tuple[_Fit, Array]], rng: np.random.Generator) -> dict[str, Measured]:
    """Return the values with their intervals, and what was known of them without the test."""
    samples: list[Values] = [fit.model.samples(x, rng) for fit, x in parts]
    model = parts[0][0].model
    measured = {}
    for name in model.names:
        if name in UNREPORTED:
            continue
        prior = model.priors[name]
        values = np.concatenate([part[name] for part in samples])
        middle, low, high = np.quantile(values, (0.5, 0.025, 0.975)).tolist()
        spread = np.log(np.abs(values)) if prior.logarithmic else values
        measured[name] = Measured(middle, low, high, prior.sigma, float(spread.std()))
    return measured


def _outside(parts: list[tuple[_Fit, Array]]) -> dict[str, float]:
    """Return the parameters that lie far from what is usual, and by how many sigma."""
    fit, x = max(parts, key=lambda part: len(part[1]))
    names = [*fit.model.names, *(f"step {k}" for k in range(fit.model.steps))]
    middle = np.median(x, axis=0).tolist()
    return {name: off for name, off in zip(names, middle, strict=True) if abs(off) > FAR_SIGMAS}
