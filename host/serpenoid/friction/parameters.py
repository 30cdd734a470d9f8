"""Names, priors and arrays of the parameters that a friction fit determines."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]
Rows = NDArray[np.bool_]  # Mask of residuals.
Values = Mapping[str, Floats]  # Parameter name -> K values, (K,).

# Frictions of the whole snake, in the order of arrays.
FRICTIONS: tuple[str, ...] = ("ct", "cn", "ft0", "fn0")
# Prior sigma of the inclinometer's zero if a set-up states 0, because an undeclared zero of
# 0.1 degrees would reduce the coverage of ft0's 95 % interval to 17 %.
ZERO_SIGMA_RAD = math.radians(0.1)
ZERO, BELT = "incline_zero_rad", "belt_scale"
ROUNDING = "rounding "  # Start of the names of shared rounding errors.


@dataclass(frozen=True)
class Parameter:
    """A parameter with its normal prior.

    sigma: standard deviation of the prior; infinite for a flat one. low: lower bound.
    """

    name: str
    mean: float = 0.0
    sigma: float = math.inf
    low: float = -math.inf


FRICTION_PARAMETERS = tuple(Parameter(name, low=0.0) for name in FRICTIONS)
