"""Tracks: positions over time, in a file beside the session whose hash its reading has.

A push on a floor, a crawl in a film, or a robot that drifts on the belt; a short one may be typed
as s:m, three times or more: `0:0 2:0.045 4:0.13`.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..base.errors import BadInput, RecordingFailed
from ..base.files import csv_rows, read_text, write_text

FOLDER = "tracks"
TRACK = ("t_s", "x_m", "y_m")
PLACES = "places"  # cell of a typed track
Floats = NDArray[np.float64]
Samples = Sequence[Sequence[float]] | Floats
EXAMPLE = "0:0 2:0.045 4:0.13"


@dataclass(frozen=True, eq=False)
class Track:
    """Samples of one reading.

    columns: names with units, such as t_s. values: (samples, columns), SI. sha256: of the file's
    bytes.
    """

    columns: tuple[str, ...]
    values: Floats
    sha256: str

    @classmethod
    def from_samples(cls, columns: tuple[str, ...], values: Samples) -> Track:
        """Return a track of these samples; raises BadInput unless they are finite numbers.

        A last column with a star stands for any number of them; there NaN says "not seen".
        """
        samples = np.array(values, dtype=np.float64)
        *fixed, last = columns
        numbers = range(1, samples.shape[-1] - len(fixed) + 1) if samples.ndim else ()
        joints = [last.replace("*", str(k)) for k in numbers] if "*" in last else [last]
        names = *fixed, *joints
        if samples.shape[1:] != (len(names),) or len(samples) <= 1:
            raise BadInput(
                f"a track of {samples.shape} is none; it must be (samples, {len(columns)}) for "
                f"{', '.join(columns)}, with two samples at least"
            )
        seen_always = samples[:, : len(columns) - last.count("*")]
        if np.isinf(samples).any() or np.isnan(seen_always).any():
            raise BadInput("a track has a sample that is no finite number; leave that sample out")
        text = _text(names, samples)
        samples.flags.writeable = False
        return cls(names, samples, hashlib.sha256(text.encode()).hexdigest())

    def write(self, folder: Path, number: int) -> str:
        """Put the file of a reading's track onto the disk; return its name in the folder."""
        name = f"{FOLDER}/{number:04}.csv"
        path = folder / name
        try:
            path.parent.mkdir(exist_ok=True)
            write_text(path, _text(self.columns, self.values))
        except OSError as error:
            raise RecordingFailed(
                f"{path}: {error.strerror}: the track is not saved, all before it is; make room "
                "on the disk first"
            ) from error
        return name

    def __repr__(self) -> str:
        return f"Track({self.sha256})"


def read_track(path: Path, columns: tuple[str, ...], sha256: str) -> Track:
    """Read a track's file; raises BadInput if it is not there, or not the one that was written."""
    if not path.is_file():
        raise BadInput(f"{path}: the track is not there, but a reading names it; restore the file")
    text = read_text(path)
    if hashlib.sha256(text.encode()).hexdigest() != sha256:
        raise BadInput(
            f"{path}: the track was changed since it was taken; restore the file from a backup"
        )
    rows = csv_rows(text, path)
    return Track.from_samples(columns, [[float(cell) for cell in row] for row in rows[1:]])


def _text(columns: tuple[str, ...], values: Floats) -> str:
    lines = [",".join(f"{value:.9g}" for value in row) for row in values.tolist()]
    return "\n".join([",".join(columns), *lines]) + "\n"


def typed_track(text: str) -> Floats:
    """Return t_s, x_m, y_m (rows, 3) of typed places, from the first one on; raises BadInput.

    Pairs are parted by blanks, semicolons or slashes, or by commas where nothing else parts them.
    """
    line = text.replace("−", "-").strip()
    parts = re.split(r"[\s;/]+|,(?=\s)", line) if re.search(r"[\s;/]", line) else line.split(",")
    pair, min_places = r"(\d+(?:[.,]\d*)?):([+-]?\d*[.,]?\d+)", 3
    matches = [re.fullmatch(pair, part) for part in parts if part]
    if not all(matches) or len(matches) < min_places:
        raise BadInput(
            f"{text!r} is no track; type three places or more as seconds:metres, uphill +, such "
            f"as {EXAMPLE}"
        )
    pairs = [[float(x.replace(",", ".")) for x in pair.groups()] for pair in matches if pair]
    track = np.insert(np.array(pairs) - pairs[0], 2, 0.0, axis=1)
    if not (np.diff(track[:, 0]) > 0.0).all():
        raise BadInput(f"the times of {text!r} must rise from place to place")
    min_s, max_s = 1.0, 60.0
    if not min_s <= track[-1, 0] <= max_s:
        raise BadInput(
            f"{text!r} lasts {track[-1, 0]:g} s; it must be {min_s:g} to {max_s:g} s; "
            "a robot that holds longer is read with its drift alone"
        )
    return track


def chord_places(x_m: Floats, y_m: Floats) -> tuple[Floats, Floats, float]:
    """Return places along the chord and to the left of it, m, and the chord's direction, rad.

    The chord goes from the first eighth of the places to the last.
    """
    eighth = max(1, len(x_m) // 8)
    dx, dy = (float(np.mean(v[-eighth:]) - np.mean(v[:eighth])) for v in (x_m, y_m))
    chord_rad = float(np.arctan2(dy, dx))
    c, s = np.cos(chord_rad), np.sin(chord_rad)
    return c * x_m + s * y_m, c * y_m - s * x_m, chord_rad


def curved_path(along_m: Floats, left_m: Floats, sigma_m: float) -> tuple[Floats, Floats]:
    """Return the way along the path at each place, m, and its direction to the chord, rad.

    along_m, left_m: places on the chord. The path is a parabola through them, so that their scatter
    across adds nothing to the way; on too short a way it is the chord.
    """
    min_scatters = 20.0  # shorter ways, in the scatter of a place, have no direction
    if np.ptp(along_m) < min_scatters * sigma_m:
        return along_m, np.zeros_like(along_m)
    slope = np.polyder(np.polyfit(along_m, left_m, 2))
    longer_m = np.polyval(np.polyint(0.5 * np.polymul(slope, slope)), along_m)
    return along_m + longer_m - longer_m[0], np.arctan(np.polyval(slope, along_m))
