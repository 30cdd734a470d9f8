"""How a gait's speed changes with seven numbers of robot, friction and gait, by differences."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from .. import _core
from ..base.errors import BadInput, NotConverged
from ..base.rows import Result, Row
from ..base.vectors import Array
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot

Parts = tuple[Any, Any, Any]  # Robot, Ground, Gait


# Which of robot, ground and gait each number is of, and what grows with which power of it.
NUMBERS: dict[str, tuple[int, dict[str, int]]] = {
    "mass": (0, {"link_mass_kg": 1, "link_inertia_kg_m2": 1}),
    "length": (0, {"link_length_m": 1, "link_inertia_kg_m2": 2}),
    "amplitude": (2, {"alpha_rad": 1}),
    "lag": (2, {"beta_rad": 1}),
    "rate": (2, {"omega_rad_s": 1}),
    "friction along": (1, {"ct": 1, "ft0": 1}),
    "friction across": (1, {"cn": 1, "fn0": 1}),
}


def changed_parts(parts: Parts, number: str, factor: float) -> Parts:
    """Return robot (its inertia stated), ground and gait with one of NUMBERS times a factor."""
    place, powers = NUMBERS[number]
    part: Any = parts[place]
    factors = {name: factor**power for name, power in powers.items()}
    if isinstance(part, Ground):
        part = part.scaled(**factors)
    else:
        part = replace(part, **{name: getattr(part, name) * f for name, f in factors.items()})
    return *parts[:place], part, *parts[place + 1 :]  # type: ignore[return-value]


@dataclass(frozen=True, slots=True)
class Sensitivities(Result):
    """Hold by how many per cent 1 % more of each of seven numbers changes a gait's speed.

    Attributes
    ----------
    percent, errors
        (7,): per cent of speed for 1 % of each of NUMBERS, by central differences, and their
        estimated errors.
    less, more
        (7,): the same by 1 % less alone, and by 1 % more alone. They differ at a kink, where a
        wheel begins or ceases to rest, and near a sharp drop of speed.
    """

    percent: Array
    errors: Array
    less: Array
    more: Array

    @property
    def one_sided(self) -> list[bool]:
        """Return for each number whether its two sides differ by more than 10 %."""
        larger = np.maximum(np.abs(self.less), np.abs(self.more))
        # A difference of 0.02 % of the speed for 1 % matters to nobody.
        return (np.abs(self.more - self.less) > np.maximum(0.1 * larger, 0.02)).tolist()

    def in_words(self) -> str:
        """Return what the table shows."""
        return "What 1 % more of each number changes of the speed, with ideal joints:"

    def rows(self) -> list[Row]:
        """Return a row for each number, with both sides where they differ."""
        rows = []
        for k, (name, one_sided) in enumerate(zip(NUMBERS, self.one_sided, strict=True)):
            sides = f" (less {self.less[k]:+.2g}, more {self.more[k]:+.2g})" if one_sided else ""
            rows.append(Row(name + sides, "%", self.percent[k], sigma=self.errors[k]))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, for JSON, by number."""
        columns = {
            "percent": self.percent,
            "error": self.errors,
            "less": self.less,
            "more": self.more,
        }
        return {
            number.replace(" ", "_"): {name: float(values[k]) for name, values in columns.items()}
            for k, number in enumerate(NUMBERS)
        }


def speed_sensitivities(
    robot: Robot, ground: Ground, gait: Gait, floor_m_s: float
) -> Sensitivities:
    """Return per cents of a gait's speed for 1 % of each of seven numbers.

    Raises BadInput for a speed below the floor, and NotConverged where a state beside this one has
    no solution.
    """
    solid = replace(robot, link_inertia_kg_m2=robot.inertia_kg_m2)
    parts: Parts = solid, ground, gait
    # Changes by 1 % show the error of those by 0.5 %.
    factors = 0.99, 0.995, 1.005, 1.01
    changed = [changed_parts(parts, number, factor) for number, factor in product(NUMBERS, factors)]
    models = [core_model(*part) for part in (parts, *changed)]
    states = _core.neighbours(models[0], models, 1e-7, False, 1)
    speeds = np.array([state.speed for state in states])
    claims = np.array([state.speed_error for state in states])
    if not speeds[0] > floor_m_s:
        raise BadInput("the gait has no speed, of which no per cent is anything")
    if not np.isfinite(claims).all():
        raise NotConverged(
            "no periodic state found beside this gait; ask for the state without sensitivities"
        )
    changes = (speeds[1:] / speeds[0] - 1).reshape(-1, 4)
    less, near_less, near_more, more = (changes / (np.array(factors) - 1)).T
    percent = (near_less + near_more) / 2
    noise = 2 * claims.max() / speeds[0] / 0.01
    errors = np.abs(percent - (less + more) / 2) + noise
    return Sensitivities(percent, errors, less, more)
