"""Arrays checked where they enter: type, shape and finite numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import BadInput

Array = NDArray[np.float64]


def number_array(name: str, values: ArrayLike) -> Array:
    """Return values as an array of floats of any shape; raises BadInput: text, objects, ragged."""
    try:
        array = np.asarray(values)
        wrong = array.dtype.kind not in "iufO" or any(
            v is None or isinstance(v, (str, bytes, bool))
            for v in array.flat
            if array.dtype.kind == "O"
        )
        if not wrong:
            return array.astype(float, copy=False)
    except (TypeError, ValueError, OverflowError):  # OverflowError: a number of 400 digits
        pass
    shown = f"{values!r}"[:100]
    raise BadInput(f"{name} is {shown}; it must be numbers, up to 1e308, in a regular array")


def columns(points: Sequence[Any], *names: str) -> list[Array]:
    """Return an array for each attribute of some points; None becomes NaN."""
    return [np.array([getattr(point, name) for point in points], dtype=float) for name in names]


def finite_vector(name: str, values: ArrayLike, size: int) -> Array:
    """Return values as `size` finite floats, or raise BadInput naming what is wrong."""
    vector = number_array(name, values)
    if vector.shape != (size,):
        raise BadInput(f"{name} has shape {vector.shape}; it must be {size} numbers")
    beyond = np.flatnonzero(~np.isfinite(vector))
    if beyond.size:
        where = int(beyond[0])
        raise BadInput(f"{name}[{where}] is {vector[where]}; it must be a finite number")
    return np.ascontiguousarray(vector)
