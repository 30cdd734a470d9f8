"""What a picture or a page shows of a session in progress, as plain values."""

from __future__ import annotations

import math
from typing import Any

from ...calibration.friction_result import DOUBTFUL, FrictionFit
from ...calibration.session import Session
from ...calibration.taking.procedure import belt_range, progress
from ...calibration.taking.steps import Step
from ...model.errors import SerpenoidError
from .bend_drawing import bend_svg
from .station_drawing import stations_svg


def state_of(session: Session, step: Step, robot: str, offset: str = "") -> dict[str, Any]:
    """Return the step, progress, last reading, running fit, and a picture of the stations.

    Degrees and SI, as people read them. robot: in words, such as "holds" or "by hand". offset: its
    steering, in words.
    """
    fit = _fit(session)
    return {
        "name": session.setup.name,
        "say": step.say,
        "aim": _aim(step),
        "progress": [list(row) for row in progress(session)],
        "last": _last(session),
        "fit": [
            [
                f"{r.name} ({r.unit})".replace("N s", "N\u00a0s"),
                f"{r.value:#.3g} ({r.low:#.3g} to {r.high:#.3g})",
            ]
            for r in ([] if fit is None else fit.rows())
        ],
        "agreement": "" if fit is None else agreement(fit),
        "offset": offset,
        "picture": stations_svg(session),
        "robot": robot,
        "shape": bend_svg(step.bend, session.setup.robot.links, step.lambda_deg)
        if step.kind == "bend"
        else "",
    }


def _aim(step: Step) -> str:
    """Return the one thing to set now, to be read from afar."""
    if step.kind == "station":
        likely = step.fields[1].likely
        belt = f"  belt {belt_range(likely)}" if likely else "  raise the belt"
        grade = 100 * math.tan(math.radians(step.incline_deg))
        return f"incline {step.incline_deg:.1f}° = {grade:.1f} %{belt}"
    if step.kind == "bend":
        between = f"{180 - 2 * step.lambda_deg:g}° between the links at either end"
        return f"{step.bend} bend {step.lambda_deg:g}°: {between}"
    if step.facing == "up":
        return "robot straight, head UPHILL"
    return {
        "zero": "inclinometer zero",
        "straight": "robot straight",
        "done": "all done",
        "gait": "gait run",
        "push": f"push {step.cells.get('way', '')}, then hands off",
        "belt": "belt check: time ten turns",
    }[step.kind]


def _last(session: Session) -> str:
    """Return the newest reading in words, and why it is void if it is."""
    if not session.numbered:
        return "none yet"
    last = session.numbered[-1]
    void = f"; VOID: {last.comment}" if last.voided else ""
    return ": ".join([str(last.number), *last.in_words()]) + void


def _fit(session: Session) -> FrictionFit | None:
    from ...calibration.friction_fit import fit_friction

    try:
        return fit_friction(session)
    except SerpenoidError:  # too few readings yet
        return None


def agreement(fit: FrictionFit) -> str:
    """Return in words whether the readings agree, and which one to look at if they do not."""
    if fit.p_value is None:
        return "no reading too many: nothing checks the fit yet"
    chi2 = f"χ² {fit.chi2:.1f} for {fit.dof} degrees of freedom"
    if fit.p_value >= DOUBTFUL:
        return f"{chi2}: the readings agree"
    alarm_of_chi2 = next((alarm for alarm in fit.alarms if alarm.startswith("chi2 is")), "")
    return f"{chi2}: THE READINGS DISAGREE. {alarm_of_chi2.partition('intervals. ')[2]}".rstrip()
