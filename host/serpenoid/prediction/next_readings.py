"""Readings that could be taken next, of the kind that a session has, each as it would be seen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..friction.bends import resistance
from ..friction.notes import SAFE_BEND_SIGMAS
from ..friction.posterior import MapEstimate
from ..friction.rolling_law import rest_point, way_m
from ..friction.rounding import nearest_shown
from ..session.push import WAYS, Push
from ..session.session import Session
from ..session.settings import Setup
from ..session.station import LEAST_SLIP_M_S, Reading, bent_share
from ..session.track import Track

# Minutes that a person takes: `docs/afternoon.md` and `docs/floor.md` plan with as many.
STATION_MIN, PUSH_MIN, BEND_MIN = 4.0, 0.7, 3.0
MAX_TIMES = 5  # most repetitions of one reading
BELT_BENDS_RAD = tuple(map(math.radians, (0.0, 7.5, 15.0, 20.0, 30.0)))
SLIPS_M_S = (0.15, 0.3, 0.6, 1.0)
MAX_INCLINE_RAD = math.atan(0.15)  # steepest home treadmill, unless this one stood steeper already
MAX_SINE = 0.7  # steepest incline that is tried; no treadmill is as steep
SAME_BEND_SIGMAS = 4.0  # distance of two bends, in sigma, below which the robot stays as it lies
SAME_RAD = math.radians(0.5)  # bends and inclines of a voided station that are not tried again
FLOOR_BENDS_RAD = tuple(map(math.radians, (0.0, 20.0, 42.0)))
PUSH_M_S, PICTURES_HZ, RESTED_S = 0.9, 30.0, 0.4
PLACE_SIGMA_M = 0.001  # error of a place in a film, where no film before it states one


@dataclass(frozen=True, slots=True)
class NextReading:
    """A reading, and the relative half width of the speeds' 95 % band after it.

    kind: station (lambda_rad, incline_rad, belt_speed_m_s expected), push (lambda_rad), film or
    servo. words: what to do. times: how often it is worth taking. minutes: that it takes in all.
    band: after it, mean over the gaits asked for.
    """

    kind: str
    words: str
    times: int
    minutes: float
    band: float
    lambda_rad: float | None = None
    incline_rad: float | None = None
    belt_speed_m_s: float | None = None

    def in_words(self) -> str:
        """Return what to do, and how often."""
        return self.words + (f", {self.times} times" if self.times > 1 else "")


@dataclass(frozen=True)
class Candidate:
    """A reading that could be taken next: as it is advised, and as it would be seen.

    advised: once, its band unknown. repeat_minutes: of each further time. readings: of one time.
    """

    advised: NextReading
    repeat_minutes: float
    readings: tuple[Reading | Push, ...]

    def session_with(self, session: Session, times: int) -> Session:
        """Return the session with the reading so many times."""
        first = 1 + max((reading.number for reading in session.readings), default=0)
        for k, reading in enumerate(self.readings * times):
            session = session.with_reading(replace(reading, number=first + k))
        return session


def candidates(session: Session, estimate: MapEstimate) -> Iterator[Candidate]:
    """Yield pushes for a session on a floor, else stations that the treadmill can be set to."""
    yield from _pushes(session, estimate) if session.on_floor else _stations(session, estimate)


def _stations(session: Session, estimate: MapEstimate) -> Iterator[Candidate]:
    setup, stations = session.setup, session.kept_stations
    sigma_rad, bend = setup.instruments.lambda_sigma_rad, setup.plan.bend
    present_rad = stations[-1].lambda_rad if stations[-1].bend == bend else 0.0
    near_rad = SAME_BEND_SIGMAS * sigma_rad
    angles = [
        present_rad if present_rad and abs(angle - present_rad) < near_rad else angle
        for angle in BELT_BENDS_RAD
    ]
    for angle in dict.fromkeys(angles):
        if angle and angle <= SAFE_BEND_SIGMAS * sigma_rad:
            continue  # a lesser bend would bias cn
        minutes = STATION_MIN + (0.0 if angle == present_rad else BEND_MIN)
        for incline, slip in _belt_places(session, estimate, angle):
            degrees = math.degrees(angle)
            pose = "straight"
            if angle:
                pose = f"{bend}; {180 - 2 * degrees:.4g}° between the links at either end"
            words = (
                f"a station at λ = {degrees:.4g}° ({pose}), inclinometer at "
                f"{math.degrees(incline):.2f}°, belt near {slip:.2g} m/s"
            )
            reading = Reading(0, angle, incline, slip, bend=bend)
            station = NextReading("station", words, 1, minutes, math.nan, angle, incline, slip)
            yield Candidate(station, STATION_MIN, (reading,))


def _belt_places(
    session: Session, estimate: MapEstimate, angle: float
) -> list[tuple[float, float]]:
    """Return inclines as the inclinometer shows them, and the slips at which the robot holds."""
    setup, zero = session.setup, session.zero.value_rad
    shown = np.array([reading.incline_rad for reading in session.kept_stations], dtype=float)
    steepest = max(MAX_INCLINE_RAD, float(shown.max()))
    drag, dry_n = _drag(setup, estimate, angle)
    places: dict[float, float] = {}
    for wanted_m_s in SLIPS_M_S:
        sine = min((drag * wanted_m_s + dry_n) / setup.weight_n, MAX_SINE)
        step, sigma = setup.instruments.incline_step_rad, setup.instruments.incline_sigma_rad
        incline = nearest_shown(math.asin(sine) + zero, shown, sigma, step)
        slip = (setup.weight_n * math.sin(incline - zero) - dry_n) / max(drag, 1e-12)
        holds = LEAST_SLIP_M_S < slip <= setup.plan.belt_speed_max_m_s
        if holds and 0.0 < incline <= steepest and not _failed(session, angle, incline):
            places[round(incline, 6)] = slip
    return list(places.items())


def _drag(setup: Setup, estimate: MapEstimate, angle: float) -> tuple[float, float]:
    """Return the drag, N s/m, and the dry force, N, of a robot that rolls in a bend."""
    share = bent_share(setup.plan.bend, setup.robot.links)
    viscous, dry_n = resistance(estimate.x[:4], share, angle)
    return float(viscous[0]), float(dry_n[0])


def _failed(session: Session, angle: float, incline_rad: float) -> bool:
    """Tell whether all readings at this bend and incline were voided."""
    step = session.setup.instruments.incline_step_rad
    same_place = [
        reading.voided
        for reading in session.readings_of("station")
        if abs(reading.lambda_rad - angle) < SAME_RAD
        and abs(reading.incline_rad - incline_rad) < step / 2
    ]
    return bool(same_place) and all(same_place)


def _pushes(session: Session, estimate: MapEstimate) -> Iterator[Candidate]:
    setup, last = session.setup, session.kept_pushes[-1]
    filmed = any(push.track is not None for push in session.kept_pushes)
    for bend_rad in FLOOR_BENDS_RAD:
        is_near = abs(last.lambda_rad - bend_rad) < SAME_BEND_SIGMAS * SAME_RAD
        angle = last.lambda_rad if is_near else bend_rad
        drag, dry_n = _drag(setup, estimate, angle)
        law = np.array([drag, dry_n]) * setup.laboratory.gravity_m_s2 / setup.weight_n
        pose = f"bent {math.degrees(angle):.3g}°" if angle else "straight"
        words = f"pushes, {pose}, at {PUSH_M_S:g} m/s, one there and one back, " + (
            "filmed" if filmed else "by tape and watch"
        )
        minutes = len(WAYS) * PUSH_MIN
        first = minutes + (0.0 if is_near else BEND_MIN)
        pair = _pair_of_pushes(session, law, angle, filmed)
        push = NextReading("push", words, 1, first, math.nan, angle)
        yield Candidate(push, minutes, pair)


def _pair_of_pushes(
    session: Session, law: np.ndarray, angle: float, filmed: bool
) -> tuple[Push, ...]:
    """Return a push each way, as they would be seen; law: c and f of v' = -(c v + f)."""
    start = np.array([[PUSH_M_S], [law[0]], [law[1]]])
    rest_s, rest_m = (float(part[0]) for part in rest_point(*start))
    place, bend = session.kept_pushes[-1].place, session.setup.plan.bend
    common = {"lambda_rad": angle, "bend": bend, "place": place}
    if not filmed:
        return tuple(
            Push(0, distance_m=rest_m, duration_s=rest_s, way=way, **common) for way in WAYS
        )
    sigmas_m = [p.distance_sigma_m for p in session.kept_pushes if p.track and p.distance_sigma_m]
    t = np.arange(0.0, rest_s + RESTED_S, 1 / PICTURES_HZ)
    x = way_m(t, *start)
    track = Track.from_samples(("t_s", "x_m", "y_m"), np.stack([t, x, 0 * t], axis=1))
    sigma_m = float(np.median(sigmas_m)) if sigmas_m else PLACE_SIGMA_M
    return tuple(
        Push(0, way=way, source="film", track=track, distance_sigma_m=sigma_m, **common)
        for way in WAYS
    )


def can_film(session: Session) -> bool:
    """Return whether the session has films, or tags printed for them."""
    by_film: Sequence[Push] = [push for push in session.kept_pushes if push.source == "film"]
    return bool(session.kept_films or by_film or session.setup.robot_table.tag_side_m)
