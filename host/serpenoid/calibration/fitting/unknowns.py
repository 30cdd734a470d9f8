"""What readings depend on and nobody measured exactly: unknowns by name, and values of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Whole = NDArray[np.intp]
Values = Mapping[str, Floats]


@dataclass(frozen=True)
class Unknown:
    """A number that nobody measured exactly.

    low: the least that it can be. friction: any value from 0 on is as likely as any other.
    """

    name: str
    low: float = -math.inf
    friction: bool = False
