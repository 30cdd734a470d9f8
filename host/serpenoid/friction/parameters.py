"""Parameters of a fit with their priors, and values of them by name."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]
Rows = NDArray[np.bool_]  # which residuals
Values = Mapping[str, Floats]  # values of each parameter, (K,)

FRICTIONS: tuple[str, ...] = ("ct", "cn", "ft0", "fn0")  # the whole snake's, in their order
# Taken where a set-up claims a zero without error: an undeclared 0.1 degrees would leave ft0's 95 %
# interval with 17 % coverage, so that the prior is never absent.
ZERO_SIGMA_RAD = math.radians(0.1)
ZERO, BELT = "incline_zero_rad", "belt_scale"
ROUNDING = "rounding "  # begins the names of shared rounding errors


@dataclass(frozen=True)
class Parameter:
    """A number that readings depend on, with its normal prior.

    sigma: of the prior; infinite: any value above low is as likely as any other.
    """

    name: str
    mean: float = 0.0
    sigma: float = math.inf
    low: float = -math.inf


FRICTION_PARAMETERS = tuple(Parameter(name, low=0.0) for name in FRICTIONS)


def frictions_in(values: Values) -> Floats:
    """Return the frictions (K, 4) among values by name, in the order of FRICTIONS."""
    return np.stack([values[name] for name in FRICTIONS], axis=-1)
