"""Write gait.csv and phase.csv: the gait formula in double precision or better."""

from __future__ import annotations

import csv
import math
import random
from decimal import Decimal, getcontext
from pathlib import Path

HERE = Path(__file__).resolve().parent
FRAME_US, ODD_FRAMES_US = 20_000, (16_670, 7_590, 3_290)
FRAMES_A_DAY = 24 * 3600 * 50
TURN = 1 << 32

getcontext().prec = 60
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")


def setpoint_deg(alpha: float, beta: float, offset: float, phase: int, joint: int) -> float:
    """Return offset + alpha sin(phase + joint beta) in degrees; phase in 2^-32 turns."""
    angle = 2 * math.pi * phase / TURN + joint * math.radians(beta)
    return offset + alpha * math.sin(angle)


def write_gait() -> None:
    """Write setpoints for edge phases and random ones, over all joints."""
    rng = random.Random(2005)
    edges = [k * TURN // 8 + d for k in range(8) for d in (-1, 0, 1)]
    rows = []
    for alpha, beta, offset in (
        (90.0, 75.0, 0.0),
        (70.0, 75.0, 0.0),
        (30.0, 80.0, 5.5),
        (14.25, -69.125, -12.0),
        (0.5, 180.0, 0.0),
        (0.0, 20.0, 3.0),
        (45.123, -180.0, 0.0),
        (89.999, 0.001, 0.0),
    ):
        for phase in [p % TURN for p in edges] + [rng.randrange(TURN) for _ in range(40)]:
            for joint in range(5):
                value = setpoint_deg(alpha, beta, offset, phase, joint)
                rows.append((alpha, beta, offset, phase, joint + 1, f"{value:.9f}"))
    columns = ("alpha_deg", "beta_deg", "offset_deg", "phase_2^-32_turn", "joint", "setpoint_deg")
    write(HERE / "gait.csv", columns, rows)


def write_phase() -> None:
    """Write the phase that a rate has reached after so many frames, to the last of 32 bits."""
    rows = []
    for omega in ("0.01", "0.1", "1", "1.7987", "3", "5", "6.283185", "10.138", "20", "30"):
        cases = [(FRAME_US, n) for n in (1, 50, 12345, 180000, FRAMES_A_DAY)]
        cases += [(frame_us, FRAMES_A_DAY) for frame_us in ODD_FRAMES_US]
        for frame_us, frames in cases:
            turns = Decimal(omega) * frame_us * frames / (2_000_000 * PI)
            phase = int((turns % 1) * TURN)
            rows.append((omega, frames, phase, frame_us))
    columns = ("omega_rad_s", "frames", "phase_2^-32_turn", "frame_us")
    write(HERE / "phase.csv", columns, rows)


def write(path: Path, columns: tuple[str, ...], rows: list[tuple]) -> None:
    """Write one table with its header."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)


if __name__ == "__main__":
    write_gait()
    write_phase()
