"""Tracks: positions over time, each in a file whose hash is in its reading's row.

A track is of a push on a floor, of a gait run in a film, or of a robot that drifts on the belt. A
short one may be typed as three or more seconds:metres: `0:0 2:0.045 4:0.13`.
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
PLACES = "places"  # Column of a typed track.
Floats = NDArray[np.float64]
Samples = Sequence[Sequence[float]] | Floats
EXAMPLE = "0:0 2:0.045 4:0.13"


@dataclass(frozen=True, eq=False)
class Track:
    """The track of one reading.

    columns: names with units, such as t_s. values: (samples, columns), in SI. sha256: hash of the
    file's bytes.
    """

    columns: tuple[str, ...]
    values: Floats
    sha256: str

    @classmethod
    def from_samples(cls, columns: tuple[str, ...], values: Samples) -> Track:
        """Return the track of samples; raises BadInput unless they are finite numbers.

        A last column with a star stands for any number of columns, in which NaN is allowed.
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
        """Write a track's file for a reading; return its name. Raises RecordingFailed."""
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
    """Return the track of a file; raises BadInput if it is missing or was changed."""
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
    """Return a typed track, (rows, 3) of t_s, x_m and y_m = 0, from its first point; or BadInput.

    Pairs are separated by blanks, semicolons or slashes, or by commas alone.
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
    """Return positions along the chord and to the left of it, m, and the chord's direction, rad.

    The chord connects the means of the first and of the last eighth of the positions.
    """
    eighth = max(1, len(x_m) // 8)
    dx, dy = (float(np.mean(v[-eighth:]) - np.mean(v[:eighth])) for v in (x_m, y_m))
    chord_rad = float(np.arctan2(dy, dx))
    c, s = np.cos(chord_rad), np.sin(chord_rad)
    return c * x_m + s * y_m, c * y_m - s * x_m, chord_rad


def curved_path(along_m: Floats, left_m: Floats, sigma_m: float) -> tuple[Floats, Floats]:
    """Return the path length at each position, m, and the path's direction to the chord, rad.

    along_m, left_m: positions relative to the chord. The path is a parabola fitted to them, so that
    their scatter across does not lengthen it; a very short path is the chord.
    """
    min_scatters = 20.0  # Shortest path with a direction, in sigmas of a position.
    if np.ptp(along_m) < min_scatters * sigma_m:
        return along_m, np.zeros_like(along_m)
    slope = np.polyder(np.polyfit(along_m, left_m, 2))
    longer_m = np.polyval(np.polyint(0.5 * np.polymul(slope, slope)), along_m)
    return along_m + longer_m - longer_m[0], np.arctan(np.polyval(slope, along_m))
