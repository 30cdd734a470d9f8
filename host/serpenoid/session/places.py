"""Places over time of a short reading, as one word: `0:0,2:0.045,4:0.13` is s:m, three times."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np

from ..base.errors import BadInput
from .track import Floats

LEAST_S, MOST_S = 1.0, 60.0
EXAMPLE = "0:0 2:0.045 4:0.13"
_PAIR = re.compile(r"(\d+(?:[.,]\d*)?):([+-]?\d*[.,]?\d+)")


def tidy_places(text: str) -> str:
    """Return pairs as they are kept; raises BadInput unless they are a track.

    Pairs are parted by blanks, semicolons or slashes, or by commas where nothing else parts them.
    """
    line = text.replace("−", "-").strip()
    parts = re.split(r"[\s;/]+|,(?=\s)", line) if re.search(r"[\s;/]", line) else line.split(",")
    matches = [_PAIR.fullmatch(part) for part in parts if part]
    if not all(matches) or len(matches) < 3:
        raise BadInput(
            f"{text!r} is no track; type three places or more as seconds:metres, uphill +, such "
            f"as {EXAMPLE}"
        )
    pairs = [[float(x.replace(",", ".")) for x in pair.groups()] for pair in matches if pair]
    times = [t for t, _ in pairs]
    if any(later <= t for t, later in pairwise(times)):
        raise BadInput(f"the times of {text!r} must rise from place to place")
    if not LEAST_S <= times[-1] - times[0] <= MOST_S:
        raise BadInput(
            f"{text!r} lasts {times[-1] - times[0]:g} s; it must be {LEAST_S:g} to {MOST_S:g} s; "
            "a robot that holds longer is read with its drift alone"
        )
    return ",".join(f"{t:.6g}:{y:.6g}" for t, y in pairs)


def track_of(places: str) -> Floats:
    """Return t_s and y_m (uphill) of kept pairs, (2, J), the time from the first place on."""
    pairs = [[float(x) for x in pair.split(":")] for pair in places.split(",") if pair]
    track = np.array(pairs, dtype=np.float64).reshape(-1, 2).T
    return track - track[:, :1]


def drifts(places: str) -> tuple[float, float, float]:
    """Return the mean drift, m/s uphill, by how much it changed, and the time watched, s."""
    t, y = track_of(places)
    curve = np.polyfit(t, y, 2)
    return float(y[-1] / t[-1]), float(2 * curve[0] * t[-1]), float(t[-1])
