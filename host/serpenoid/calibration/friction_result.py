"""What a friction fit gives back: values, intervals, covariance, and what to know about them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model.ground import Ground
from .session import Session

Floats = NDArray[np.float64]

NAMES = ("ct", "cn", "ft0", "fn0")
UNITS = MappingProxyType({"ct": "N s/m", "cn": "N s/m", "ft0": "N", "fn0": "N"})
LEVEL = 0.95
DOUBTFUL = 0.01  # below this p-value the stated uncertainties and the readings do not agree


class Estimate(NamedTuple):
    """A fitted value and its standard deviation, in the same unit."""

    value: float
    sigma: float


class Row(NamedTuple):
    """One line of a table of results; low and high bound the 95 % interval."""

    name: str
    unit: str
    value: float
    sigma: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class FrictionFit:
    """Hold the friction fitted to one session.

    parameters: name -> (value, sigma) for ct, cn (N s/m), ft0, fn0 (N), of the whole snake.
    intervals: name -> (low, high) at 95 %; none reaches below 0, where friction cannot be.
    covariance: (4, 4), of the whole snake's values in the order of parameters. ground: the same
    friction per link. sigma: "absolute" when it follows from the stated uncertainties of the
    instruments alone, "rescaled" when from the scatter of the readings alone. chi2, dof: of the
    readings and priors under the stated uncertainties. nuisances: lambda_offset_rad and
    incline_zero_rad as fitted (joint only). residuals: per kept reading, in standard deviations.
    notes: what a reader of the numbers should know, in words.
    """

    method: str
    sigma: str
    parameters: Mapping[str, Estimate]
    intervals: Mapping[str, tuple[float, float]]
    covariance: Floats
    ground: Ground
    chi2: float
    dof: int
    nuisances: Mapping[str, Estimate]
    residuals: tuple[float, ...]
    notes: tuple[str, ...]

    @property
    def whole_body(self) -> dict[str, float]:
        """Return name -> value of the whole snake, as Ground.whole_body takes them."""
        return {name: estimate.value for name, estimate in self.parameters.items()}

    @property
    def p_value(self) -> float | None:
        """Return the chance of a chi2 at least this large if model and uncertainties hold."""
        from scipy.special import chdtrc

        return float(chdtrc(self.dof, self.chi2)) if self.dof > 0 else None

    def rows(self) -> list[Row]:
        """Return a table's lines, one a parameter."""
        return [
            Row(name, UNITS[name], *self.parameters[name], *self.intervals[name]) for name in NAMES
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return plain lists, numbers and text, fit for JSON."""
        return {
            "method": self.method,
            "sigma": self.sigma,
            "interval_level": LEVEL,
            "parameters": {
                row.name: {
                    "unit": row.unit,
                    "value": row.value,
                    "sigma": row.sigma,
                    "interval": [row.low, row.high],
                }
                for row in self.rows()
            },
            "covariance": {"order": list(NAMES), "values": self.covariance.tolist()},
            "ground_per_link": {name: getattr(self.ground, name) for name in NAMES},
            "chi2": self.chi2,
            "dof": self.dof,
            "p_value": self.p_value,
            "nuisances": {name: e._asdict() for name, e in self.nuisances.items()},
            "residuals": list(self.residuals),
            "notes": list(self.notes),
        }


def notes_on(fit: FrictionFit, session: Session) -> tuple[str, ...]:
    """Return what a reader of the numbers should know, in words."""
    notes = []
    if session.setup.kind == "regenerated":
        notes.append(
            "The readings are regenerated from published fits, not measured, and show no scatter; "
            "a joint fit's intervals come from assumed instrument uncertainties."
        )
    voided = len(session.readings) - len(session.kept)
    if voided:
        notes.append(f"{voided} voided reading(s) left out.")
    if fit.method == "naive":
        notes.append(
            "Naive intervals leave out the errors that readings share (bend, inclinometer zero, "
            "tangential friction in Eq. 61) and are too narrow."
        )
    if fit.p_value is not None and fit.p_value < DOUBTFUL:
        notes.append(
            f"chi2 is {fit.chi2:.1f} for {fit.dof} degrees of freedom (p = {fit.p_value:.1g}): the "
            "readings disagree by more than the stated uncertainties allow, so do not trust the "
            "intervals."
        )
    return (*_weak(fit), *notes)


def _weak(fit: FrictionFit) -> list[str]:
    notes = []
    for name, (value, sigma) in fit.parameters.items():
        if value < 1e-3 * sigma:
            notes.append(f"{name} ends at its limit of 0; its interval is rough.")
        elif sigma > 0.25 * value:
            cure = "bend further" if name in ("cn", "fn0") else "take more readings"
            notes.append(f"{name} is known to {sigma / value:.0%} only; {cure} to know it better.")
    return notes
