"""Times at equal error, read off the measured lines; the ratios and the table made of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from ...simulation.methods import METHODS
from .measure import OWN, Row

TARGETS = (1e-3, 1e-6, 1e-9)
TABLE_ERROR = 1e-6
TABLE_SCENES = {
    "paper6": "6 links",
    "n50": "50 links",
    "robot2005": "2005 robot, dry",
    "paper6_k1e3": "springs k = 1e3",
    "stiff_k1e7_c1": "k = 1e7, c = 1",
    "stiff_k1e7_c1e3": "k = 1e7, c = 1e3",
}
NOTHING = "–"
Points = list[tuple[float, float]]


def time_at(error: float, points: Sequence[tuple[float, float]]) -> float | None:
    """Return the least time that reaches an error, or None where no setting does.

    points: (error, time), from the loosest setting to the tightest. Between a point above the
    error and the next one at or below it, time is interpolated along the straight line in log-log;
    nothing is extrapolated: a first point already good enough counts with its own time.
    """
    times = [points[0][1]] if points and points[0][0] <= error else []
    for (e0, t0), (e1, t1) in pairwise(points):
        if e0 > error >= e1:
            # an error of exactly 0 has no logarithm: the point itself is then the answer
            f = math.log(e0 / error) / math.log(e0 / e1) if e1 > 0 else 1.0
            times.append(t0 ** (1 - f) * t1**f)
        elif e1 <= error:
            times.append(t1)
    return min(times, default=None)


def ours_first(rows: Sequence[Row]) -> list[Row]:
    """Return the rows with our methods in front, in the order of their table; peers as they are."""
    order = [f"{OWN} {name}" for name in METHODS]
    return sorted(rows, key=lambda r: order.index(r.method) if r.method in order else len(order))


def lines(rows: Sequence[Row], scene: str) -> dict[str, Points]:
    """Return (error, seconds a simulated second) of a scene by contender, without what failed."""
    points: dict[str, Points] = {row.method: [] for row in rows if row.scene == scene}
    for row in rows:
        if row.scene == scene and row.error is not None and row.time_s is not None:
            points[row.method].append((row.error, row.time_s / row.simulated_s))
    return points


def times_at(rows: Sequence[Row], scene: str, error: float) -> dict[str, float | None]:
    """Return each contender's time for a simulated second at an error, s; None: not reached."""
    return {method: time_at(error, points) for method, points in lines(rows, scene).items()}


def headline(rows: Sequence[Row]) -> list[dict[str, object]]:
    """Return, for each scene and error, our best method, the best peer, and how many times faster.

    ratio is above 1 where ours is the faster one, and missing where either does not get there.
    """
    return [
        _headline(scene, error, times_at(rows, scene, error))
        for scene in dict.fromkeys(row.scene for row in rows)
        for error in TARGETS
    ]


def _headline(scene: str, error: float, times: dict[str, float | None]) -> dict[str, object]:
    reached = sorted((time, method) for method, time in times.items() if time is not None)
    ours = next((x for x in reached if x[1].startswith(OWN)), (None, None))
    peer = next((x for x in reached if not x[1].startswith(OWN)), (None, None))
    line: dict[str, object] = {"scene": scene, "error": error, "ours": ours[1], "peer": peer[1]}
    return {**line, "ratio": peer[0] / ours[0]} if ours[0] and peer[0] else line


def _cell(time_s: float | None) -> str:
    """Return a time in ms."""
    return NOTHING if time_s is None else f"{1e3 * time_s:{'.2g' if time_s < 0.1 else '.0f'}}"


def table(rows: Sequence[Row]) -> str:
    """Return the documentation's table: ms of processor time a simulated second at TABLE_ERROR."""
    scenes = [s for s in TABLE_SCENES if any(row.scene == s for row in rows)]
    times = {scene: times_at(rows, scene, TABLE_ERROR) for scene in scenes}
    body = [
        [m, *(_cell(times[s][m]) if m in times[s] else "" for s in scenes)]
        for m in dict.fromkeys(row.method for row in ours_first(rows))
        if any(times[s].get(m) is not None for s in scenes)
    ]
    ratios = [_headline(s, TABLE_ERROR, times[s]).get("ratio") for s in scenes]
    last = ["**best peer / our best**", *(f"**{r:.2g}**" if r else NOTHING for r in ratios)]
    top = [["ms", *(TABLE_SCENES[s] for s in scenes)], ["---", *("---:" for _ in scenes)]]
    return "\n".join("| " + " | ".join(line) + " |" for line in [*top, *body, last])
