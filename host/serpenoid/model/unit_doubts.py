"""Remarks on a robot or gait that nobody builds: most often a number was typed in another unit."""

from __future__ import annotations

import math
from collections.abc import Iterator

from .gait import Gait
from .robot import Robot


def unit_doubts(
    robot: Robot,
    gait: Gait | None,
    *,
    lengths_m: tuple[float, float] = (0.01, 1.0),
    masses_kg: tuple[float, float] = (1e-3, 5.0),
    max_bend_deg: float = 90.0,
) -> Iterator[str]:
    """Yield a sentence for each number that no snake robot has: its value, what is usual, the cure.

    Such a number is taken all the same. lengths_m, masses_kg: bounds of one link, beyond the
    smallest and the largest of most robots that were built. max_bend_deg: bend of a joint to either
    side, which hobby servos reach.
    """
    length_m, mass_kg = robot.link_length_m, robot.link_mass_kg
    low, high = lengths_m
    if not low <= length_m <= high:
        sizes = {"mm": 1e-3 * length_m, "cm": 1e-2 * length_m, "in": 0.0254 * length_m}
        likely = [
            f"{size_m:.3g} ({unit})" for unit, size_m in sizes.items() if low < size_m < high / 2
        ]
        cure = f"; if that was another unit, give {' or '.join(likely)}" if likely else ""
        yield f"a link is {length_m:g} m long, usual are 0.03 to 0.3 m{cure}"
    low, high = masses_kg
    if not low <= mass_kg <= high:
        cure = "; if that was in grams, divide by 1000" if mass_kg > high else ""
        yield (
            f"a link has {mass_kg:g} kg, the whole robot {robot.mass_kg:g} kg; usual are "
            f"0.02 to 2 kg a link{cure}"
        )
    bend_deg = math.degrees(gait.alpha_rad + abs(gait.offset_rad)) if gait else 0.0
    if round(bend_deg, 6) > max_bend_deg:
        yield (
            f"joints bend by up to {bend_deg:.4g} degrees, those of servos by {max_bend_deg:g} to "
            "each side; an amplitude is half of the swing from end to end"
        )
