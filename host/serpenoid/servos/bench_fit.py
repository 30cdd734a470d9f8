"""Fit a servo's parameters to a bench test, and test whether the model describes it.

MAP estimates come from least squares with several starts, for each control rate that servos of the
kind may have, and for a continuous loop. The intervals come from samples about each estimate. If
the model does not describe the table, the noise is increased to the size of the residuals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ..base.errors import BadInput
from ..base.maxima import Maximum, log_density, maxima
from ..base.particles import explored
from ..base.vectors import Array
from ..model.drives import ServoKind
from .bench_test import BenchModel, BenchTest, Prior, Values

MIN_P_VALUE = 0.01  # p-value below which the model does not describe the table.
FAR_SIGMAS = 3.0  # Distance from the prior, in its sigmas, beyond which a value is unusual.


@dataclass(frozen=True)
class FitTuning:
    """Numbers of the fit; `studies/bench_tests.py` measures the coverage of its intervals.

    drawn_starts: number of sampled servos; least squares start from the best_starts best of them.
    population, moves: number of samples that the ensemble sampler moves, and of its moves; with
    half as many, the tails of friction and dead band are too short. samples: number of samples
    behind the intervals. servo_count: number of servos in a file. max_sigma_ratio: largest
    posterior sigma of a determined parameter, over that of the prior.
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
    """A parameter's median, its 95 % interval, and its sigma in the prior and with the test.

    Both sigmas are of the logarithm if the parameter is always positive.
    """

    value: float
    low: float
    high: float
    prior_sigma: float
    sigma: float


class Verdict(NamedTuple):
    """The test of the model against a table.

    p_value: probability of residuals at least as large if the model holds. worst_s, worst_rad: mean
    time and mean residual of the worst block of rows. variance_ratio: variance of the residuals
    over that of the noise, at least 1.
    """

    p_value: float
    worst_s: float
    worst_rad: float
    variance_ratio: float

    @property
    def describes(self) -> bool:
        """Return whether the model describes the table."""
        return self.p_value >= MIN_P_VALUE


@dataclass(frozen=True)
class MeasuredServo:
    """The servo that a bench test has measured.

    kind: the kind of servo with samples of the posterior. values: the parameters by name. outside:
    distance from the prior in its sigmas, of parameters that are unusual for the kind.
    """

    kind: ServoKind
    values: dict[str, Measured]
    verdict: Verdict
    outside: dict[str, float]

    @property
    def determined(self) -> dict[str, Measured]:
        """Return the parameters that the test determines, by name."""
        return {
            name: value
            for name, value in self.values.items()
            if value.sigma < TUNING.max_sigma_ratio * value.prior_sigma
        }

    @property
    def open(self) -> list[str]:
        """Return the names of the parameters that the test does not determine."""
        return [name for name in self.values if name not in self.determined]


Fit = tuple[BenchModel, list[Maximum]]  # A model, and the maxima of its posterior in order.


def _searched(model: BenchModel, continuous: Fit | None, rng: np.random.Generator) -> Fit:
    """Return the fit of a model by least squares from the best of many sampled servos.

    continuous: the fit of a continuous loop. If it is given, the starts have its zero, gain and
    delays, the latter with a random wait for the sampled loop's next sample.
    """
    # The starts scatter by 1.5 standard deviations of the priors.
    starts = 1.5 * rng.normal(size=(TUNING.drawn_starts, model.size))
    first_step = len(model.names)
    starts[:, first_step:] = 0.0
    if continuous is not None:
        continuous_model, (peak, *_) = continuous
        x = peak.x
        names = "zero_rad", "gain", "start_rad", "delay_s"
        shared = [model.names.index(name) for name in names]
        starts[:, shared] = x[shared]
        starts[:, shared[-1]] -= 0.5 * model.period_s / model.priors["delay_s"].sigma
        waits_s = model.period_s * rng.uniform(-0.5, 0.5, (len(starts), model.steps))
        delays_s = continuous_model.step_delays_s(x) + waits_s
        starts[:, first_step:] = delays_s / model.step_sigma_s
    misfit = np.sum(model.residuals(starts) ** 2, axis=1)
    best = np.argsort(misfit)[: TUNING.best_starts]
    return model, maxima(model.residuals, starts[best])


def _verdict(
    model: BenchModel, best: Maximum, block_rows: int = 8, min_freedom: int = 5
) -> Verdict:
    """Test whether the residuals are as small as the noise, and independent.

    One test compares the sum of squares with the stated noise. The other, an analysis of variance,
    compares means over blocks of rows with the scatter within blocks. The two are independent, so
    the probability that the smaller p-value is at most p is 1 - (1 - p)^2. block_rows: rows of a
    block. min_freedom: fewest blocks beyond the parameters for the second test.
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
    worst, smallest = int(np.argmax(np.abs(means))), min(*p_values, 1 - 1e-15)
    return Verdict(
        -math.expm1(len(p_values) * math.log1p(-smallest)),
        float(np.array_split(test.t_s, len(blocks))[worst].mean()),
        float(blocks[worst].mean()) * model.noise_rad,
        ratio,
    )


def servo_of_test(test: BenchTest, like: ServoKind, *, name: str = "measured") -> MeasuredServo:
    """Return the servo that a test of one joint has measured.

    like: the kind of servo whose uncertainty is the prior. name: name of the measured kind. Raises
    BadInput if the kind has no uncertainty.
    """
    if like.exact or like.drawn:
        raise BadInput(
            f"servo {like.name!r} has no uncertainty to fit; take `hobby`, or a data sheet's"
        )
    rng = np.random.default_rng(0)
    fits = [_searched(BenchModel(test, like, 0.0), None, rng)]
    rates_hz = {*(like.updates_hz or (like.servo.update_hz,))}
    for update_hz in sorted(rates_hz - {0.0}):
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
    servos = []
    for (model, _), values in zip(parts, samples, strict=True):
        servos += model.servos(values, rng)
    drawn = tuple(servos[k] for k in rng.permutation(len(servos))[: TUNING.servo_count])
    estimate = best_model.values(best_peaks[0].x[None])
    (typical,) = best_model.servos(estimate, rng)
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
    """Return samples (K, P) of the posterior for each control rate, K in proportion to its mass."""
    masses = np.array([max(peak.log_mass for peak in peaks) for _, peaks in fits])
    shares = np.exp(masses - masses.max())
    counts = np.round(TUNING.samples * shares / shares.sum()).astype(int).tolist()
    parts = []
    for (model, peaks), count in zip(fits, counts, strict=True):
        if count:
            weights = np.exp([peak.log_mass - masses.max() for peak in peaks])
            chosen = rng.choice(len(peaks), TUNING.population, p=weights / weights.sum())
            normal = rng.normal(size=(len(chosen), model.size))
            pairs = zip([peaks[k] for k in chosen], normal, strict=True)
            x = np.array([peak.x + peak.root @ row for peak, row in pairs])
            density = partial(log_density, model.residuals)
            x = np.concatenate(explored(x, density, TUNING.moves, rng))
            parts.append((model, x[rng.permutation(len(x))[:count]]))
    return parts


def _measured(name: str, prior: Prior, samples: list[Values]) -> Measured:
    """Return a parameter with its interval and sigma, from samples by name for each fit."""
    values = np.concatenate([part[name] for part in samples])
    middle, low, high = np.quantile(values, (0.5, 0.025, 0.975)).tolist()
    spread = np.log(np.abs(values)) if prior.logarithmic else values
    return Measured(middle, low, high, prior.sigma, float(spread.std()))
