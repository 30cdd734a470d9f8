"""A track of a push looked at at once: where the hand let go, where it rests, what is wrong.

Nothing is differentiated for the fit: slopes over short pieces serve only to find the pieces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base.errors import BadInput
from ..friction.arc import chord_places, curved_path
from ..friction.parameters import Floats
from ..friction.rolling_law import way_m

PIECE_S = 0.13  # over which a speed is taken
AFTER_S = 0.07  # from the fastest moment: the fingers are gone
RESTED_S = 0.4  # of rest that counts: it tells where the robot stopped
SLOW = 0.03  # of the greatest speed: it rests
MOVES_M_S = 0.05  # a push is faster than this
LEAST_M, LEAST_S = 0.2, 0.4  # of a push worth fitting
FEWEST = 8
# Of a path. That of a robot which slips down the floor's slope turns by itself: the fit knows it.
MOST_TURN_RAD, MOST_SLIP_RAD = math.radians(10.0), math.radians(30.0)
ROUGH = 2.5  # scatters about the law, over those between neighbours: something happened
FEWEST_M_S = 0.35  # at the start; less tells no viscous part
LONGEST_GAP_S = 0.25
NEAR_M = 0.02  # less is no push
LAST = 0.6  # of the way: if the hand is there until then, little is left


@dataclass(frozen=True)
class Look:
    """What a track of one push shows.

    start_s, end_s: the part that counts. speed_m_s: at its start. way_m, time_s: until it rests.
    turned_rad: + to the left. sigma_m: scatter of a place, grown by what neighbours share. doubts:
    what is wrong, in words; empty if all is well. law_m: at each place that counts, by the law with
    frictions of this push's own.
    """

    start_s: float
    end_s: float
    speed_m_s: float
    way_m: float
    time_s: float
    turned_rad: float
    sigma_m: float
    doubts: tuple[str, ...]
    law_m: Floats

    def cells(self) -> dict[str, float]:
        """Return a reading's cells."""
        return {
            "start_s": self.start_s,
            "end_s": self.end_s,
            "distance_sigma_m": self.sigma_m,
            "turned_deg": math.degrees(self.turned_rad),
        }


def pushes_in(t_s: Floats, x_m: Floats, y_m: Floats) -> list[slice]:
    """Return the pieces of a track that hold a push each, with the rest about them.

    A push is a stretch faster than MOVES_M_S that ends NEAR_M at least from where it began; those
    with no rest between are one. So the scatter of a robot at rest is none. Carrying the robot back
    is one, and is left out by what `look_at` says of it, or by hand.
    """
    t, x, y = (np.asarray(v, dtype=float) for v in (t_s, x_m, y_m))
    moves = np.concatenate([[0], speeds(t, x, y) > MOVES_M_S, [0]]).astype(int)
    first, last = np.flatnonzero(np.diff(moves)).reshape(-1, 2).T
    if not len(first):
        return []
    last = last - 1
    rested = t[first[1:]] - t[last[:-1]] >= RESTED_S / 2
    first, last = first[np.append(True, rested)], last[np.append(rested, True)]
    far = np.hypot(x[last] - x[first], y[last] - y[first]) > NEAR_M
    far &= t[last] - t[first] > LEAST_S / 2
    begins, ends = t[first[far]], t[last[far]]
    between = (ends[:-1] + begins[1:]) / 2
    low = np.searchsorted(t, np.maximum(np.append(-np.inf, between), begins - 1.0))
    high = np.searchsorted(t, np.minimum(np.append(between, np.inf), ends + 1.5), side="right")
    return [slice(*ends) for ends in zip(low.tolist(), high.tolist(), strict=True)]


