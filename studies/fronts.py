"""Time searches for gaits, in processor time: fronts of ten speeds over one, a robust gait."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import serpenoid as sn
from serpenoid.gaits.paper_study import BINGHAM, GROUND, OF_2005, ROBOT

COSTS = ("power", "abs_power", "positive_power")
SPEEDS = 10
Case = tuple[str, sn.Robot, sn.Ground, float, float, str]  # name, ..., least and most speed, cost
NAMED: list[Case] = [
    ("the paper's robot", ROBOT, GROUND, 0.03, 0.7, "power"),
    ("the paper's robot, P+", ROBOT, GROUND, 0.03, 0.7, "positive_power"),
    ("4 links, viscous", sn.Robot(4, 0.1, 0.08), sn.Ground(0.05, 1.0), 0.03, 0.2, "power"),
    ("10 links, viscous", sn.Robot(10, 0.05, 0.05), sn.Ground(0.02, 2.0), 0.03, 0.3, "power"),
    ("the 2005 robot, dry", OF_2005, BINGHAM, 0.03, 0.2, "power"),
]


def drawn(rng: np.random.Generator, dry: bool) -> Case:
    """Return a random robot with speeds of .05 to .5 body lengths a second."""
    links = int(rng.integers(4, 13))
    robot = sn.Robot(links, float(np.exp(rng.uniform(-4, 0))), float(rng.uniform(0.03, 0.15)))
    ct, length = float(np.exp(rng.uniform(-5, -1))), links * robot.link_length_m
    cn = ct * float(np.exp(rng.uniform(1.5, 5)))
    ft0 = robot.link_mass_kg * 9.81 * float(rng.uniform(0.01, 0.05)) if dry else 0.0
    ground = sn.Ground(ct, cn, ft0, ft0 * float(rng.uniform(2, 20)))
    cost = COSTS[int(rng.integers(3))]
    name = f"{links} links, {'dry' if dry else 'viscous'}, {cost}"
    return name, robot, ground, 0.05 * length, 0.5 * length, cost


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Return the median processor time of a call, s."""
    found = []
    for _ in range(repeats):
        begin = time.process_time()
        work()
        found.append(time.process_time() - begin)
    return float(np.median(found))


def fronts(cases: list[Case], repeats: int) -> None:
    """Print the time of a front of ten speeds over the median time of one of its speeds."""
    print(f"{'':32}   one, ms  front, ms  front/one")
    for name, robot, ground, low, high, cost in cases:
        speeds = np.geomspace(low, high, SPEEDS).tolist()
        front = partial(sn.power_front, robot, ground, speeds_m_s=speeds, cost=cost)
        singles = [
            partial(sn.power_front, robot, ground, speeds_m_s=[v], cost=cost) for v in speeds
        ]
        one = float(np.median([seconds(single, 1) for single in singles]))
        all_ten = seconds(front, repeats)
        print(f"{name:32} {1e3 * one:9.1f} {1e3 * all_ten:10.1f} {all_ten / one:10.2f}", flush=True)


def robust(repeats: int) -> None:
    """Print the time of a robust gait: the 2005 robot at .05 m/s."""

    search = partial(sn.robust_gait, OF_2005, BINGHAM, speed_m_s=0.05)
    print(f"a robust gait: {seconds(search, repeats):.2f} s")


def main() -> None:
    """Read the options and run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=8, help="random robots of each kind")
    parser.add_argument("--seed", type=int, default=23)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    cases = NAMED + [drawn(rng, dry) for dry in (False, True) for _ in range(options.random)]
    fronts(cases, options.repeats)
    robust(options.repeats)


if __name__ == "__main__":
    main()
