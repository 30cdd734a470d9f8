"""Draws what the calibration's studies found: coverage of intervals, shares of verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from serpenoid.show.plot import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, figure

Row = Mapping[str, Any]
WANTED = (0.93, 0.97)
_OF = {"ct": BLUE, "cn": ORANGE, "ft0": GREEN, "fn0": RED, "speed": GREY, "driven": "#000000"}

# What `compare` may say; several causes at once are GREEN.
_VERDICTS = {
    "agrees": GREY,
    "friction": BLUE,
    "amplitude": ORANGE,
    "servos": PURPLE,
    "neither": RED,
}


def coverage_figure(rows: Sequence[Row], path: Path) -> None:
    """Draw each case's coverage with two standard deviations of its own scatter."""
    with figure(8.0, 1.0 + 0.72 * len(rows)) as (fig, ax):
        ax.axvspan(*(100 * end for end in WANTED), color="#eeeeee", zorder=0)
        shown = {name: colour for name, colour in _OF.items() if name in rows[0]}
        for k, row in enumerate(rows):
            for j, (name, colour) in enumerate(shown.items()):
                at = k + 0.12 * (j - 2.5)
                label = {"label": name} if k == 0 else {}
                ax.errorbar(
                    100 * row[name],
                    at,
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
        ax.set_xlim(min(90.0, *(100 * row[n] - 2.5 for row in rows for n in shown)), 100.0)
        ax.grid(axis="y", visible=False)
        ax.set_xlabel("simulated sessions whose 95 % interval holds the truth (%)")
        ax.set_title(f"{rows[0]['sessions']} sessions a line; wanted: 93 to 97 %")
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        fig.savefig(path)


def verdict_figure(rows: Sequence[Row], path: Path) -> None:
    """Draw the shares of each verdict, one bar a fault; the right one is framed."""
    from matplotlib.patches import Patch

    colours = {word: _VERDICTS.get(word, GREEN) for word in rows[0]["counts"]}
    with figure(8.0, 1.6 + 0.27 * len(rows)) as (fig, ax):
        for k, row in enumerate(rows):
            left = 0.0
            for word, count in row["counts"].items():
                share = 100 * count / row["sessions"]
                frame = "black" if word == row["right"] else "none"
                ax.barh(k, share, 0.7, left, color=colours[word], edgecolor=frame, lw=1.8)
                left += share
        faults = [row["fault"].replace(" -", " −").replace("%", " %") for row in rows]
        ax.set_yticks(range(len(rows)), faults)
        ax.set_ylim(len(rows) - 0.4, -0.6)
        ax.set_xlim(0.0, 100.0)
        ax.grid(axis="y", visible=False)
        ax.set_xlabel(f"share of {rows[0]['sessions']} simulated sessions (%)")
        ax.set_ylabel("what was wrong with the robot or the measurement")
        shown = [Patch(color=c, label=word) for word, c in colours.items()]
        shown.append(Patch(fc="none", ec="black", lw=1.8, label="the right answer"))
        ax.legend(
            handles=shown,
            title="what `compare` names as the cause",
            alignment="left",
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=4,
            fontsize=8,
            columnspacing=1.2,
            handlelength=1.4,
        )
        fig.savefig(path)
