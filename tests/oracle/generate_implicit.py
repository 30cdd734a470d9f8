"""Write periodic_implicit.csv: `python -m reference.generate_implicit` from tests/host (minutes).

Six (or three) links of the paper's search (m = 1 kg, l = 0.06 m, C_t = 0.1, C_n = 10 N s/m): the
speed of the spring-and-damper model against the exact one, and the slowest Floquet multiplier.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from . import implicit_periodic, periodic
from .implicit import Spring
from .params import Params, gait_deg

FILE = Path(__file__).with_name("periodic_implicit.csv")
COLUMNS = ["links", "alpha_deg", "beta_deg", "omega_rad_s", "stiffness_n_m", "damping_n_s_m"]
COLUMNS += ["speed_m_s", "exact_speed_m_s", "multiplier"]
CASES = [(3, 30, 90, 3, 1e3, 1.0), (3, 30, 90, 10, 1e3, 1.0), (3, 30, 90, 10, 1e4, 10.0)]
CASES += [(6, 30, 80, omega, 1e3, 1.0) for omega in (5, 10, 20)]
CASES += [(6, 30, 80, 20, 1e4, 1.0), (6, 30, 80, 10, 1e3, 10.0)]


def table() -> list[dict[str, float]]:
    """Return the rows of periodic_implicit.csv."""
    with FILE.open(newline="") as file:
        return [{key: float(text) for key, text in row.items()} for row in csv.DictReader(file)]


def results(case: tuple[float, ...], rtol: float = 1e-11) -> tuple[float, float, float]:
    """Return implicit speed, exact speed (m/s) and slowest multiplier of one of CASES."""
    links, alpha, beta, omega, stiffness, damping = case
    p, gait = Params(int(links)), gait_deg(alpha, beta, omega)
    exact = periodic.steady(p, gait)
    spring = Spring(stiffness, damping)
    speed, multiplier = implicit_periodic.speed(p, spring, gait, exact.u0, rtol)
    return speed, exact.speed_m_s, multiplier


def main() -> None:
    """Write the table, a line of progress per gait."""
    with FILE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for case in CASES:
            found = results(case)
            writer.writerow([f"{v:g}" for v in case] + [f"{v:.10g}" for v in found])
            file.flush()
            print(case, found, file=sys.stderr)


if __name__ == "__main__":
    main()