def look_at(t_s: Floats, x_m: Floats, y_m: Floats, slips: bool = False) -> Look:
    """Look at the track of one push; raises BadInput where there is none.

    slips: no straight link holds the robot on its path.
    """
    t, x, y = (np.asarray(v, dtype=float) for v in (t_s, x_m, y_m))
    _check(t, x, y)
    speed = speeds(t, x, y)
    peak = int(np.argmax(speed))
    if speed[peak] < MOVES_M_S:
        raise BadInput(
            f"nothing moves in this track: {speed[peak]:.2g} m/s at most; is its unit right?"
        )
    # some time after the fastest place, the hand being gone
    start = int(np.searchsorted(t, t[peak] + AFTER_S)) if peak else 0
    rest, touched = _rest(t, x, y, speed, peak)
    end = int(np.searchsorted(t, t[min(rest, len(t) - 1)] + RESTED_S, side="right")) - 1
    end = min(end, touched - 1)
    part = slice(start, end + 1)
    moving = slice(start, rest + 1)
    if end - start + 1 < FEWEST:
        raise BadInput(
            f"only {max(end - start + 1, 0)} places between the hand and the end of the track; "
            f"{FEWEST} at least: film until the robot rests, and push harder"
        )
    noise = _noise(t[part], x[part], y[part])
    way = curved_path(*chord_places(x[part], y[part])[:2], noise)[0]
    way = way - way[0]
    fitted, sigma, speed_m_s = _own_path(t[part] - t[start], way)
    direction_rad = curved_path(*chord_places(x[moving], y[moving])[:2], 0.0)[1]
    turned = float(direction_rad[-1] - direction_rad[0]) if rest - start > 3 else 0.0
    at, rough = (start, rest, end), sigma / max(noise, 1e-4)
    doubts = _doubts(t, at, float(way[-1]), speed_m_s, (turned, slips), rough)
    return Look(
        float(t[start]),
        float(t[end]),
        speed_m_s,
        float(way[-1]),
        float(t[rest] - t[start]),
        turned,
        sigma * _shared(way - fitted),
        tuple(doubts),
        fitted,
    )


def _check(t: Floats, x: Floats, y: Floats) -> None:
    if len(t) < FEWEST or not (len(t) == len(x) == len(y)):
        raise BadInput(f"a track has {len(t)} places; {FEWEST} at least")
    if not all(np.isfinite(v).all() for v in (t, x, y)):
        raise BadInput("a track has a place that is no finite number; leave it out")
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        raise BadInput(
            f"times must rise: {t[back[0] + 1]:.6g} s comes after {t[back[0]]:.6g} s; is the first "
            "column the time?"
        )


def speeds(t: Floats, x: Floats, y: Floats) -> Floats:
    """Return speeds, each the slope of a line through the piece of PIECE_S about it."""
    low = np.searchsorted(t, t - PIECE_S / 2 - 1e-9)
    high = np.searchsorted(t, t + PIECE_S / 2 + 1e-9, side="right")
    few = high - low < 3
    low, high = (
        np.where(few, np.maximum(low - 1, 0), low),
        np.where(few, np.minimum(high + 1, len(t)), high),
    )
    count = high - low

    def sums(values: Floats) -> Floats:
        total = np.concatenate([[0.0], np.cumsum(values)])
        return total[high] - total[low]

    centred = t - t.mean()
    mean = sums(centred) / count
    spread = np.maximum(sums(centred * centred) - count * mean**2, 1e-12)
    rates = [(sums(centred * v) - mean * sums(v)) / spread for v in (x - x.mean(), y - y.mean())]
    return np.hypot(*rates)


def _rest(t: Floats, x: Floats, y: Floats, speed: Floats, peak: int) -> tuple[int, int]:
    """Return the first place at rest after the fastest, and the first where it was touched again.

    Both the track's end where there is none.
    """
    slow = np.flatnonzero(speed[peak:] < max(SLOW * speed[peak], 0.01))
    if not len(slow):
        return len(t) - 1, len(t)
    rest = peak + int(slow[0])
    calm = (t >= t[rest]) & (t <= t[rest] + RESTED_S)
    at = [float(np.median(v[calm])) for v in (x, y)]
    off = np.hypot(x - at[0], y - at[1])
    far = max(0.01, 6 * float(np.median(off[calm])))
    moved = np.flatnonzero((np.arange(len(t)) > rest) & (off > far))
    if not len(moved):
        return rest, len(t)
    return rest, max(int(np.searchsorted(t, t[moved[0]] - PIECE_S)), rest + 1)


