"""A grid of robots, grounds and gaits as one list of shapes, any stretch of which can be solved."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
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

MOST_GAITS = 10**12
Stretch = tuple[int, int]  # of shapes: the first, and the last plus one
AXES = ("alpha_rad", "beta_rad", "omega_rad_s")
FIELDS = (
    "speed_m_s",
    "power_w",
    "abs_power_w",
    "positive_power_w",
    "turn_rad_per_cycle",
    "error_estimate",
    "power_error_w",
    "positive_power_error_w",
    "settling_time_s",
    "converged",
)


@dataclass(frozen=True)
class Grid:
    """Hold the gaits to solve: robots x grounds x alpha x beta (the shapes, so ordered) x omega.

    A shape's figures are the same to the last bit whatever stretch it is solved in.
    Raises BadInput.
    """

    robots: tuple[Robot, ...]
    grounds: tuple[Ground, ...]
    alpha_rad: tuple[float, ...]
    beta_rad: tuple[float, ...]
    omega_rad_s: tuple[float, ...]
    rtol: float = 1e-6
    powers: bool = True

    @classmethod
    def of(
        cls,
        robots: Robot | Sequence[Robot],
        grounds: Ground | Sequence[Ground],
        axes: Sequence[ArrayLike],
        rtol: float,
        powers: bool,
    ) -> Grid:
        """Return the grid of one or several robots and grounds; axes: alpha, beta, omega."""
        alpha, beta, omega = (axis(name, v) for name, v in zip(AXES, axes, strict=True))
        parts = several(Robot, robots), several(Ground, grounds)
        return cls(*parts, alpha, beta, omega, rtol, powers)

    def __post_init__(self) -> None:
        if not isinstance(self.powers, bool):
            raise BadInput(f"powers is {self.powers!r}; it must be True or False")
        for robot in self.robots:
            check_parts(robot, self.grounds[0])
        for ground in self.grounds:
            check_parts(self.robots[0], ground)
            check_ground(ground, self.rtol)
        for alpha in self.alpha_rad:
            Gait(alpha, self.beta_rad[0], self.omega_rad_s[0])
        for beta in self.beta_rad:
            Gait(0.0, beta, self.omega_rad_s[0])
        for rate in self.omega_rad_s:
            Gait(0.0, 0.0, rate)
        if self.gaits > MOST_GAITS:
            raise BadInput(f"the grid has {self.gaits:.3g} gaits; the most is {MOST_GAITS:.0e}")

    @property
    def size(self) -> tuple[int, int, int, int]:
        """Return the numbers of robots, grounds, alphas and betas."""
        return len(self.robots), len(self.grounds), len(self.alpha_rad), len(self.beta_rad)

    @property
    def shapes(self) -> int:
        """Return the number of shapes."""
        return math.prod(self.size)

    @property
    def gaits(self) -> int:
        """Return the number of gaits."""
        return self.shapes * len(self.omega_rad_s)

    def models(self, first: int, last: int) -> list[_core.Model]:
        """Return the shapes from first up to but not including last as the core takes them."""
        any_gait = Gait(0.0, 0.0, self.omega_rad_s[0])
        pairs = [core_model(r, g, any_gait) for r in self.robots for g in self.grounds]
        alphas, betas = len(self.alpha_rad), len(self.beta_rad)
        return [
            pairs[k // (alphas * betas)].bent(
                self.alpha_rad[k // betas % alphas], self.beta_rad[k % betas]
            )
            for k in range(first, last)
        ]

    def solve(self, first: int, last: int, threads: int, progress: Progress | None = None) -> Array:
        """Return the core's eleven figures of a stretch of shapes, (shape, rate, 11)."""
        models, rates = self.models(first, last), list(self.omega_rad_s)
        count = min(threads, len(models))
        return _core.sweep(models, rates, self.rtol, self.powers, count, progress)

    def named(self, table: Array) -> dict[str, NDArray[Any]]:
        """Return the figures of all shapes by name, each (shape, rate), with errors and times."""
        columns = (table[..., k] for k in (*range(9), 10))
        values: dict[str, NDArray[Any]] = dict(zip(FIELDS, columns, strict=True))
        w, slowest = np.array(self.omega_rad_s), values["settling_time_s"]
        robot = np.unravel_index(np.arange(self.shapes), self.size)[0]
        floors = np.array([speed_floor_m_s(r, 1.0) for r in self.robots])[robot, None] * w
        with np.errstate(divide="ignore"):
            settling = np.where(slowest < 0, -2 * math.pi / w / slowest, math.inf)
        error = values["error_estimate"] / np.maximum(values["speed_m_s"], floors)
        derived = {"error_estimate": error, "settling_time_s": settling}
        return values | derived | {"converged": values["converged"] > 0.5}


def axis(name: str, values: ArrayLike) -> tuple[float, ...]:
    """Return an axis of the grid as numbers."""
    numbers = np.atleast_1d(number_array(name, values))
    if numbers.ndim != 1 or numbers.size == 0:
        raise BadInput(
            f"{name} has shape {numbers.shape}; it must be a list of at least one number"
        )
    return tuple(numbers.tolist())


def several(kind: type, parts: Any) -> tuple[Any, ...]:
    """Return one part, or a sequence of them, as a tuple."""
    if isinstance(parts, Sequence):
        if len(parts) == 0:
            raise BadInput(f"there is no {kind.__name__.lower()} in the list; give at least one")
        return tuple(parts)
    return (parts,)


def stretches(shapes: int, length: int) -> Iterator[Stretch]:
    """Cut the list of shapes into stretches of at most `length`."""
    return ((at, min(at + length, shapes)) for at in range(0, shapes, length))
