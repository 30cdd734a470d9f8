"""Arrays of floats, and checks of the arrays that users pass."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import BadInput

Array = NDArray[np.float64]


def number_array(name: str, values: ArrayLike) -> Array:
    """Return values as an array of floats of any shape, for example (2, 3) of two lists of three.

    name: the argument, for the message. Raises BadInput for text, booleans, other objects, and
    lists of unequal length.
    """
    try:
        array = np.asarray(values)
    except ValueError:
        array = np.array(None)
    if array.dtype.kind in "iuf":
        return array.astype(float, copy=False)
    shown = f"{values!r}"[:100]
    raise BadInput(f"{name} is {shown}; it must be numbers, in a regular array")


def columns(points: Sequence[Any], *names: str) -> list[Array]:
    """Return for each name the array (N,) of that attribute of N points; None becomes NaN."""
    return [np.array([getattr(point, name) for point in points], dtype=float) for name in names]


def finite_vector(name: str, values: ArrayLike, size: int) -> Array:
    """Return values as an array (size,) of finite floats; raises BadInput with the wrong index."""
    vector = number_array(name, values)
    if vector.shape != (size,):
        raise BadInput(f"{name} has shape {vector.shape}; it must be {size} numbers")
    is_finite = np.isfinite(vector)
    if not is_finite.all():
        index = int(is_finite.argmin())
        raise BadInput(f"{name}[{index}] is {vector[index]}; it must be a finite number")
    return np.ascontiguousarray(vector)
