"""Test whether measured speeds agree with predicted ones, and find factors that explain them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..base.vectors import Array
from ..friction.result import FrictionFit
from ..model.drives import ServoKind
from ..model.gait import Gait
from .speeds import Samples, speeds

# Relative sigma of a predicted speed: constant errors of joints of 0.5 deg cost 0 to 3 % of it in
# the virtual lab, and neighbouring samples of servos and slopes differ by some 1 %.
MODEL_SIGMA = 0.01


@dataclass(frozen=True)
class Factor:
    """The factor that would explain the measured speeds best, and the p-value with it."""

    factor: float
    p_value: float


@dataclass(frozen=True)
class Predicted:
    """Predicted and measured speeds of the judged gaits.

    joints_m_s: (samples, gaits), of ideal joints on level ground. servo_shares: (samples, gaits),
    of these speeds that each sample's servo leaves. slope_shares: (slopes, gaits), that a floor of
    unknown slope leaves; ones on level ground. measured_m_s, sigma_m_s: (gaits,).
    """

    joints_m_s: Array
    servo_shares: Array
    slope_shares: Array
    measured_m_s: Array
    sigma_m_s: Array

    def p_value(self, seed: int) -> float:
        """Return how often a sample with measuring errors is as unlikely as what was measured.

        How often is counted among the samples themselves, since they are skewed. Each is scored
        without its own servo and slope: those of the real robot are not among the samples either.
        """
        rng = np.random.default_rng(seed)
        moved = rng.choice(self.joints_m_s, len(self.slope_shares)) * self._shares
        simulated = rng.normal(moved, np.hypot(self.sigma_m_s, MODEL_SIGMA * moved))
        servo = np.arange(len(moved)) % len(self.servo_shares)
        scores = self._log_density(simulated, servo[:, None] == servo)
        return float(np.mean(scores <= self.log_density))

    @property
    def log_density(self) -> float:
        """Return the log density at the measured speeds, up to a constant."""
        return float(self._log_density(self.measured_m_s[None])[0])

    @property
    def _shares(self) -> Array:
        """Return what servo and slope leave of the speeds, (slopes, gaits): each has a servo."""
        return self.slope_shares * np.resize(self.servo_shares, self.slope_shares.shape)

    def _log_density(self, speeds: Array, omitted: NDArray[np.bool_] | None = None) -> Array:
        """Return it at speeds (K, gaits): a normal distribution about each servo and slope.

        It is the density of the speeds' logarithms, so that a speed which is a share too low is as
        unlikely as one that is a share too high. omitted: (K, slopes), which are left out.
        """
        spread = np.cov(self.joints_m_s.T).reshape(2 * self.sigma_m_s.shape)
        shares = self._shares
        centre = shares * self.joints_m_s.mean(axis=0)
        noise = self.sigma_m_s**2 + (MODEL_SIGMA * centre) ** 2
        covariance = shares[:, :, None] * spread * shares[:, None, :]
        covariance += noise[:, None] * np.eye(len(spread))
        root = np.linalg.cholesky(np.linalg.inv(covariance))
        log_volume = np.linalg.slogdet(covariance)[1]
        differences = (speeds - centre[:, None]) @ root  # (slopes, K, gaits)
        log = -0.5 * (np.sum(differences**2, axis=2).T + log_volume)
        log += np.log(np.maximum(speeds, 1e-9)).sum(axis=1, keepdims=True)
        if omitted is not None:
            log[omitted] = -np.inf
        return np.asarray(np.logaddexp.reduce(log, axis=1) - np.log(np.isfinite(log).sum(axis=1)))


def best_factors(
    predicted: Predicted,
    fit: FrictionFit,
    gaits: Sequence[tuple[Gait, Gait | None]],
    kind: ServoKind | None,
    seed: int,
) -> tuple[Factor, Factor]:
    """Return the factors on all friction, and on the amplitude, that explain the speeds best.

    gaits: each with its command where a film showed the joints, whose amplitude is then certain.
    What a factor does to a speed is solved for with the fitted friction and the typical servo,
    roughly: ratios of rough speeds are known to less than MODEL_SIGMA.
    """
    count, ones = 8, np.ones(8)
    factors = np.geomspace(0.4, 2.5, count), np.linspace(0.5, 1.3, count)
    friction = np.concatenate([[1.0], factors[0], ones])
    amplitude = np.concatenate([[1.0], ones, factors[1]])
    servos = (kind.servo,) * len(friction) if kind else ()
    samples = Samples(fit, kind, np.outer(friction, fit.values), amplitude, servos)
    rows_m_s = [speeds(samples, gait, commanded, 0)[2] for gait, commanded in gaits]
    shares = np.array([row[1:] / max(row[0], 1e-9) for row in rows_m_s])
    return (
        _best(predicted, factors[0], shares[:, :count], seed),
        _best(predicted, factors[1], shares[:, count:], seed),
    )


def _best(predicted: Predicted, factors: Array, shares: Array, seed: int) -> Factor:
    """Return the factor of highest density; shares: (gaits, factors), ratios of the speeds."""
    tried = np.linspace(factors[0], factors[-1], 97)
    by_factor = np.stack([np.interp(tried, factors, row) for row in shares], axis=1)
    joints = predicted.joints_m_s
    changed = [replace(predicted, joints_m_s=joints * share) for share in by_factor]
    best = int(np.argmax([candidate.log_density for candidate in changed]))
    return Factor(float(tried[best]), changed[best].p_value(seed))
