"""What the readings so far let expect of the next: a line through those of the same bend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..friction.bends import projections
from ..friction.paper_fit import two_lines
from ..friction.stations import Stations
from ..session.session import Session
from ..session.settings import Plan, Setup
from ..session.station import Reading, bent_share

SIGMAS = 3.5  # beyond which a reading is asked about: once in 2000 honest ones
FASTEST = 1.5  # of the top speed, above which a first station is asked about
SLOW, SURE = 0.2, 0.8  # of the top speed; of the way from a fast first station to that
USUAL = (0.084, 1.2, 0.14, 0.27)  # ct, cn, ft0, fn0 of the 2005 robot, before any of this one
USUAL_KG = 0.4536
DOUBT = 0.12  # of the speed: stations are expected from few readings, and wheels are not ideal


@dataclass(frozen=True)
class Line:
    """Belt speed past the snake against sin(incline), with what is needed for its doubt."""

    slope: float
    mean_sine: float
    mean_m_s: float
    sigma_m_s: float
    spread: float
    count: int

    def at(self, sine: float) -> tuple[float, float]:
        """Return the speed expected and its standard deviation, a new reading's own noise in it."""
        speed, open_m_s = self.through(sine)
        doubt = DOUBT * abs(speed - self.mean_m_s)
        return speed, math.hypot(self.sigma_m_s, open_m_s) + doubt

    def through(self, sine: float) -> tuple[float, float]:
        """Return the line's speed and what the readings leave it open by, one s.d."""
        off = sine - self.mean_sine
        part = 1 / self.count + off * off / self.spread
        return self.mean_m_s + self.slope * off, self.sigma_m_s * math.sqrt(part)

    def sine_at(self, speed_m_s: float) -> float:
        """Return the sine of the incline that needs a speed."""
        return self.mean_sine + (speed_m_s - self.mean_m_s) / self.slope


@dataclass(frozen=True)
class Series:
    """Stations or pushes of one pose: a bend of the plan, or straight.

    bend: balanced or zigzag, as of a reading.
    """

    lambda_rad: float
    bend: str = "zigzag"
    pushed: bool = False

    @property
    def bend_deg(self) -> float:
        """Return the plan's bend in degrees, 0 where straight."""
        return round(math.degrees(self.lambda_rad), 3)

    @property
    def key(self) -> str:
        """Return what events call it."""
        bend = f"{math.degrees(self.lambda_rad):.5g}"
        if self.pushed:
            return f"pushes {bend if self.lambda_rad else 'straight'}"
        return f"bend {bend}" if self.lambda_rad else "straight"

    @property
    def name(self) -> str:
        """Return what people call it."""
        if self.lambda_rad:
            zigzag = " zigzag" if self.bend == "zigzag" else ""
            return f"{math.degrees(self.lambda_rad):.5g}°{zigzag}"
        return "straight"


STRAIGHT = Series(0.0)


def series_of(plan: Plan) -> list[Series]:
    """Return the stations' series of a plan in their order."""
    return [Series(bend_rad, plan.bend) for bend_rad in plan.lambda_rad]


def series_of_pushes(plan: Plan) -> list[Series]:
    """Return the pushes' series of a plan in their order."""
    return [Series(bend_rad, plan.bend, pushed=True) for bend_rad in plan.push_lambda_rad]


def planned_bend(session: Session, lambda_rad: float) -> float:
    """Return the plan's bend that is nearest to one that the protractor showed, rad."""
    plan = session.setup.plan.bends_rad
    return min(plan, key=lambda planned: abs(planned - lambda_rad))


def shown_bend(session: Session, lambda_rad: float) -> float | None:
    """Return the bend that the last protractor check showed, None if it was of another bend."""
    if lambda_rad == 0.0:
        return 0.0
    checks = session.kept_of("bend")
    if not checks or planned_bend(session, checks[-1].found_rad) != lambda_rad:
        return None
    return checks[-1].found_rad if checks[-1].bend == session.setup.plan.bend else None


def of_series(session: Session, series: Series) -> list[Any]:
    """Return the kept stations or pushes of one of the plan's bends, bent as it says."""
    aim, bend = planned_bend(session, series.lambda_rad), session.setup.plan.bend
    taken = session.kept_pushes if series.pushed else session.kept
    bent = (r for r in taken if r.bend == bend or not r.lambda_rad)
    return [r for r in bent if planned_bend(session, r.lambda_rad) == aim]


