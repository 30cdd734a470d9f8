"""Make up calibration sessions with known friction and instruments that err as stated."""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from serpenoid import Ground, Session
from serpenoid.session.settings import Instruments, Laboratory, Plan, Provenance, RobotTable, Setup
from serpenoid.session.station import Reading

WHOLE_BODY_2005 = Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)  # Eqs. 59 and 62, not per link
STEP_RAD = math.radians(0.1)  # the inclinometer's


def setup(*lambdas_deg: float, kind="simulated") -> Setup:
    """Return a set-up that is straight first, then bent by these angles."""
    return Setup(
        "made up",
        Provenance(kind=kind, source="a test", note="a test"),
        RobotTable(links=6, mass_kg=6 * 0.0756, link_length_m=0.076),
        Laboratory(surface="belt", place="a test", people="nobody", gravity_m_s2=9.80665),
        # A reading rounded to steps of d errs evenly over d, with standard deviation d / sqrt(12).
        Instruments(
            incline_sigma_deg=math.degrees(STEP_RAD) / math.sqrt(12),
            incline_zero_sigma_deg=0.1,
            belt_speed_sigma_m_s=0.02,
            lambda_sigma_deg=0.5,
        ),
        Plan(
            lambda_deg=(0.0, *lambdas_deg),
            incline_start_deg=2.0,
            incline_step_deg=0.2,
            belt_speed_max_m_s=1.0,
        ),
    )


def session(
    setup: Setup,
    truth: Ground,
    rng: np.random.Generator | None = None,
    offset_sigma: float = 1.0,
    on_grades: bool = False,
) -> Session:
    """Take a session's readings; rng errs as the set-up's uncertainties say, None not at all.

    offset_sigma: how far bends err, each alone, in the set-up's standard deviations.
    on_grades: the treadmill stops at its own grades alone.
    """
    unit = setup.instruments
    bends = np.zeros(sum(x > 0 for x in setup.plan.lambda_deg))
    offsets = iter(bends if rng is None else offset_sigma * rng.normal(size=len(bends)))
    zero = 0.0 if rng is None else rng.normal()
    readings: list[Reading] = []
    for nominal in np.radians(setup.plan.lambda_deg):
        bend = nominal + (next(offsets) * unit.lambda_sigma_rad if nominal else 0.0)
        grade = unit.incline_step_rad if on_grades else 0.0
        for incline, speed in _stations(setup, truth, bend, rng, grade):
            shown = incline + zero * unit.incline_zero_sigma_rad
            noise = 0.0
            if rng is not None:
                shown = round(shown / STEP_RAD) * STEP_RAD
                noise = unit.belt_speed_sigma_m_s * rng.normal()
            if speed + noise > 0.0:
                readings.append(Reading(nominal, shown, speed + noise, number=len(readings) + 1))
    return Session(setup, tuple(readings))


def _stations(
    setup: Setup, truth: Ground, bend: float, rng: np.random.Generator | None, grade: float
):
    """Yield true inclines and the true speeds that hold the snake there (Eq. 60)."""
    c, s = math.cos(bend), math.sin(bend)
    incline = math.radians(setup.plan.incline_start_deg)
    while True:
        # A treadmill without grades stops anywhere within a step of the inclinometer.
        true = incline + (0.0 if rng is None else rng.uniform(-0.5, 0.5) * STEP_RAD)
        if grade:
            true = math.atan(round(math.tan(incline) / grade) * grade)
        pull = setup.weight_n * math.sin(true)
        speed = (pull - truth.ft0 * c - truth.fn0 * s) / (truth.ct * c * c + truth.cn * s * s)
        if speed > setup.plan.belt_speed_max_m_s:
            return
        if speed > 0.0:
            yield true, speed
        incline += setup.plan.incline_step_rad


def stations(setup: Setup, rows: Iterable[tuple[float, ...]], **more: object) -> Session:
    """Return a session of stations: bend, rad, incline, rad, and the belt's speed, m/s."""
    readings = (Reading(*row, number=number, **more) for number, row in enumerate(rows, 1))
    return Session(setup, tuple(readings))


def changed(session: Session, index: int, **changes: object) -> Session:
    """Return the session with one reading changed."""
    readings = list(session.readings)
    readings[index] = replace(readings[index], **changes)
    return replace(session, readings=tuple(readings))
