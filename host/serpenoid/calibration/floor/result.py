"""From a floor session's minimum to a friction fit: values, intervals, and what each push does."""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np

from ...model.errors import NotConverged
from ..fitting.data import FitData, Floats
from ..fitting.influence import BOTH_WAYS, Influence
from ..fitting.joint import Minimum
from ..fitting.profile import intervals
from ..fitting.shared import shared_covariance, widened
from ..friction_result import (
    DOUBTFUL,
    LEVEL,
    Estimate,
    FrictionFit,
    WholeSnake,
    ground_of,
    notes_on,
)
from ..session import Session
from .data import FloorData
from .minimum import covariance_of, least
from .problem import ROLLING, SCALE, Problem
from .pushes import PushFigures, figures_of

WEIGHT = 0.3  # of a share's prior: below it the readings have told much of it themselves


def fit_floor(session: Session) -> FrictionFit:
    """Fit a session that has pushes or slides, and stations where it has those, too.

    Raises BadInput where a friction is left open, NotConverged.
    """
    floor = FloorData.of(session)
    stations = FitData.of(session) if session.kept else None
    problem, found, settled = least(floor, stations)
    covariance = covariance_of(problem, found, session.where)
    if not settled:
        raise NotConverged(
            f"{session.where}: the fit of pushes came to no end at chi2 = {found.chi2:.3g}; look "
            "for a push or a slide that was misread"
        )
    figures = figures_of(problem, found, covariance)
    fit = _result(session, problem, found, covariance, figures)
    return _with_alarms(fit, figures)


def _result(
    session: Session, problem: Problem, found: Minimum, covariance: Floats, figures: PushFigures
) -> FrictionFit:
    from dataclasses import replace

    from scipy.special import ndtri

    count, robot = problem.parameters, session.setup.robot
    quantile = float(ndtri(0.5 + LEVEL / 2))
    values = found.x[:count]
    ends = intervals(problem, found, np.full(count, quantile))
    shared = shared_covariance(values, 0.0, session.mass_sigma)
    whole = covariance[:count, :count] + shared
    ends = widened(ends, values, np.sqrt(np.diag(shared)), quantile)
    whole.flags.writeable = False
    names = BOTH_WAYS[:count]
    pairs = zip(values.tolist(), np.sqrt(np.diag(whole)).tolist(), strict=True)
    fit = FrictionFit(
        method="joint",
        sigma="absolute",
        parameters=WholeSnake(dict(zip(names, (Estimate(*p) for p in pairs), strict=True))),
        intervals=WholeSnake(dict(zip(names, map(tuple, ends.tolist()), strict=True))),
        covariance=whole,
        robot=robot,
        ground=ground_of(robot.links, values.tolist()),
        chi2=figures.chi2,
        dof=figures.dof,
        nuisances=MappingProxyType(_nuisances(problem, found, covariance)),
        residuals=(*_station_residuals(problem, found), *figures.residuals.tolist()),
        outliers=(),
        influence=_influences(problem, found, covariance, figures),
        notes=(),
        session_name=session.setup.name,
        session_sha256=session.sha256,
    )
    return replace(fit, notes=(*notes_on(fit, session), *_notes(session, problem)))


def _station_residuals(problem: Problem, found: Minimum) -> list[float]:
    """Return the stations' residuals, in the order of their readings; they come before pushes."""
    if problem.stations is None:
        return []
    count = len(problem.stations)
    first = len(found.residuals) - count - problem.stations.nuisances - 1
    return found.residuals[first : first + count].tolist()  # type: ignore[no-any-return]


