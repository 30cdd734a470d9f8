"""What each friction's doubt leaves of a speed, by the speed's derivatives, held to draws."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...periodic.sensitivities import Sensitivities
from ..friction_result import FrictionFit
from ..speed_samples import SpeedBand

_Z95 = 1.959964
_STRAIGHT = 0.25  # by which slopes and draws may differ


@dataclass(frozen=True)
class SpeedDoubts:
    """Hold standard deviations of a gait's speed, relative, as friction alone leaves them.

    each: of every friction alone, by the derivatives. together: of all, with their correlations.
    drawn: half of the 95 % interval of frictions that were drawn and solved for, over 1.96.
    """

    each: dict[str, float]
    together: float
    drawn: float

    @property
    def straight(self) -> bool:
        """Tell whether the derivatives hold over the whole doubt: draws say the same."""
        return abs(self.together - self.drawn) <= _STRAIGHT * self.drawn

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return asdict(self) | {"straight": self.straight}

    def in_words(self) -> str:
        """Return the frictions, the largest part first."""
        parts = sorted(self.each.items(), key=lambda part: -part[1])
        told = ", ".join(f"{name} {_percent(share)}" for name, share in parts)
        whole = f"together {_percent(self.together)}, draws {_percent(self.drawn)}"
        mislead = "" if self.straight else " Derivatives mislead here: the draws count."
        return f"of it friction's doubt (1 sigma, by derivatives): {told}; {whole}.{mislead}"


def _percent(share: float) -> str:
    return f"±{100 * share:.0f} %" if share >= 1.0 else f"±{100 * share:.2g} %"


def speed_doubts(fit: FrictionFit, found: Sensitivities, band: SpeedBand) -> SpeedDoubts:
    """Return what a fit's frictions leave of the speed whose derivatives and band were found.

    A friction that has no derivative (it is 0) counts as 0 in the derivatives, not in the draws.
    """
    elasticity = dict(zip(found.names, found.elasticities().tolist(), strict=True))
    whole = np.array(list(fit.whole_snake.values()))
    ratchet = len(fit.names) > 4
    slope = np.array([elasticity.get(_of_link(name, ratchet), 0.0) for name in fit.names])
    slope = np.divide(slope, whole, out=np.zeros_like(slope), where=whole > 0.0)
    each = np.abs(slope) * np.sqrt(np.diag(fit.covariance))
    drawn = (band.high_friction_m_s - band.low_friction_m_s) / (2 * _Z95 * found.at[0])
    return SpeedDoubts(
        dict(zip(fit.names, each.tolist(), strict=True)),
        float(np.sqrt(slope @ fit.covariance @ slope)), float(drawn),
    )  # fmt: skip


def _of_link(name: str, ratchet: bool) -> str:
    """Return the parameter of Sensitivities for a friction of a fit."""
    if name.endswith("_back"):
        return f"{name.removesuffix('_back')}_backward"
    return f"{name}_forward" if ratchet and name in ("ct", "ft0") else name
