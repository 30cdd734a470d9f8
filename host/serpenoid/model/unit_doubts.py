"""Remarks on a robot or gait that nobody builds: most often a number was typed in another unit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from .gait import Gait
from .robot import MAX_DENSITY_KG_M3, Robot


@dataclass(frozen=True)
class BuiltRobots:
    """Bounds that no wheeled snake robot exceeds.

    length_m, mass_kg: of one link, several times beyond the smallest and the largest that were
    built. bend_deg: of a joint to each side, what hobby servos reach.
    """

    length_m: tuple[float, float] = 0.01, 1.0
    mass_kg: tuple[float, float] = 1e-3, 20.0
    bend_deg: float = 90.0


def unit_doubts(
    robot: Robot, gait: Gait | None, built: BuiltRobots = BuiltRobots()
) -> Iterator[str]:
    """Yield a sentence for each number that no snake robot has: its value, what is usual, the cure.

    Such a number is taken all the same.
    """
    length_m, mass_kg = robot.link_length_m, robot.link_mass_kg
    low, high = built.length_m
    if not low <= length_m <= high:
        units = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254, "ft": 0.3048}
        sizes = {unit: length_m * metres for unit, metres in units.items()}
        likely = [f"{m:.3g} ({unit})" for unit, m in sizes.items() if 2 * low < m < high / 2]
        cure = f"; if that was another unit, give {' or '.join(likely)}" if likely else ""
        yield f"a link is {length_m:g} m long, usual are 0.03 to 0.3 m{cure}"
    too_dense = mass_kg > MAX_DENSITY_KG_M3 * length_m**3
    low, high = built.mass_kg
    if too_dense or not low <= mass_kg <= high:
        metal = f", more than solid metal of {length_m:g} m" if too_dense else ""
        cure = "; if that was in grams, divide by 1000" if mass_kg > 1.0 else ""
        yield (
            f"a link has {mass_kg:g} kg, the whole robot {robot.mass_kg:g} kg{metal}; usual are "
            f"0.02 to 2 kg a link{cure}"
        )
    bend_deg = math.degrees(gait.alpha_rad + abs(gait.offset_rad)) if gait else 0.0
    if round(bend_deg, 6) > built.bend_deg:
        yield (
            f"joints bend by up to {bend_deg:.4g} degrees, those of servos by "
            f"{built.bend_deg:g} to each side; an amplitude is half of the swing from end to end"
        )
