"""The shapes of a sweep, robots x grounds x alpha x beta, and their figures at every rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base.errors import BadInput
from ..base.long_calls import Progress
from ..base.vectors import Array, number_array
from ..model.core_model import check_parts, core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .steady import check_ground, speed_floor_m_s

MAX_GAITS = 10**8  # eleven numbers of each are 9 GB
Shape = tuple[Robot, Ground, Gait]  # its gait at the first rate
SLOWEST, CONVERGED = 8, 10  # columns of the core's table: ln of a disturbance's decay, and a flag


def grid_shapes(
    robots: Sequence[Robot], grounds: Sequence[Ground], axes: Sequence[Array], rtol: float
) -> list[Shape]:
    """Return every shape of a grid, the lags fastest; axes: alpha, beta, omega.

    Raises BadInput.
    """
    alphas, betas, rates = (values.tolist() for values in axes)
    gaits = math.prod(map(len, (robots, grounds, alphas, betas, rates)))
    if gaits > MAX_GAITS:
        raise BadInput(f"the grid has {gaits:.3g} gaits; the most is {MAX_GAITS:.0e}")
    for robot, ground in product(robots, grounds):
        check_parts(robot, ground)
        check_ground(ground, rtol)
    for rate in rates:
        Gait(0.0, 0.0, rate)
    bends = [Gait(alpha, beta, rates[0]) for alpha, beta in product(alphas, betas)]
    return list(product(robots, grounds, bends))


def solve_shapes(
    shapes: Sequence[Shape],
    rates: Sequence[float],
    rtol: float,
    powers: bool,
    threads: int = 1,
    progress: Progress | None = None,
) -> Array:
    """Return the core's eleven figures of each shape at each rate, (shape, rate, 11).

    A shape's are the same to the last bit whatever shapes are solved with it.
    """
    models = [core_model(*shape) for shape in shapes]
    return _core.sweep(models, rates, rtol, powers, min(threads, len(models)), progress)


def gait_figures(shapes: Sequence[Shape], rates: Array, table: Array) -> list[NDArray[Any]]:
    """Return the figures that Sweep has, in its order, each (shape, rate), of the core's table."""
    columns: list[NDArray[Any]] = list(np.moveaxis(table, -1, 0))
    floors = np.array([speed_floor_m_s(robot, 1.0) for robot, _, _ in shapes])[:, None] * rates
    columns[5] = columns[5] / np.maximum(columns[0], floors)
    slowest = columns[SLOWEST]
    with np.errstate(divide="ignore"):
        columns[SLOWEST] = np.where(slowest < 0, -math.tau / rates / slowest, math.inf)
    return [*columns[: SLOWEST + 1], columns[CONVERGED] > 0]


def grid_axis(name: str, values: ArrayLike) -> Array:
    """Return an axis of the grid, at least one number."""
    numbers = np.atleast_1d(number_array(name, values))
    if numbers.ndim != 1 or numbers.size == 0:
        raise BadInput(
            f"{name} has shape {numbers.shape}; it must be a list of at least one number"
        )
    return numbers


def several(kind: type, parts: Any) -> tuple[Any, ...]:
    """Return one part, or a sequence of them, as a tuple."""
    if isinstance(parts, Sequence):
        if len(parts) == 0:
            raise BadInput(f"there is no {kind.__name__.lower()} in the list; give at least one")
        return tuple(parts)
    return (parts,)
