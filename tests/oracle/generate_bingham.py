"""Write periodic_bingham.csv: run `python -m reference.generate_bingham` from tests/host (minutes).

Columns: the robot and ground per link (SI), the gait (rad, rad/s), then the event-driven state's
fields. `accuracy` is relative, of the speed: the largest of the change under a hundred times
coarser tolerance and of the cycle's residual. `other_method` is the relative distance to the
speed of the convex implicit steps, `other_accuracy` that method's own estimate of its error.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from . import bingham_periodic, bingham_stepping
from .params import Gait, Params, gait_deg, robot_2005

FILE = Path(__file__).with_name("periodic_bingham.csv")
INPUTS = ["links", "mass_kg", "half_length_m", "inertia_kg_m2", "ct", "cn", "ft0", "fn0"]
INPUTS += ["alpha_rad", "beta_rad", "omega_rad_s"]
RESULTS = ["speed_m_s", "power_w", "abs_power_w", "positive_power_w", "dissipation_w"]
RESULTS += ["u0_x_m_s", "u0_y_m_s", "u0_spin_rad_s", "events", "stuck_fraction"]
RESULTS += ["accuracy", "other_method", "other_accuracy"]


def cases() -> list[tuple[Params, Gait]]:
    """Return the gaits of the table."""
    robot = robot_2005()
    table = [(robot, gait_deg(70, 75, w)) for w in (0.5, 1, 2, 3, 5, 8, 10, 15)]
    gaits = [(30, 80, 5), (10, 80, 2), (5, 80, 1), (20, 60, 3), (45, 90, 8), (90, 60, 2)]
    gaits += [(15, 45, 10), (110, 100, 3), (3, 70, 0.5), (70, 75, 0.3)]
    table += [(robot, gait_deg(*gait)) for gait in gaits]
    grounds = [(0.0, 0.0, 0.02, 0.2), (0.0, 0.0, 0.1, 0.5), (0.1, 10.0, 0.1, 0.5)]
    grounds += [(0.1, 10.0, 0.0, 1.0), (0.1, 10.0, 0.5, 0.0), (0.0, 0.0, 0.3, 0.1)]
    table += [(Params(6, 0.0756, 0.038, None, *ground), gait_deg(50, 70, 4)) for ground in grounds]
    table += [(Params(6, 1.0, 0.06, None, 0.1, 10.0, 0.2, 3.0), gait_deg(30, 80, 5))]
    table += [(Params(6, 1.0, 0.06, None, 0.1, 10.0, 0.2, 30.0), gait_deg(8, 80, 3))]
    by_links = [(3, 70, 90, 4), (4, 50, 80, 6), (9, 40, 50, 3), (12, 30, 40, 2)]
    return table + [(robot_2005(n), gait_deg(*gait)) for n, *gait in by_links]


def inputs(p: Params, gait: Gait) -> list[float]:
    """Return the first columns of a row."""
    robot = [p.links, p.mass_kg, p.half_length_m, p.inertia, p.ct, p.cn, p.ft0, p.fn0]
    return [*robot, gait.alpha_rad, gait.beta_rad, gait.omega_rad_s]


def table() -> list[tuple[Params, Gait, dict[str, float]]]:
    """Return robot, gait and results of each row of periodic_bingham.csv."""
    with FILE.open(newline="") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    first = [[row[key] for key in INPUTS] for row in rows]
    robots = [Params(int(values[0]), *values[1:8]) for values in first]
    gaits = [Gait(*values[8:]) for values in first]
    return list(zip(robots, gaits, rows, strict=True))


def results(p: Params, gait: Gait) -> list[float]:
    """Return the last columns of a row."""
    best = bingham_periodic.steady(p, gait, 1e-11)
    coarse = bingham_periodic.steady(p, gait, 1e-9, best.u0)
    speed = best.speed_m_s
    accuracy = max(abs(coarse.speed_m_s - speed) / speed, best.residual / speed)
    other, spread = bingham_stepping.extrapolated_speed(p, gait, best.u0, 2000)
    return [
        speed,
        best.power_w,
        best.abs_power_w,
        best.positive_power_w,
        best.dissipation_w,
        *best.u0,
        best.events,
        best.stuck_fraction,
        accuracy,
        abs(other / speed - 1),
        spread / speed,
    ]


def main() -> None:
    """Write the table, a line of progress per gait."""
    with FILE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(INPUTS + RESULTS)
        for p, gait in cases():
            row = results(p, gait)
            writer.writerow(
                [f"{value:.17g}" for value in inputs(p, gait)]
                + [f"{value:.12g}" for value in row[:-3]]
                + [f"{value:.1e}" for value in row[-3:]]
            )
            file.flush()
            print(p.links, gait, [f"{value:.3g}" for value in row], file=sys.stderr)


if __name__ == "__main__":
    main()
