"""One push in a terminal's characters: its places over time, the law, and what is between them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...calibration.floor.arc import along
from ...calibration.floor.look import look_at
from ...model.errors import BadInput
from .terminal_plot import WIDE, chart

if TYPE_CHECKING:
    from ...calibration.kinds.coast import Coast

HIGH = 9
LEVELS = "▁▂▃▄▅▆▇█"
LEAST_MM = 1.0  # off the law, at either end of LEVELS: where less is off, it is noise


def push_picture(push: Coast) -> str:
    """Return the part that counts of a followed push with a law of its own; "" if none is there.

    The law has the frictions that fit this push alone, so that a kink or a wobble shows.
    """
    if push.track is None or push.by != "film":
        return ""
    track = np.asarray(push.track.values)
    try:
        look = look_at(*track.T)
    except BadInput:
        return ""
    t, x, y = track[(track[:, 0] >= look.start_s) & (track[:, 0] <= look.end_s)].T
    way = along(x, y, look.sigma_m)
    t, way = t - t[0], way - way[0]
    end_s = float(t[-1])
    every = np.linspace(0.0, end_s, WIDE)
    law_m = np.interp(every, t, look.law_m)
    top = max(1.05 * float(max(way.max(), law_m.max())), 1e-3)
    curves = [(every, law_m, "·"), (t, np.clip(way, 0.0, None), "o")]
    column = np.rint(t / end_s * (WIDE - 1)).astype(int)
    legend = f"o push {push.number}, {push.way}   · law of this push alone"
    strip = _off_the_law(column, 1000 * (way - look.law_m))
    return chart(curves, (0.0, end_s), top, ("m", "s", f"{legend}\n        {strip}"), HIGH)


def _off_the_law(column: np.ndarray, off_mm: np.ndarray) -> str:
    """Return a character a column, its mean distance off the law, and the scale below."""
    count = np.bincount(column, minlength=WIDE)
    mean = np.bincount(column, off_mm, minlength=WIDE) / np.maximum(count, 1)
    most = max(float(np.abs(mean).max()), LEAST_MM)
    level = np.rint((mean / most + 1) / 2 * (len(LEVELS) - 1)).astype(int)
    strip = "".join(LEVELS[k] if n else " " for k, n in zip(level, count, strict=True))
    return f"{strip}\n        off the law: {LEVELS[0]} {-most:.2g} to {LEVELS[-1]} {most:+.2g} mm"
