"""Write periodic_viscous.csv: run `python -m reference.generate_viscous` from tests/host (minutes).

Columns: the robot and ground per link (SI), the gait (rad, rad/s), then periodic.Periodic's fields;
`speed_check_m_s` is the change of the speed when the orbit is marched with other steps and a
tolerance four times finer, `fourier_tail` the relative size of the powers' unresolved harmonics.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np

from . import periodic
from .params import Gait, Params, gait_deg, robot_2005

FILE = Path(__file__).with_name("periodic_viscous.csv")
INPUTS = ["links", "mass_kg", "half_length_m", "inertia_kg_m2", "ct", "cn"]
INPUTS += ["alpha_rad", "beta_rad", "omega_rad_s", "offset_rad"]
RESULTS = ["speed_m_s", "speed_link1_m_s", "mean_speed_m_s"]
RESULTS += ["turn_rad_per_cycle", "power_w", "abs_power_w", "positive_power_w"]
RESULTS += ["u0_x_m_s", "u0_y_m_s", "u0_spin_rad_s"]
RESULTS += [f"multiplier{i}_{part}" for i in (1, 2, 3) for part in ("re", "im")]
RESULTS += ["speed_check_m_s", "fourier_tail"]


def cases() -> list[tuple[Params, Gait]]:
    """Return the gaits of the table."""
    paper = Params(6)
    robot = robot_2005()
    plain = Params(6, 0.0756, 0.038, None, robot.ct, robot.cn)
    six = [(30, 80, w) for w in (0.3, 1, 2, 3, 5, 8, 10, 15, 20)]
    six += [(5, 80, 5), (15, 60, 5), (45, 90, 5), (60, 60, 3), (75, 45, 5), (90, 75, 2)]
    six += [(110, 60, 1), (110, 120, 5), (20, 20, 5), (75, 20, 1), (75, 20, 20), (50, 20, 10)]
    six += [(30, 120, 8), (5, 20, 20), (75, 90, 20), (31.77, 83.7, 1.7987), (25.48, 86.66, 10.138)]
    table = [(paper, gait_deg(*gait)) for gait in six]
    by_links = [(2, 30, 80, 5), (3, 30, 90, 3), (3, 75, 60, 10), (4, 40, 70, 5), (4, 20, 110, 12)]
    by_links += [(5, 35, 75, 6), (9, 30, 50, 5), (9, 70, 30, 2), (12, 25, 40, 8), (12, 60, 35, 1)]
    by_links += [(20, 15, 30, 5), (20, 30, 20, 3), (20, 90, 45, 1)]
    table += [(Params(n), gait_deg(*gait)) for n, *gait in by_links]
    table += [(plain, gait_deg(70, 75, w)) for w in (0.5, 1, 3, 5, 10, 15)]
    odd = [(0.3, 0.05, 1e-4, 0.5, 2.0), (2.0, 0.1, 0.02, 1.0, 30.0), (1.0, 0.06, None, 1.0, 1.0)]
    odd += [(1.0, 0.06, None, 10.0, 0.1), (0.05, 0.02, None, 0.01, 5.0)]
    table += [(Params(6, *row), gait_deg(40, 70, 6)) for row in odd]
    table += [(Params(3, *odd[0]), gait_deg(60, 100, 4)), (Params(9, *odd[1]), gait_deg(35, 45, 4))]
    turning = [(6, 30, 80, 5, 5), (6, 30, 80, 5, -5), (6, 45, 60, 2, 15), (6, 60, 75, 10, 10)]
    turning += [(3, 40, 90, 3, 20), (4, 30, 80, 8, -12), (9, 30, 45, 5, 4), (12, 25, 35, 3, 3)]
    return table + [(Params(n), gait_deg(*gait)) for n, *gait in turning]


def inputs(p: Params, gait: Gait) -> list[float]:
    """Return the first columns of a row."""
    robot = [p.links, p.mass_kg, p.half_length_m, p.inertia, p.ct, p.cn]
    return [*robot, gait.alpha_rad, gait.beta_rad, gait.omega_rad_s, gait.offset_rad]


def parsed(row: dict[str, str]) -> tuple[Params, Gait, dict[str, float]]:
    """Return robot, gait and the results of one row of the table."""
    number = {key: float(value) for key, value in row.items()}
    first = [number[key] for key in INPUTS]
    return Params(int(first[0]), *first[1:6]), Gait(*first[6:]), number


def table() -> list[tuple[Params, Gait, dict[str, float]]]:
    """Return the rows of periodic_viscous.csv."""
    with FILE.open(newline="") as file:
        return [parsed(row) for row in csv.DictReader(file)]


def results(p: Params, gait: Gait) -> list[float]:
    """Return the last columns of a row."""
    found = periodic.steady(p, gait, 512 if p.links < 9 else 1024)
    finer = periodic.march(p, gait, found.u0, 1, rtol=2.5e-14, steps=150)[-1]
    speed = np.hypot(*finer[4:6]) / gait.period_s
    head = [found.speed_m_s, found.speed_link1_m_s, found.mean_speed_m_s]
    head += [
        found.turn_rad_per_cycle,
        found.power_w,
        found.abs_power_w,
        found.positive_power_w,
        *found.u0,
    ]
    multipliers = [part for value in found.multipliers for part in (value.real, value.imag)]
    check = abs(speed - found.speed_link1_m_s)
    if abs(found.power_w - found.dissipation_w) > 1e-11 * found.abs_power_w:
        raise RuntimeError(f"power {found.power_w} is not the loss {found.dissipation_w}")
    return [*head, *multipliers, check, found.fourier_tail]


def main() -> None:
    """Write the table, a line of progress per gait."""
    with FILE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(INPUTS + RESULTS)
        for p, gait in cases():
            row = results(p, gait)
            writer.writerow(
                [f"{value:.17g}" for value in inputs(p, gait)]
                + [f"{value:.13g}" for value in row[:-2]]
                + [f"{value:.1e}" for value in row[-2:]]
            )
            file.flush()
            print(p.links, gait, f"{row[0]:.6g} {row[-2]:.1e} {row[-1]:.1e}", file=sys.stderr)


if __name__ == "__main__":
    main()
