"""Measure what the paper's springs (k = 1000 N/m, c = 1 N s/m) change over its own grid of gaits.

The grid of the paper's search: omega 1..20 rad/s, alpha 5..75, beta 20..90 degrees, 4500 gaits
(two minutes; `--every 7` takes one gait in seven).
"""

from __future__ import annotations

import argparse
import itertools
import math

import numpy as np
import serpenoid as sn
from rich.progress import track

ROBOT, GROUND = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12), sn.Ground(0.1, 10.0)


def main() -> None:
    """Print the median error and how many gaits are more than 10 % off."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="one gait in so many")
    every = parser.parse_args().every
    grid = list(itertools.product(range(5, 80, 5), range(20, 95, 5), range(1, 21)))[::every]
    errors, failed = [], 0
    for alpha, beta, omega in track(grid, "gaits", transient=True):
        gait = sn.Gait(math.radians(alpha), math.radians(beta), float(omega))
        try:
            soft = sn.steady_springs(ROBOT, GROUND, gait, rtol=1e-3)
            errors.append(abs(soft.modelling_error))
        except sn.SerpenoidError:  # some soft gaits have no state that repeats
            failed += 1
    print(f"{len(grid)} gaits: the median error of the speed is {np.median(errors):.2%}")
    print(
        f"more than 10 % off: {sum(np.array(errors) > 0.1)}; without a state that repeats: {failed}"
    )


if __name__ == "__main__":
    main()