def _nuisances(problem: Problem, found: Minimum, covariance: Floats) -> dict[str, Estimate]:
    """Return what is shared, in its own unit: slopes, scale, wheels, bends."""
    at, floor = problem.layout, problem.floor
    sigma = np.sqrt(np.diag(covariance))
    out: dict[str, Estimate] = {}

    def put(name: str, k: int, unit: float, mean: float = 0.0) -> None:
        out[name] = Estimate(mean + unit * float(found.x[k]), unit * float(sigma[k]))

    for k, place in enumerate(floor.places):
        put(
            f"floor_slope_rad{'_' + place if place else ''}",
            at.slopes.start + k,
            floor.slope_sigma_rad,
        )
    if floor.filmed.any():
        put("film_scale", at.shared + SCALE, floor.scale_sigma, 1.0)
    put("wheels_turning_over_mass", at.shared + ROLLING, floor.rolling[1], floor.rolling[0])
    for k, (angle, unit) in enumerate(
        zip(floor.posture_lambda_rad, floor.posture_sigma_rad, strict=True)
    ):
        name = f"lambda_offset_rad_at_{math.degrees(angle):.4g}_deg"
        again = sum(other.startswith(name) for other in out)
        put(name + (f"_again_{again}" if again else ""), at.offsets.start + k, float(unit))
    return out


def _influences(
    problem: Problem, found: Minimum, covariance: Floats, figures: PushFigures
) -> tuple[Influence, ...]:
    sigma = np.sqrt(np.diag(covariance))[: problem.parameters]
    return tuple(
        Influence(number, float(h), float(t), tuple((s / sigma).tolist()), float(chi2))
        for number, h, t, s, chi2 in zip(
            figures.numbers,
            figures.leverage,
            figures.studentised,
            figures.shift,
            figures.chi2_without,
            strict=True,
        )
    )


def _with_alarms(fit: FrictionFit, figures: PushFigures) -> FrictionFit:
    """Say that pushes disagree, and which one to look at first."""
    from dataclasses import replace

    if fit.p_value is None or fit.p_value > DOUBTFUL:
        return fit
    worst = int(np.argmin(figures.chi2_without))
    alarm = (
        f"chi2 is {fit.chi2:.1f} for {fit.dof} degrees of freedom (p = {fit.p_value:.1g}): the "
        "readings disagree by more than their errors allow, so do not trust the intervals. Without "
        f"reading {figures.numbers[worst]} chi2 would be {figures.chi2_without[worst]:.1f}: look "
        "at that one first."
    )
    return replace(fit, alarms=(alarm,), notes=(alarm, *fit.notes))


def _turned_round(session: Session) -> list[int]:
    """Return the filmed pushes that go the other way in the picture than their word says.

    By the most of a place: a camera that stays shows "there" and "back" in opposite directions.
    """
    found = []
    for place in {p.place for p in session.kept_pushes}:
        there = []
        for push in session.kept_pushes:
            if push.by == "film" and push.place == place:
                _, x, y = push.counted
                sign = 1.0 if push.way == "there" else -1.0
                there.append((push.number, sign * np.array([x[-1] - x[0], y[-1] - y[0]])))
        if len(there) < 3:
            continue
        mean = np.median([way / np.hypot(*way) for _, way in there], axis=0)
        found += [number for number, way in there if way @ mean < 0.0]
    return sorted(found)


def _notes(session: Session, problem: Problem) -> list[str]:
    floor, tools = problem.floor, session.setup.floor
    notes = []
    voided = sum(r.voided for kind in ("coast", "slide") for r in session.of(kind))
    if voided:
        notes.append(f"{voided} voided push(es) or slide(s) left out.")
    odd = _turned_round(session)
    if odd:
        notes.append(
            f"Push(es) {', '.join(map(str, odd))} went the other way in the picture than those of "
            "the same word: is there and back mixed up, or was the camera moved? Void and add them "
            "again with the right way; a wrong one spoils ft0 unseen."
        )
    if tools.wheels_kg is None:
        notes.append(
            "Nobody said what the wheels weigh: their turning is taken for "
            f"{floor.rolling[0]:.1%} ± {floor.rolling[1]:.1%} of the mass. `serpenoid calibrate "
            "amend DIR robot.wheels_kg=36g` makes all four frictions surer."
        )
    for k, place in enumerate(floor.places):
        ways = floor.way[floor.place == k]
        if np.ptp(ways) == 0.0:
            where = f" at {place}" if place else ""
            notes.append(
                f"All pushes{where} went one way: the floor may slope by "
                f"{math.degrees(floor.slope_sigma_rad):.2g} degrees, and ft0 is only as sure as "
                "that. Push as often the other way."
            )
    return notes
