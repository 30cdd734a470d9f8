"""How speeds change with friction, by a regression of sampled speeds, and the band that follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...model.errors import BadInput
from ...model.gait import Gait
from ..fitting.unknowns import Floats
from ..friction_result import FrictionFit
from ..speed_samples import AMPLITUDE_SIGMA, Progress, sample_speeds

_Z95 = 1.959964


@dataclass(frozen=True)
class SpeedSlopes:
    """Speeds of the gaits that matter: (gaits,) values, (gaits, P) change by friction."""

    gaits: tuple[Gait, ...]
    speed_m_s: Floats
    slope: Floats

    def band(self, covariance: Floats, ran: Sequence[Sequence[float]] = ()) -> float:
        """Return the relative half-width of the 95 % band, mean over the gaits.

        ran: per gait, the standard deviations of its runs' speeds. Each tells its own speed, but
        for the joints' amplitude, which runs of one gait share.
        """
        of = self.slope.shape[1]
        friction = covariance[:of, :of]
        for slope, v, sigmas in zip(
            self.slope, self.speed_m_s, ran or [()] * len(self.slope), strict=True
        ):
            if len(sigmas):
                noise = 1.0 / np.sum(np.asarray(sigmas) ** -2.0) + (AMPLITUDE_SIGMA * v) ** 2
                gain = friction @ slope
                friction = friction - np.outer(gain, gain) / (slope @ gain + noise)
        sigma = np.sqrt(np.einsum("gi,ij,gj->g", self.slope, friction, self.slope))
        return float(np.mean(_Z95 * sigma / self.speed_m_s))


def speed_slopes(
    fit: FrictionFit, gaits: Sequence[Gait], samples: int, progress: Progress | None = None
) -> SpeedSlopes:
    """Regress sampled speeds on sampled frictions; raises BadInput for a gait that goes nowhere."""
    drawn = sample_speeds(fit, gaits, count=samples, progress=progress)
    mean = drawn.friction_m_s.mean(axis=0)
    if mean.min() <= 0.0:
        raise BadInput("one of the gaits does not move at all; choose a larger amplitude")
    centred = drawn.whole - drawn.whole.mean(axis=0)
    # a little of the fit's own covariance keeps frictions known all but exactly in their place
    ridge = 1e-6 * len(centred) * np.diag(np.diag(fit.covariance))
    slope = np.linalg.solve(centred.T @ centred + ridge, centred.T @ (drawn.friction_m_s - mean))
    return SpeedSlopes(tuple(gaits), mean, slope.T)
