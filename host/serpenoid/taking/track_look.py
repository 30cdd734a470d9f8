"""Find the pushes in a track: the release, the stop, and what is doubtful.

Speeds over short pieces of the track serve only to find pushes; the fit uses positions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..base.errors import BadInput
from ..session.push import check_push
from ..session.track import Floats, chord_places, curved_path

PIECE_S = 0.15  # Time over which a speed is taken: four intervals at 30 Hz.
REST_S = 0.4  # Time at rest that counts, from which the place of the stop is known.
MIN_TIME_S = 0.4  # Duration of the shortest push that can be fitted.


class Look(NamedTuple):
    """The result of looking at the track of one push.

    cells: columns of its reading: the part that counts, the sigma of a position, increased for the
    correlation of neighbours, and the change of heading. way_m: displacement x, y from the release
    to the stop. doubts: reasons why the push should not be used.
    """

    cells: dict[str, float]
    way_m: Floats
    doubts: list[str]


def pushes_in(track: Floats) -> list[Floats]:
    """Return pieces of a track with one push each, and with the time at rest before and after it.

    A push is an interval of motion that ends at a distance from its start, so that the scatter of a
    robot at rest is none. Intervals without a rest between them are one. Carrying the robot back is
    found too; `look_at` or the person rejects it.
    """
    t, min_speed_m_s, min_distance_m = track[:, 0], 0.05, 0.02
    fast = np.flatnonzero(speeds(track) > min_speed_m_s)
    rests = (np.diff(fast) > 1) & (np.diff(t[fast]) >= REST_S / 2)
    spans_s = list[tuple[float, float]]()
    for places in np.split(fast, np.flatnonzero(rests) + 1) if len(fast) else ():
        (begin_s, *begin_m), (end_s, *end_m) = track[places[0]], track[places[-1]]
        if math.dist(begin_m, end_m) > min_distance_m and end_s - begin_s > MIN_TIME_S / 2:
            spans_s.append((begin_s, end_s))
    ends_s = [-math.inf, *(end for _, end in spans_s)]
    begins_s = [*(begin for begin, _ in spans_s[1:]), math.inf]
    return [
        track[(t >= max(ends_s[k], begin - 1.0)) & (t <= min(begins_s[k], end + 1.5))]
        for k, (begin, end) in enumerate(spans_s)
    ]


def look_at(track: Floats, slips: bool) -> Look:
    """Return what the track of one push shows; raises BadInput if it has none.

    slips: whether the robot may slip sideways, for lack of a straight link.
    """
    t, places = track[:, 0], track[:, 1:]
    speed = speeds(track)
    peak = int(np.argmax(speed))
    fingers_s = 0.07  # Time from the largest speed to the release.
    start = int(np.searchsorted(t, t[peak] + fingers_s)) if peak else 0
    stop, end = _stop_of(track, speed, peak)
    places_count, min_places, min_way_m = max(stop - start + 1, 0), 8, 0.2
    if places_count < min_places:
        raise BadInput(
            f"only {places_count} places between the hand and rest; {min_places} at least: film "
            "until the robot rests, and push harder"
        )
    along_m, left_m, _ = chord_places(*places[start : stop + 1].T)
    way, direction_rad = curved_path(along_m, left_m, sigma_m=0.001)
    way, time = way - way[0], t[start : stop + 1] - t[start]
    turned_rad = float(direction_rad[-1] - direction_rad[0])
    # v' = -(c v + f), integrated twice, is linear in start, initial speed, c and f.
    area = np.append(0.0, np.cumsum((way[1:] + way[:-1]) / 2 * np.diff(time)))
    design = np.column_stack([np.ones_like(time), time, -area, -(time**2) / 2])
    law = np.linalg.lstsq(design, way, rcond=None)[0]
    error = way - design @ law
    # The sigma of normal errors is 1.05 times the median difference of neighbours.
    noise_m = 1.05 * float(np.median(np.abs(np.diff(error))))
    sigma_m = max(math.sqrt(float(error @ error) / (len(way) - len(law))), 1e-5)
    correlation = float(error[1:] @ error[:-1] / max(float(error @ error), 1e-30))
    chance = 1 / math.sqrt(len(error))  # Sigma of the correlation of independent errors.
    correlation = min(max(correlation - chance, 0.0), 0.8)
    max_roughness = 2.5  # Scatter about the law over that of neighbours.
    way_m, rough = float(way[-1]), sigma_m / max(noise_m, 1e-4) > max_roughness
    first_m_s, max_stop_share = float(law[1]), 0.25  # With more final speed, something stopped it.
    # The fit's model includes the turn of a robot that slips down the floor's slope.
    max_turn_deg = 30.0 if slips else 10.0
    last_m_s = first_m_s - law[2] * way_m - law[3] * time[-1]
    check_push(first_m_s, way_m)
    doubts = {
        "the track ends before the robot rests: film on until it does": stop >= len(t) - 1,
        f"it rolled {way_m:.2f} m in {time[-1]:.2f} s only: push harder, {min_way_m} m at least": (
            way_m < min_way_m or time[-1] < MIN_TIME_S
        ),
        f"it turned by {math.degrees(turned_rad):+.0f} degrees while it rolled: it slipped "
        "sideways; push straighter, or align the links": (
            abs(math.degrees(turned_rad)) > max_turn_deg
        ),
        "it did not roll out evenly: did it hit something, was it touched, or do wheels wobble?": (
            rough or last_m_s > max_stop_share * first_m_s
        ),
    }
    cells = {
        "start_s": float(t[start]),
        "end_s": float(t[end]),
        "distance_sigma_m": sigma_m * math.sqrt((1 + correlation) / (1 - correlation)),
        "turned_deg": math.degrees(turned_rad),
    }
    words = [text for text, holds in doubts.items() if holds]
    return Look(cells, places[end] - places[start], words)


def speeds(track: Floats) -> Floats:
    """Return the speed at each position, m/s, (rows,), as a mean over PIECE_S."""
    t = track[:, 0]
    low = np.searchsorted(t, t - PIECE_S / 2)
    high = np.searchsorted(t, t + PIECE_S / 2, side="right") - 1
    sparse = high - low <= 1  # Frames are missing here.
    low, high = np.maximum(low - sparse, 0), np.minimum(high + sparse, len(t) - 1)
    t_s, x_m, y_m = (track[high] - track[low]).T
    return np.asarray(np.hypot(x_m, y_m) / t_s)


def _stop_of(track: Floats, speed: Floats, peak: int) -> tuple[int, int]:
    """Return the index of the stop after the largest speed, and of the last sample that counts.

    The rest ends when the robot is touched again. Both are the track's end if it does not stop.
    """
    # At rest the speed is below rest_share of the largest one. A robot that moves by touched_m from
    # there was touched.
    t, rest_share, touched_m = track[:, 0], 0.03, 0.03
    slow = np.flatnonzero(speed[peak:] < max(rest_share * speed[peak], 0.01))
    if not len(slow):
        return len(t) - 1, len(t) - 1
    # The rest begins with the first slow piece; a later one would hide a collision.
    stop = int(np.searchsorted(t, t[peak + slow[0]] - PIECE_S / 2))
    moved_m = np.hypot(*(track[stop:, 1:] - track[stop, 1:]).T)
    touched_s = np.min(t[stop:][moved_m > touched_m], initial=np.inf)
    end_s = min(t[stop] + REST_S, touched_s - PIECE_S)
    return stop, max(int(np.searchsorted(t, end_s, side="right")) - 1, stop)
