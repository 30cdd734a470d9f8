"""Periodic states over grids: gaits, and if wanted robots and grounds."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..model.checks import check_whole
from ..model.core_model import check_parts, core_model
from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .steady import MAX_ELEMENTS, check_ground, speed_floor_m_s

T = TypeVar("T")
CHUNK = 4096  # shapes handed to the core at a time: what bounds the memory beside the result


@dataclass(frozen=True, slots=True)
class Sweep:
    """Hold periodic states over a grid; all arrays are indexed [alpha, beta, omega].

    With several robots or grounds, [robot, ground, alpha, beta, omega]; a single one has no axis.
    speed_m_s to positive_power_w, turn_rad_per_cycle, settling_time_s: as in Steady.
    error_estimate: of the speed, relative (see Steady); power_error_w, positive_power_error_w: of
    the powers (twice the latter plus the former: of abs_power_w). converged: whether the accuracy
    that was asked for was reached; where it was not the best is given, with its error.
    """

    alpha_rad: NDArray[np.float64]
    beta_rad: NDArray[np.float64]
    omega_rad_s: NDArray[np.float64]
    speed_m_s: NDArray[np.float64]
    power_w: NDArray[np.float64]
    abs_power_w: NDArray[np.float64]
    positive_power_w: NDArray[np.float64]
    turn_rad_per_cycle: NDArray[np.float64]
    error_estimate: NDArray[np.float64]
    power_error_w: NDArray[np.float64]
    positive_power_error_w: NDArray[np.float64]
    settling_time_s: NDArray[np.float64]
    converged: NDArray[np.bool_]


def _axis(name: str, values: ArrayLike) -> NDArray[np.float64]:
    axis = np.atleast_1d(np.asarray(values, dtype=float))
    if axis.ndim != 1 or axis.size == 0:
        raise BadInput(f"{name} has shape {axis.shape}; it must be a list of at least one number")
    return axis


def _several(kind: type[T], parts: T | Sequence[T]) -> list[T]:
    """Return one part, or a sequence of them, as a list."""
    if isinstance(parts, Sequence):
        if len(parts) == 0:
            raise BadInput(f"there is no {kind.__name__.lower()} in the list; give at least one")
        return list(parts)
    return [parts]


def _threads(threads: int | None) -> int:
    if threads is None:
        if hasattr(os, "sched_getaffinity"):
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1
    return check_whole("threads", threads, 1, 1024)


def sweep(
    robot: Robot | Sequence[Robot],
    ground: Ground | Sequence[Ground],
    *,
    alpha_rad: ArrayLike,
    beta_rad: ArrayLike,
    omega_rad_s: ArrayLike,
    rtol: float = 1e-6,
    powers: bool = True,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Sweep:
    """Solve every gait of a grid, for one robot and ground or for all pairs of several.

    Each value has the accuracy that steady_gait gives, and says so. Shapes (alpha, beta) are shared
    out to threads, as many as there are processors unless given; the figures are the same to the
    last bit for any number of them. progress is called, in the caller's thread, with the number of
    gaits done since its last call; Ctrl-C and an exception of progress end the sweep. Raises
    BadInput.
    """
    robots, grounds = _several(Robot, robot), _several(Ground, ground)
    for r in robots:
        for g in grounds:
            check_parts(r, g)
            check_ground(g, rtol)
    a, b = _axis("alpha_rad", alpha_rad), _axis("beta_rad", beta_rad)
    w = _axis("omega_rad_s", omega_rad_s)
    for rate in w:
        Gait(0.0, 0.0, float(rate))
    pairs = [(r, g) for r in robots for g in grounds]
    shapes = [(alpha, beta) for alpha in a.tolist() for beta in b.tolist()]
    models = (
        core_model(r, g, Gait(alpha, beta, float(w[0]))) for r, g in pairs for alpha, beta in shapes
    )
    size = (len(robots), len(grounds), a.size, b.size, w.size)
    table = np.empty((math.prod(size[:4]), w.size, 11))
    count, at = _threads(threads), 0
    while chunk := list(islice(models, CHUNK)):
        table[at : at + len(chunk)] = _core.sweep(
            chunk, w.tolist(), rtol, powers, MAX_ELEMENTS, min(count, len(chunk)), progress
        )
        at += len(chunk)
    return _as_sweep(a, b, w, table, size, robots, (robot, ground))


def _as_sweep(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    w: NDArray[np.float64],
    table: NDArray[np.float64],
    size: tuple[int, ...],
    robots: list[Robot],
    given: tuple[object, object],
) -> Sweep:
    """Name the core's columns; leave out the axes of a single robot and ground."""
    single = tuple(k for k, part in enumerate(given) if not isinstance(part, Sequence))
    columns = [np.squeeze(c.reshape(size), axis=single) for c in np.moveaxis(table, -1, 0)]
    speed, power, absolute, positive, turn, error, power_error, positive_error, slowest = columns[
        :9
    ]
    floor = np.array([[[[[speed_floor_m_s(r, 1.0)]]]] for r in robots]) * w
    floor = np.squeeze(np.broadcast_to(floor, size), axis=single)
    with np.errstate(divide="ignore"):
        settling = np.where(slowest < 0, -2 * math.pi / w / slowest, math.inf)
    return Sweep(
        a, b, w, speed, power, absolute, positive, turn, error / np.maximum(speed, floor),
        power_error, positive_error, settling, columns[10] > 0.5,
    )  # fmt: skip
