"""Draws how often intervals hold the truth, as the calibration's studies found it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from serpenoid.show.plot import BLUE, GREEN, GREY, ORANGE, RED, figure

Row = Mapping[str, Any]
COVERAGE_RANGE = (0.93, 0.97)
_COLOURS = {"ct": BLUE, "cn": ORANGE, "ft0": GREEN, "fn0": RED, "speed": GREY, "driven": "#000000"}


def coverage_figure(rows: Sequence[Row], path: Path) -> None:
    """Draw each case's coverage with two standard deviations of its own scatter."""
    with figure(8.0, 1.0 + 0.72 * len(rows)) as (fig, ax):
        ax.axvspan(*(100 * end for end in COVERAGE_RANGE), color="#eeeeee", zorder=0)
        shown = {name: colour for name, colour in _COLOURS.items() if name in rows[0]}
        for k, row in enumerate(rows):
            for j, (name, colour) in enumerate(shown.items()):
                height = k + 0.12 * (j - 2.5)
                label = {"label": name} if k == 0 else {}
                ax.errorbar(
                    100 * row[name],
                    height,
                    xerr=200 * row["sigma"],
                    fmt="o",
                    ms=5,
                    lw=1.2,
                    color=colour,
                    **label,
                )
        ax.axvline(95.0, color=GREY, lw=1.0)
        ax.set_yticks(range(len(rows)), [row["case"].replace("lambda", "λ") for row in rows])
        ax.set_ylim(len(rows) - 0.5, -0.5)
        lowest = min(min(row[name] for name in shown) for row in rows)
        ax.set_xlim(min(90.0, 100 * lowest - 2.5), 100.0)
        ax.grid(axis="y", visible=False)
        ax.set_xlabel("simulated sessions whose 95 % interval holds the truth (%)")
        ax.set_title(f"{rows[0]['sessions']} sessions a line; wanted: 93 to 97 %")
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        fig.savefig(path)
