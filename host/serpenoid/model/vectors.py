"""Vectors checked where they enter: shape, type and finite numbers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import BadInput


def finite_vector(name: str, values: ArrayLike, size: int) -> NDArray[np.float64]:
    """Return values as `size` finite floats, or raise BadInput naming what is wrong."""
    try:
        vector = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise BadInput(f"{name} is {values!r}; it must be {size} numbers") from None
    if vector.shape != (size,):
        raise BadInput(f"{name} has shape {vector.shape}; it must be {size} numbers")
    if not math.isfinite(vector.sum()) and not np.isfinite(vector).all():
        where = int(np.flatnonzero(~np.isfinite(vector))[0])
        raise BadInput(f"{name}[{where}] is {vector[where]}; it must be a finite number")
    return np.ascontiguousarray(vector)
