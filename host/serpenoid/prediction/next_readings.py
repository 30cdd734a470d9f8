"""Candidates for the next reading of a session, with the values that they are expected to have."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..friction.bends import resistance
from ..friction.notes import LIMITS
from ..friction.posterior import MapEstimate
from ..friction.rounding import nearest_shown
from ..session.push import WAYS, Push
from ..session.session import Session
from ..session.station import MIN_SLIP_M_S, Reading, bent_share


@dataclass(frozen=True)
class Minutes:
    """Times that readings take a person, min, as in `docs/afternoon.md` and `docs/floor.md`.

    station, push: one reading. bend: bending the robot anew. servo_test: a bench test of one joint.
    film: a film of one gait.
    """

    station: float = 4.0
    push: float = 0.7
    bend: float = 3.0
    servo_test: float = 30.0
    film: float = 10.0


@dataclass(frozen=True)
class StationGrid:
    """The grid of candidate stations: all combinations of bends and slip speeds.

    max_grade: grade of the steepest home treadmill; a session may have a steeper one.
    same_bend_sigmas: difference of two bends, in their sigma, below which the robot stays bent as
    it is.
    """

    bends_deg: tuple[float, ...] = (0.0, 7.5, 15.0, 20.0, 30.0)
    slips_m_s: tuple[float, ...] = (0.15, 0.3, 0.6, 1.0)
    max_grade: float = 0.15
    same_bend_sigmas: float = 4.0


MINUTES, GRID = Minutes(), StationGrid()


@dataclass(frozen=True, slots=True)
class NextReading:
    """A candidate for the next reading.

    kind: "station", with lambda_rad, incline_rad and the expected belt_speed_m_s; "push", with
    lambda_rad; "film"; or "servo". words: what to do. minutes: time that it takes. band: relative
    half width of the 95 % band of speed after it, mean over the gaits.
    """

    kind: str
    words: str
    minutes: float
    band: float = math.nan
    lambda_rad: float | None = None
    incline_rad: float | None = None
    belt_speed_m_s: float | None = None


Candidates = Iterator[tuple[NextReading, tuple[Reading | Push, ...]]]


def next_stations(session: Session, estimate: MapEstimate) -> Candidates:
    """Yield stations that the treadmill can be set to, and the readings as they would be seen."""
    setup, stations, zero_rad = session.setup, session.kept_stations, session.zero.value_rad
    tools, bend = setup.instruments, setup.plan.bend
    present_rad = stations[-1].lambda_rad if stations[-1].bend == bend else 0.0
    shown_rad = np.array([reading.incline_rad for reading in stations], dtype=float)
    steepest_rad = max(math.atan(GRID.max_grade), float(shown_rad.max()))
    for bend_rad in map(math.radians, GRID.bends_deg):
        is_near = abs(bend_rad - present_rad) < GRID.same_bend_sigmas * tools.lambda_sigma_rad
        angle = present_rad if present_rad and is_near else bend_rad
        if 0.0 < angle <= LIMITS.safe_bend_sigmas * tools.lambda_sigma_rad:
            continue  # A smaller bend would bias cn.
        law = resistance(estimate.x[:4], bent_share(bend, setup.robot.links), angle)
        drag, dry_n = (float(part[0]) for part in law)
        sines = [min((drag * slip + dry_n) / setup.weight_n, 1.0) for slip in GRID.slips_m_s]
        shown = [
            nearest_shown(
                math.asin(sine) + zero_rad,
                shown_rad,
                tools.incline_sigma_rad,
                tools.incline_step_rad,
            )
            for sine in sines
        ]
        for incline in dict.fromkeys(shown):
            slip = (setup.weight_n * math.sin(incline - zero_rad) - dry_n) / max(drag, 1e-12)
            holds = MIN_SLIP_M_S < slip <= setup.plan.belt_speed_max_m_s
            if not holds or not 0.0 < incline <= steepest_rad or _failed(session, angle, incline):
                continue
            degrees = math.degrees(angle)
            between = f"{bend}; {180 - 2 * degrees:.4g}° between the links at either end"
            words = (
                f"a station at λ = {degrees:.4g}° ({between if angle else 'straight'}), "
                f"inclinometer at {math.degrees(incline):.2f}°, belt near {slip:.2g} m/s"
            )
            minutes = MINUTES.station + MINUTES.bend * (angle != present_rad)
            reading = Reading(angle, incline, slip, bend=bend)
            yield NextReading("station", words, minutes, math.nan, angle, incline, slip), (reading,)


def _failed(session: Session, angle: float, incline_rad: float) -> bool:
    """Return whether a station at this bend and incline was voided."""
    tools = session.setup.instruments
    return any(
        reading.voided
        and abs(reading.lambda_rad - angle) < tools.lambda_sigma_rad
        and abs(reading.incline_rad - incline_rad) < tools.incline_step_rad / 2
        for reading in session.readings_of("station")
    )


def next_pushes(session: Session) -> Candidates:
    """Yield for each bend two pushes, one there and one back, like the last one in it."""
    pushes = session.kept_pushes
    for angle, push in {push.lambda_rad: push for push in pushes}.items():
        pose = f"bent {math.degrees(angle):.3g}°" if angle else "straight"
        how = "filmed" if push.track else "by tape and watch"
        words = f"pushes, {pose}, one there and one back, {how}"
        minutes = len(WAYS) * MINUTES.push + MINUTES.bend * (angle != pushes[-1].lambda_rad)
        pair = tuple(replace(push, way=way) for way in WAYS)
        yield NextReading("push", words, minutes, lambda_rad=angle), pair
