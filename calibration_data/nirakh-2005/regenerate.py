"""Compute readings.csv from the two lines that the 2005 paper published (its points are lost).

Run `python calibration_data/nirakh-2005/regenerate.py` to see the rows, with `> readings.csv` to
keep them. Straight, Eq. 58 with the line of Eq. 59 gives the belt speed at which the snake holds
its station; bent, Eq. 60 with the lines of Eqs. 59 and 62. The inclines and the top speed are those
of session.toml.
"""

import csv
import io
import math
from itertools import count
from pathlib import Path

from serpenoid.session.folder import READING_COLUMNS, read_session, reading_row
from serpenoid.session.session import Setup

CT_N_S_M, FT0_N = 0.084, 0.14  # Eq. 59, whole snake
CN_N_S_M, FN0_N = 1.2, 0.27  # Eq. 62, whole snake


def belt_speed_m_s(weight_n: float, incline_rad: float, lambda_rad: float) -> float:
    """Solve F_t cos(lambda) + F_n sin(lambda) = m g sin(gamma), Eqs. 58 and 60, for the speed.

    With v_t = v cos(lambda) and v_n = v sin(lambda); negative where the static friction holds.
    """
    c, s = math.cos(lambda_rad), math.sin(lambda_rad)
    dry_n = FT0_N * c + FN0_N * s
    return (weight_n * math.sin(incline_rad) - dry_n) / (CT_N_S_M * c**2 + CN_N_S_M * s**2)


def rows(setup: Setup) -> list[dict[str, str]]:
    """Return one row for each station, with rising inclines up to the top speed of the belt."""
    readings: list[dict[str, str]] = []
    plan = setup.plan
    for lambda_rad in map(math.radians, plan.lambda_deg):
        law = "Eqs. 59 and 62 through Eq. 60" if lambda_rad else "Eq. 59 through Eq. 58"
        for step in count():
            incline_deg = plan.incline_start_deg + step * plan.incline_step_deg
            # The speed belongs to the rounded incline, which is the one in the file.
            incline_deg = round(incline_deg, 3)
            speed_m_s = belt_speed_m_s(setup.weight_n, math.radians(incline_deg), lambda_rad)
            if speed_m_s > plan.belt_speed_max_m_s:
                break
            if speed_m_s <= 0.0:
                continue  # the wheels stick
            station = {
                "lambda_deg": str(round(math.degrees(lambda_rad), 3)),
                "incline_deg": str(incline_deg),
                "belt_speed_m_s": f"{speed_m_s:.6f}",
                "drift_m_s": "0.0",
            }
            common = {"setup": "1", "comment": f"regenerated from {law}"}
            common["reading"] = str(len(readings) + 1)
            readings.append(reading_row("station", station) | common)
    return readings


def text() -> str:
    """Return the whole of readings.csv."""
    out = io.StringIO()
    writer = csv.DictWriter(out, READING_COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows(read_session(Path(__file__).parent).setup))
    return out.getvalue()


if __name__ == "__main__":
    print(text(), end="")
