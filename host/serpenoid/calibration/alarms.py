"""What makes a fit no ground for any prediction: readings that contradict each other or the law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..session.session import Session
from .fitting.identifiability import bend_note
from .fitting.posterior import Mode
from .fitting.stations import Stations
from .fitting.suspects import suspects_in_words
from .floor.notes import floor_notes
from .friction_result import DOUBTFUL, FrictionFit, notes_on

_SURELY = 3.0  # standard deviations below 0, from which a friction is an alarm


def with_alarms(fit: FrictionFit, session: Session, mode: Mode) -> FrictionFit:
    """Return a fit with its notes; first those that say why it is not to be trusted, if any.

    mode: of all readings.
    """
    stations = [block for block in mode.posterior.blocks if isinstance(block, Stations)]
    alarms = [
        *_contradiction(fit, session, mode),
        *(alarm for block in stations for alarm in _against_the_law(block, mode)),
    ]
    bends = [note for block in stations for note in bend_note(block)]
    notes = [*notes_on(fit, session), *bends, *floor_notes(session, mode.posterior)]
    return replace(fit, alarms=tuple(alarms), notes=(*alarms, *_freedom(fit), *notes))


def _freedom(fit: FrictionFit) -> list[str]:
    if fit.dof > 0:
        return []
    return [
        f"{len(fit.residuals)} readings for {len(fit.names)} frictions leave no degree of freedom: "
        "nothing tells whether they agree. Take one more of each kind."
    ]


def _contradiction(fit: FrictionFit, session: Session, mode: Mode) -> list[str]:
    """Say that the readings disagree, and without which one they would disagree least."""
    if fit.p_value is None or fit.p_value > DOUBTFUL:
        return []
    return [
        f"chi2 is {fit.chi2:.1f} for {fit.dof} degrees of freedom (p = {fit.p_value:.1g}): the "
        "readings disagree by more than the stated uncertainties allow, so do not trust the "
        f"intervals. {suspects_in_words(session, mode)}"
    ]


def _against_the_law(data: Stations, mode: Mode) -> list[str]:
    """Say where friction falls with speed, or a bent robot has less of it than a straight one.

    By one linear step from the mode, which no limit of 0 ends.
    """
    free = mode.x - mode.covariance @ mode.slopes.T @ mode.residuals

    def below(friction: dict[int, float]) -> str:
        """Return a sum of frictions, if it is surely below 0."""
        row = np.zeros(len(free))
        row[list(friction)] = list(friction.values())
        value, sigma = float(row @ free), float(np.sqrt(row @ mode.covariance @ row))
        return f"{value:.2g} ± {sigma:.1g} N" if value < -_SURELY * sigma else ""

    viscous = {"straight": 0, "bent": 1}
    alarms = [
        f"Friction of the {name} robot falls with speed ({value} s/m): no sum of dry and viscous "
        "friction does. Look for a misread incline, or a zero that moved."
        for name, friction in viscous.items()
        if (value := below({friction: 1.0}))
    ]
    speeds = (data.slip_m_s * np.sin(data.lambda_rad))[data.bent]
    if len(speeds) and below({1: float(speeds.mean()), 3: 1.0}):
        alarms.append(
            "The bent robot has less friction than the straight one, though wheels grip across. "
            "Look at the bend, and whether the robot stood still on the belt."
        )
    return alarms
