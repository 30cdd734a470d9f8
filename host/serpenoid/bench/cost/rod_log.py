"""What gaits a rod followed, kept line by line: an interrupted search goes on from its file."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

import serpenoid as sn

from ...model.errors import BadInput

_NUMBERS = ("omega_rad_s", "alpha_rad", "beta_rad", "speed_m_s", "bend_error_rad", "seconds")


@dataclass(frozen=True, slots=True)
class Tried:
    """Hold one gait that a rod followed: speed in m/s, nan where the rod burst."""

    number: int
    omega_rad_s: float
    alpha_rad: float
    beta_rad: float
    speed_m_s: float
    cycles: int
    bend_error_rad: float
    seconds: float

    @property
    def told(self) -> str:
        """Return the run in words."""
        speed = "burst" if math.isnan(self.speed_m_s) else f"{self.speed_m_s:.4f} m/s"
        return (
            f"alpha {math.degrees(self.alpha_rad):.1f} deg, "
            f"beta {math.degrees(self.beta_rad):.1f} deg: {speed}"
        )


class Log:
    """A search's runs in a file, in order; what stands there is not followed again."""

    def __init__(self, path: Path, follow: Callable[[int, sn.Gait], Tried]) -> None:
        self.path, self.follow, self.rows = path, follow, _read(path)
        self._next = 0

    def tried(self, gait: sn.Gait) -> tuple[Tried, bool]:
        """Return the next line, followed now or before, and whether it was before."""
        number, self._next = self._next, self._next + 1
        if number < len(self.rows):
            return self._same(self.rows[number], gait), True
        row = self.follow(number + 1, gait)
        new = not self.rows
        with self.path.open("w" if new else "a", newline="") as file:
            writer = csv.DictWriter(file, [f.name for f in fields(Tried)])
            if new:
                writer.writeheader()
            writer.writerow(asdict(row))
        self.rows.append(row)
        return row, False

    def _same(self, row: Tried, gait: sn.Gait) -> Tried:
        was, now = ([getattr(g, n) for n in ("alpha_rad", "beta_rad", "omega_rad_s")]
                    for g in (row, gait))  # fmt: skip
        if not np.allclose(was, now, rtol=0, atol=1e-9):
            raise BadInput(
                f"{self.path} holds another search: run {row.number} was {np.round(was, 4)} "
                f"(alpha, beta, omega), now {np.round(now, 4)} is asked for; give its seed and "
                "rate, remove the file, or name another folder"
            )
        return row


def _read(path: Path) -> list[Tried]:
    """Return a file's lines, without a last one that was cut off; the file is left without, too."""
    if not path.exists():
        return []
    try:
        text = path.read_text()
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            path.write_text(whole)
        rows = csv.DictReader(whole.splitlines())
        return [
            Tried(int(row["number"]), cycles=int(row["cycles"]),
                  **{name: float(row[name]) for name in _NUMBERS})
            for row in rows
        ]  # fmt: skip
    except (KeyError, ValueError, TypeError) as error:
        raise BadInput(
            f"{path} is not a search's log ({error}); remove it, or name another folder"
        ) from None
