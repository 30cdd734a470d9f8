"""The fit of a bench test: whether the model describes the table, and which servos it leaves.

The likeliest parameters come by least squares from several starts, for each rate that a loop of the
kind may have, and for a continuous loop. Samples about each maximum have the intervals. Where the
model does not describe the table, the noise is taken as large as what is left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import NamedTuple

import numpy as np

from ..base.errors import BadInput
from ..base.maxima import Maximum, log_density, maxima
from ..base.particles import explored
from ..model.drives import ServoKind
from .bench_test import Array, BenchModel, BenchTest, Prior, Values

MIN_P_VALUE = 0.01  # a p-value below which the model does not describe the table
FAR_SIGMAS = 3.0  # standard deviations of the prior: values beyond are named


@dataclass(frozen=True)
class FitTuning:
    """How a test is fitted; `studies/bench_tests.py` shows what its intervals are worth.

    drawn_starts: servos that are drawn, and best_starts: from which least squares start.
    population: samples that move together, at each rate of the loop; moves: with half as many the
    tails of friction and dead band are too short. samples: of which intervals are made;
    servo_count: servos in a file. max_sigma_ratio: share of the prior's sigma; a value that keeps
    more is open.
    """

    drawn_starts: int = 1024
    best_starts: int = 8
    population: int = 96
    moves: int = 400
    samples: int = 384
    servo_count: int = 128
    max_sigma_ratio: float = 0.6


TUNING = FitTuning()


class Measured(NamedTuple):
    """The median of a value, its 95 % interval, and its standard deviation without and with a test.

    Standard deviations are those of the logarithm; of a value that may be 0 or below, its own.
    """

    value: float
    low: float
    high: float
    prior_sigma: float
    sigma: float


class Verdict(NamedTuple):
    """Whether the model describes a table: p-value, and the rows where residuals are largest.

    variance_ratio: the residuals' variance over that of the noise, at least 1.
    """

    p_value: float
    worst_s: float
    worst_rad: float
    variance_ratio: float

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
        """Return what the test determines: values whose sigma is below that of the prior."""
        return {
            name: value
            for name, value in self.values.items()
            if value.sigma < TUNING.max_sigma_ratio * value.prior_sigma
        }

    @property
    def open(self) -> list[str]:
        """Return the names of what the test leaves open."""
        return [name for name in self.values if name not in self.determined]


Fit = tuple[BenchModel, list[Maximum]]  # the maxima of its posterior, the highest first


def _searched(model: BenchModel, continuous: Fit | None, rng: np.random.Generator) -> Fit:
    """Return the fit of a model from the best of many servos that are drawn.

    continuous: the fit of a continuous loop, whose zero, gain and delays the drawn ones have. Each
    step of a sampled loop waits for a sample, up to a period longer or shorter.
    """
    # Starts are drawn from 1.5 standard deviations of the priors.
    starts = 1.5 * rng.normal(size=(TUNING.drawn_starts, model.size))
    first_step = len(model.names)
    starts[:, first_step:] = 0.0
    if continuous is not None:
        smooth_model, (peak, *_) = continuous
        x = peak.x
        zero, gain, start, delay = map(
            model.names.index, ("zero_rad", "gain", "start_rad", "delay_s")
        )
        starts[:, [zero, gain, start, delay]] = x[[zero, gain, start, delay]]
        starts[:, delay] -= 0.5 * model.period_s / model.priors["delay_s"].sigma
        waits_s = model.period_s * rng.uniform(-0.5, 0.5, (len(starts), model.steps))
        delays_s = smooth_model.step_delays_s(x) + waits_s
        starts[:, first_step:] = delays_s / model.step_sigma_s
    misfit = np.sum(model.residuals(starts) ** 2, axis=1)
    return model, maxima(model.residuals, starts[np.argsort(misfit)[: TUNING.best_starts]])


def _verdict(
    model: BenchModel, best: Maximum, block_rows: int = 8, min_freedom: int = 5
) -> Verdict:
    """Return whether residuals are as large as the noise, and have no pattern.

    Two tests: the sum of squares over the noise that was stated; and means of neighbouring rows,
    which scatter as their rows do if errors of rows are independent. The two are independent, so
    that the smaller one of their p-values p occurs by chance with 1 - (1 - p)^2. block_rows:
    neighbours; min_freedom: blocks beyond the parameters.
    """
    from scipy.special import chdtrc, fdtrc

    test, residual = model.test, -model.residuals(best.x[None])[0]
    chi2, freedom = float(residual @ residual), max(residual.size - best.determined, 1.0)
    blocks = np.array_split(residual, max(residual.size // block_rows, 1))
    means = np.array([block.mean() * math.sqrt(block.size) for block in blocks])
    between_freedom, within_freedom = len(blocks) - best.determined, residual.size - len(blocks)
    p_values, ratio = [], max(chi2 / freedom, 1.0)
    if between_freedom >= min_freedom:
        rounding = max((test.resolution_rad / model.noise_rad) ** 2 / 12, 1e-18)
        within = max((chi2 - float(means @ means)) / within_freedom, rounding)
        between = float(means @ means) / between_freedom
        p_values.append(float(fdtrc(between_freedom, within_freedom, between / within)))
        ratio = max(ratio, between)
    if test.sigma_rad is not None or not p_values:
        p_values.append(float(chdtrc(freedom, chi2)))
    worst = int(np.argmax(np.abs(means)))
    return Verdict(
        -math.expm1(len(p_values) * math.log1p(-min(*p_values, 1 - 1e-15))),
        float(np.array_split(test.t_s, len(blocks))[worst].mean()),
        float(blocks[worst].mean()) * model.noise_rad,
        ratio,
    )


def servo_of_test(test: BenchTest, like: ServoKind, *, name: str = "measured") -> MeasuredServo:
    """Return what a test of one joint leaves of a kind of servo. Raises BadInput."""
    if like.exact or like.drawn:
        raise BadInput(
            f"servo {like.name!r} has no uncertainty to fit; take `hobby`, or a data sheet's"
        )
    rng = np.random.default_rng(0)
    fits = [_searched(BenchModel(test, like, 0.0), None, rng)]
    for update_hz in sorted({*(like.updates_hz or (like.servo.update_hz,))} - {0.0}):
        fits.append(_searched(BenchModel(test, like, update_hz), fits[0], rng))
    best_model, best_peaks = max(fits, key=lambda fit: fit[1][0].log_density)
    verdict = _verdict(best_model, best_peaks[0])
    if not verdict.describes:
        for model, peaks in fits:
            model.noise_rad *= math.sqrt(verdict.variance_ratio)
            peaks[:] = maxima(model.residuals, np.array([peak.x for peak in peaks]))
    parts = _sampled(fits, rng)
    samples = [model.samples(x, rng) for model, x in parts]
    model, x = max(parts, key=lambda part: len(part[1]))
    named = zip(
        [*model.names, *(f"step {k}" for k in range(model.steps))],
        np.median(x, axis=0).tolist(),
        strict=True,
    )
    pairs = zip(parts, samples, strict=True)
    servos = list(chain.from_iterable(model.servos(x, rng) for (model, _), x in pairs))
    drawn = tuple(servos[k] for k in rng.permutation(len(servos))[: TUNING.servo_count])
    (typical,) = best_model.servos(best_model.values(best_peaks[0].x[None]), rng)
    source = f"a bench test of one joint, from {like.name}"
    return MeasuredServo(
        ServoKind(name, typical, {}, (), source, drawn),
        {
            key: _measured(key, model.priors[key], samples)
            for key in model.names
            if model.priors[key].reported
        },
        verdict,
        {key: sigmas for key, sigmas in named if abs(sigmas) > FAR_SIGMAS},
    )


def _sampled(fits: list[Fit], rng: np.random.Generator) -> list[tuple[BenchModel, Array]]:
    """Return samples (K, P) of each fit that counts, as many as its mass says."""
    masses = np.array([max(peak.log_mass for peak in peaks) for _, peaks in fits])
    shares = np.exp(masses - masses.max())
    counts = np.round(TUNING.samples * shares / shares.sum()).astype(int).tolist()
    parts = []
    for (model, peaks), count in zip(fits, counts, strict=True):
        if count:
            weights = np.exp([peak.log_mass - masses.max() for peak in peaks])
            chosen = rng.choice(len(peaks), TUNING.population, p=weights / weights.sum())
            normal = rng.normal(size=(len(chosen), model.size))
            offsets = [peaks[k].root @ row for k, row in zip(chosen, normal, strict=True)]
            x = np.array([peaks[k].x for k in chosen]) + offsets
            density = partial(log_density, model.residuals)
            x = np.concatenate(explored(x, density, TUNING.moves, rng))
            parts.append((model, x[rng.permutation(len(x))[:count]]))
    return parts


def _measured(name: str, prior: Prior, samples: list[Values]) -> Measured:
    """Return a value with its interval, and what was known of it without the test."""
    values = np.concatenate([part[name] for part in samples])
    middle, low, high = np.quantile(values, (0.5, 0.025, 0.975)).tolist()
    spread = np.log(np.abs(values)) if prior.logarithmic else values
    return Measured(middle, low, high, prior.sigma, float(spread.std()))
