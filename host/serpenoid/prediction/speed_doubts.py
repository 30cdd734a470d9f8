"""What makes a speed's interval wide: each doubt by the speed's derivatives, held to draws."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..calibration.fitting.unknowns import Floats
from ..calibration.friction_result import AMPLITUDE, FrictionFit
from ..calibration.speeds import AMPLITUDE_SIGMA, MODEL_SIGMA, SpeedModel
from ..model.gait import Gait
from ..periodic.sensitivities import Sensitivities
from ..periodic.servo_steady import band as speed_interval
from .speed_samples import SpeedBand, drawn_amplitudes

_Z95 = 1.959964
_DRAWS = 64
_STRAIGHT = 0.25  # by which slopes and draws may differ


@dataclass(frozen=True)
class SpeedDoubts:
    """Hold standard deviations of a gait's speed, relative, that a fit leaves.

    each: of every friction alone and of the joints' common amplitude alone, by the derivatives;
    each_drawn: half of the 95 % interval of draws that were solved for, over 1.96. together, drawn:
    the same of all frictions, with their correlations; with_amplitude, drawn_amplitude: with the
    amplitude besides; drawn_servos: with the servos besides, which have no derivatives. model: what
    the model leaves out, which counts with the amplitude where crawls are fitted, else 0.
    """

    each: dict[str, float]
    each_drawn: dict[str, float]
    together: float
    with_amplitude: float
    drawn: float
    drawn_amplitude: float
    drawn_servos: float
    model: float = 0.0

    @property
    def straight(self) -> bool:
        """Tell whether the derivatives hold over the whole doubt: draws say the same."""
        joints = self.each["amplitude"], self.each_drawn["amplitude"]
        friction = self.together, self.drawn
        pairs = friction, np.hypot(friction, joints)
        return all(bool(abs(slopes - draws) <= _STRAIGHT * draws) for slopes, draws in pairs)

    @property
    def shares(self) -> dict[str, float]:
        """Return what friction, amplitude and servos are of the variance, by draws; sum 1."""
        steps = np.diff([0.0, self.drawn**2, self.drawn_amplitude**2, self.drawn_servos**2])
        shares = np.maximum(steps, 0.0) / max(np.maximum(steps, 0.0).sum(), 1e-300)
        return dict(zip(("friction", "amplitude", "servos"), shares.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return asdict(self) | {"shares": self.shares, "straight": self.straight}

    def rows(self) -> list[list[str]]:
        """Return a table: the doubt, the speed's by derivatives, and by draws; largest first."""
        rows = [
            (f"{name} alone", self.each[name], share)
            for name, share in sorted(self.each_drawn.items(), key=lambda part: -part[1])
        ]
        rows += [
            ("all frictions", self.together, self.drawn),
            (f"with {self._joints}", self.with_amplitude, self.drawn_amplitude),
        ]
        lines = [[name, _percent(slopes), _percent(draws)] for name, slopes, draws in rows]
        ideal = self.drawn_servos == self.drawn_amplitude
        return lines if ideal else [*lines, ["with servos", "", _percent(self.drawn_servos)]]

    @property
    def _joints(self) -> str:
        beside = f" and the model's {100 * self.model:.2g} %" if self.model else ""
        return "the joints' amplitude" + beside

    def in_words(self) -> str:
        """Return what makes most of the interval, and whether the derivatives can be believed."""
        first = max(self.shares, key=self.shares.__getitem__)
        named = self._joints if first == "amplitude" else first
        most = f"most of it: {named}, {100 * self.shares[first]:.0f} % of the variance by draws"
        return most + ("" if self.straight else ". Derivatives mislead here: the draws count.")


def _percent(share: float) -> str:
    if share < 1e-6:
        return "0"
    return f"±{100 * share:.0f} %" if share >= 1.0 else f"±{100 * share:.2g} %"


def speed_doubts(
    fit: FrictionFit, gait: Gait, sensitivities: Sensitivities, band: SpeedBand
) -> SpeedDoubts:
    """Return what a fit leaves of the speed of a gait whose derivatives and band were found.

    A friction that has no derivative (it is 0) counts as 0 in the derivatives, not in the draws.
    """
    elasticity = dict(zip(sensitivities.names, sensitivities.elasticities().tolist(), strict=True))
    whole = np.array(list(fit.whole_snake.values()))
    slope = np.array([elasticity.get(name, 0.0) for name in fit.names])
    slope = np.divide(slope, whole, out=np.zeros_like(slope), where=whole > 0.0)
    slope = np.append(slope, elasticity.get("alpha_rad", 0.0))
    covariance, names = known_covariance(fit, band.filmed), (*fit.names, "amplitude")
    by_reading = np.abs(slope) * np.sqrt(np.diag(covariance))
    friction = slope[:-1] @ covariance[:-1, :-1] @ slope[:-1]
    left_out = MODEL_SIGMA if fit.with_crawls else 0.0
    ends = (
        *map(speed_interval, _alone(fit, gait, band.filmed)),
        (band.low_friction_m_s, band.high_friction_m_s),
        (band.low_joints_m_s, band.high_joints_m_s),
        (band.low_m_s, band.high_m_s),
    )
    drawn = [(high - low) / (2 * _Z95 * float(sensitivities.at[0])) for low, high in ends]
    return SpeedDoubts(
        dict(zip(names, by_reading.tolist(), strict=True)),
        dict(zip(names, drawn[:-3], strict=True)),
        math.sqrt(friction),
        math.sqrt(slope @ covariance @ slope + left_out**2),
        *drawn[-3:],
        model=left_out,
    )


def _alone(fit: FrictionFit, gait: Gait, filmed: bool) -> Floats:
    """Return speeds of draws of each friction, and of the amplitude, the others as fitted."""
    whole, count = fit.sample_whole(_DRAWS), len(fit.names)
    rows = np.tile(list(fit.whole_snake.values()), (count + 1, _DRAWS, 1))
    rows[range(count), :, range(count)] = whole.T
    amplitudes = np.ones((count + 1, _DRAWS))
    if not filmed:
        amplitudes[count] = drawn_amplitudes(fit, AMPLITUDE_SIGMA, _DRAWS)
    model = SpeedModel(fit.robot, fit.ground, (gait,), (None,))
    return model.ideal(rows.reshape(-1, count), amplitudes.ravel()).reshape(-1, _DRAWS)


def known_covariance(fit: FrictionFit, filmed: bool) -> Floats:
    """Return the covariance of a fit's frictions and the joints' common amplitude.

    filmed: a film showed the joints, so that their amplitude is in no doubt.
    """
    size = len(fit.names) + 1
    covariance = np.zeros((size, size))
    if fit.with_crawls and not filmed:
        columns = [fit.draws[name] for name in (*fit.names, AMPLITUDE)]
        return np.asarray(np.cov(np.array(columns)))
    covariance[:-1, :-1] = fit.covariance
    covariance[-1, -1] = 0.0 if filmed else AMPLITUDE_SIGMA**2
    return covariance


def margin_sigmas(fit: FrictionFit, filmed: bool) -> tuple[float, float]:
    """Return the relative standard deviations of the joints' common amplitude and of fn0."""
    sigma = np.sqrt(np.diag(known_covariance(fit, filmed)))
    fn0 = max(fit.whole_snake["fn0"], 1e-300)
    return float(sigma[-1]), float(sigma[fit.names.index("fn0")]) / fn0
