"""Dry friction at rest against dry friction in motion, from the checks on a tilted board."""

from __future__ import annotations

import math

import numpy as np

from ..calibration.fitting.bends import projections
from ..calibration.friction_result import FrictionFit
from ..calibration.kinds.slide import BreakAway
from ..calibration.kinds.station import bent_share
from ..calibration.session import Session

SURELY = 2.0  # standard deviations
TILT_RAD = math.radians(0.3)  # of a board tilted by hand, when the robot lets go


def break_away_notes(fit: FrictionFit, session: Session) -> tuple[str, ...]:
    """Return what the checks say, one note a bend that was checked."""
    bends: dict[float, list[BreakAway]] = {}
    for check in sorted(session.of("breakaway"), key=lambda check: check.lambda_rad):
        if not check.voided:
            bends.setdefault(round(math.degrees(check.lambda_rad), 2), []).append(check)
    return tuple(_note(fit, session, bend, checks) for bend, checks in bends.items())


def ratio(fit: FrictionFit, session: Session, checks: list[BreakAway]) -> tuple[float, float]:
    """Return dry force at rest over the fitted one in motion, and its standard deviation."""
    bend, links = checks[0].bend, session.setup.robot.links
    share = bent_share(bend, links) if checks[0].lambda_rad else 0.0
    whole = np.array(list(fit.whole_snake.values()))[:4]
    _, _, by_ft0, by_fn0 = projections(share, checks[0].lambda_rad)
    slopes = np.array([0.0, 0.0, by_ft0, by_fn0])
    force_n = float(slopes @ whole)
    tilts = [c.incline_rad - session.zero.value_rad for c in checks]
    held_n = session.setup.weight_n * float(np.mean(np.sin(tilts)))
    tilt_n = session.setup.weight_n * math.hypot(
        TILT_RAD / math.sqrt(len(checks)), session.zero.sigma_rad
    )
    moving = float(np.sqrt(slopes @ fit.covariance[:4, :4] @ slopes)) / force_n
    return held_n / force_n, held_n / force_n * math.hypot(tilt_n / held_n, moving)


def _note(fit: FrictionFit, session: Session, bend_deg: float, checks: list[BreakAway]) -> str:
    value, sigma = ratio(fit, session, checks)
    pose = f"bent by {bend_deg:g} degrees" if bend_deg else "straight"
    told = (
        f"Break-away, {pose}: dry friction at rest is {value:.2f} ± {sigma:.2f} of that in motion"
    )
    if abs(value - 1.0) < SURELY * sigma:
        return f"{told}: no difference is seen."
    if value < 1.0:
        return f"{told}: less than in motion is no friction's way. Look at the inclinometer's zero."
    return (
        f"{told}. The model has one dry friction, that in motion. Wheels may hold where a slip is "
        "predicted: gaits that stick may crawl faster."
    )