def _noise(t: Floats, x: Floats, y: Floats) -> float:
    """Return the scatter of a place, from how far it is off its two neighbours' line."""
    share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
    places = np.stack([x, y])
    off = places[:, 1:-1] - (1.0 - share) * places[:, :-2] - share * places[:, 2:]
    off /= np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
    spread = np.median(np.abs(off - np.median(off, axis=1, keepdims=True)), axis=1)
    return 1.4826 * float(spread.max())


def _own_path(t: Floats, way: Floats) -> tuple[Floats, float, float]:
    """Return the path of the law with a c and f of its own, the scatter about it, and v0."""
    from scipy.optimize import least_squares

    v0 = max(float(np.polyfit(t[: len(t) // 3 + 3], way[: len(t) // 3 + 3], 1)[0]), 0.05)
    one = np.ones_like(t)

    def path(p: Floats) -> Floats:
        return p[0] + way_m(t, p[1] * one, p[2] * one, p[3] * one)

    starts = [np.array([0.0, 1.2 * v0, c, v0 / max(t[-1], 0.1)]) for c in (0.1, 1.0)]
    low = [-np.inf, 0.0, 0.0, 1e-4]
    usual = [0.01, 0.1, 0.1, 0.1]
    fits = [
        least_squares(lambda p: path(p) - way, p, bounds=(low, np.inf), x_scale=usual)
        for p in starts
    ]
    best = min(fits, key=lambda one: one.cost)
    scatter = math.sqrt(2 * best.cost / max(len(t) - 4, 1))
    return path(best.x), max(scatter, 1e-5), float(best.x[1])


def _shared(off: Floats) -> float:
    """Return by how much neighbours that err alike make a place's error larger for the fit."""
    rho = float(off[1:] @ off[:-1] / max(float(off @ off), 1e-30))
    rho = min(max(rho - 2 / math.sqrt(len(off)), 0.0), 0.8)  # chance alone gives as much
    return math.sqrt((1.0 + rho) / (1.0 - rho))


def _doubts(
    t: Floats,
    at: tuple[int, int, int],
    way: float,
    speed: float,
    turn: tuple[float, bool],
    rough: float,
) -> list[str]:
    (start, rest, end), (turned, slips) = at, turn
    most_rad = MOST_SLIP_RAD if slips else MOST_TURN_RAD
    rolled_s = t[rest] - t[start]
    short = way < LEAST_M or rolled_s < LEAST_S
    hand = start > 0 and t[start] - t[0] > LAST * (t[end] - t[0]) and rolled_s < LEAST_S
    gap = float(np.max(np.diff(t[start : rest + 1]), initial=0.0))
    doubts = {
        "the track ends before the robot rests: film on until it does": rest >= len(t) - 1,
        f"it rolled {way:.2f} m in {rolled_s:.2f} s only: push harder, {LEAST_M} m at least": short,
        f"{speed:.2f} m/s is a slow push: it tells no viscous friction; push harder, or "
        "give --capture-fps if it is slow motion": not short and speed < FEWEST_M_S,
        f"it turned by {math.degrees(turned):+.0f} degrees while it rolled: it slipped sideways; "
        "push straighter, or align the links": abs(turned) > most_rad,
        "the hand was still on it for most of the track: let go sooner": hand,
        f"it was not seen for {gap:.2f} s on its way": gap > LONGEST_GAP_S,
        "it did not roll out evenly: did it hit something, was it touched, or do wheels wobble?": (
            rough > ROUGH
        ),
    }
    return [words for words, holds in doubts.items() if holds]