def line_of(session: Session, series: Series) -> Line | None:
    """Return the line through a series' stations, None with fewer than two inclines."""
    stations = of_series(session, series)
    gravity = session.setup.laboratory.gravity_m_s2
    sines = np.array([r.balance_sine(gravity) for r in stations])
    if len(sines) < 2 or np.ptp(sines) < 1e-4:
        return None
    speeds = np.array([r.slip_speed_m_s for r in stations])
    x, y = float(sines.mean()), float(speeds.mean())
    spread = float(np.sum((sines - x) ** 2))
    slope = float((sines - x) @ (speeds - y)) / spread
    if slope <= 0.0:
        return None
    unsure = session.setup.instruments
    noise = math.hypot(unsure.belt_speed_sigma_m_s, slope * unsure.incline_sigma_rad)
    return Line(slope, x, y, noise, spread, len(stations))


def pull_of(setup: Setup, frictions: Sequence[float], lambda_rad: float) -> tuple[float, float]:
    """Return the drag, N s/m, and the dry force, N, of a robot that rolls bent as planned."""
    ct, cn, ft0, fn0 = frictions
    share = bent_share(setup.plan.bend, setup.robot.links)
    by_ct, by_cn, by_ft0, by_fn0 = map(float, projections(share, lambda_rad))
    return ct * by_ct + cn * by_cn, ft0 * by_ft0 + fn0 * by_fn0


def law_sine(session: Session, lambda_rad: float, speed_m_s: float) -> float:
    """Return the sine of the incline at which a bend should hold at a speed past the snake.

    By the frictions of all stations so far. Before any of a bend by the straight line, and by what
    a bend adds to the pull of the robot of 2005; 0 where there is no line.
    """
    data = Stations.of(session) if session.kept else None
    setup = session.setup
    parts = [] if data is None else [data.parts[part] for part in ("straight", "bent")]
    if data is not None and all(len(np.unique(data.slip_m_s[part])) > 1 for part in parts):
        frictions = np.maximum(two_lines(data)[0][:4], 0.0).tolist()
        drag, dry_n = pull_of(setup, frictions, lambda_rad)
        return (drag * speed_m_s + dry_n) / setup.weight_n
    straight = line_of(session, STRAIGHT)
    if straight is None:
        return 0.0
    bent, plain = (pull_of(setup, USUAL, x) for x in (lambda_rad, 0.0))
    more = (bent[0] * speed_m_s + bent[1]) / (plain[0] * speed_m_s + plain[1])
    return max(more * straight.sine_at(speed_m_s), 0.0)


def slowing_deg(setup: Setup, first: Reading) -> float:
    """Return by how much less inclined than at its first station a bend should hold slowly.

    By the drag of the robot of 2005, as heavy as this one; as that may be less, a part of it.
    """
    plan = setup.plan
    drag, _ = pull_of(setup, USUAL, first.lambda_rad)
    less_m_s = SURE * (first.slip_speed_m_s - SLOW * plan.belt_speed_max_m_s)
    return math.degrees(less_m_s * drag / USUAL_KG / setup.laboratory.gravity_m_s2)


def expected_speed(
    session: Session, series: Series, incline_rad: float
) -> tuple[float, float] | None:
    """Return the range of the belt's speed past the snake at a station, m/s; None if unknown."""
    line = line_of(session, series)
    if line is not None:
        speed, sigma = line.at(math.sin(incline_rad))
        return max(speed - SIGMAS * sigma, 0.0), max(speed + SIGMAS * sigma, 0.0)
    most_m_s = FASTEST * session.setup.plan.belt_speed_max_m_s
    stations = of_series(session, series)
    if stations:  # steeper is faster
        last = max(stations, key=lambda r: r.incline_rad)
        noise = SIGMAS * session.setup.instruments.belt_speed_sigma_m_s
        if incline_rad >= last.incline_rad:
            return max(last.slip_speed_m_s - noise, 0.0), most_m_s
        if len(stations) == 1:
            return 0.0, last.slip_speed_m_s + noise
    straight = line_of(session, STRAIGHT) if series.lambda_rad else None
    if straight is not None:  # a bent snake needs less speed
        speed, sigma = straight.at(math.sin(incline_rad))
        return 0.0, max(speed + SIGMAS * sigma, 0.05)
    return None if session.of("station") else (0.0, most_m_s)
