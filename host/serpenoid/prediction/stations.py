"""Which stations a treadmill can be set to, and the incline and slip at which a snake holds one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ..calibration.fitting.identifiability import SAFE_BEND
from ..calibration.fitting.posterior import Mode
from ..calibration.fitting.rounding import nearest_shown
from ..calibration.fitting.unknowns import Floats
from ..session.session import Session
from ..session.station import LEAST_SLIP_M_S, Reading
from ..taking.expected import Series, pull_of
from .next_reading import NextReading, Option, next_number, repeated

MOST_INCLINE_RAD = math.atan(0.15)  # of home treadmills, unless this one stood steeper already
SLIPS_M_S = (0.15, 0.3, 0.6, 1.0)
_SAME_RAD = math.radians(0.5)  # bends that are one
_STEEPEST = 0.7  # a sine, where no treadmill is as steep
_AS_GOOD = 4.0  # sigmas of a bend from the one that the robot lies in


def station_options(session: Session, mode: Mode, bends: Sequence[float]) -> Iterator[Option]:
    """Yield the stations that could be held next, in these bends, each some times over."""
    for series, incline, slip in places(session, mode.x[: mode.posterior.frictions], bends):
        where = series.lambda_rad, incline, slip
        reading = Reading(next_number(session), *where, bend=series.bend)
        shown = NextReading(
            "station",
            lambda_rad=series.lambda_rad,
            incline_rad=incline,
            belt_speed_m_s=slip,
            bend=series.bend if series.lambda_rad else "",
        )
        yield shown, repeated(session, "readings", reading)


def places(
    session: Session, whole: Floats, bends: Sequence[float]
) -> list[tuple[Series, float, float]]:
    """Return series, inclines and slips worth a look: where the treadmill can be set to.

    The bend that the robot lies in now stands for one that is as good as equal to it.
    """
    given, kept = session.setup.uncertainty, session.kept
    shown = np.array([r.incline_rad for r in kept], dtype=float)
    bent = session.setup.procedure.bend
    now = kept[-1].lambda_rad if kept[-1].bend == bent else 0.0
    fastest = session.setup.procedure.belt_speed_max_m_s
    steepest = max(MOST_INCLINE_RAD, float(shown.max()))
    near, zero = _AS_GOOD * given.lambda_sigma_rad, session.zero.value_rad
    weight_n = session.setup.weight_n
    grade_step = session.setup.treadmill.incline_step_rad
    slips: dict[tuple[Series, float], float] = {}
    angles = [now if now and abs(bend - now) < near else bend for bend in bends]
    every = [
        Series(angle, bend=bent)
        for angle in angles
        if not angle or angle > SAFE_BEND * given.lambda_sigma_rad  # lesser ones bias cn
    ]
    for series in every:
        slope, least = pull_of(session.setup, whole.tolist(), series.lambda_rad)
        for wanted_m_s in SLIPS_M_S:
            aim = math.asin(min((slope * wanted_m_s + least) / weight_n, _STEEPEST)) + zero
            incline = nearest_shown(aim, shown, given.incline_sigma_rad, grade_step)
            slip = (weight_n * math.sin(incline - zero) - least) / max(slope, 1e-12)
            fits = LEAST_SLIP_M_S < slip <= fastest and 0.0 < incline <= steepest
            if fits and not _failed(session, series, incline):
                slips[series, round(incline, 6)] = slip
    return [(series, incline, slip) for (series, incline), slip in slips.items()]


def _failed(session: Session, series: Series, incline_rad: float) -> bool:
    """Tell whether a reading at this bend and incline was voided, and none kept."""
    step = session.setup.treadmill.incline_step_rad
    there = [
        r.voided
        for r in session.readings
        if abs(r.lambda_rad - series.lambda_rad) < _SAME_RAD
        and abs(r.incline_rad - incline_rad) < step / 2
    ]
    return bool(there) and all(there)
