"""What makes a fit no ground for any prediction: readings that contradict each other or the law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .fitting.bends import resistance
from .fitting.identifiability import bend_note
from .fitting.paper_fit import errors, points, two_lines
from .fitting.posterior import Mode
from .fitting.stations import Stations
from .fitting.suspects import suspects_in_words
from .floor.notes import floor_notes
from .friction_result import DOUBTFUL, FrictionFit, notes_on
from .session import Session

_SURELY = 3.0  # standard deviations below 0, from which a friction is an alarm


def with_alarms(fit: FrictionFit, session: Session, mode: Mode) -> FrictionFit:
    """Return a fit with its notes; first those that say why it is not to be trusted, if any.

    mode: of all readings, none taken for misread.
    """
    stations = [block for block in mode.posterior.blocks if isinstance(block, Stations)]
    alarms = [
        *_contradiction(fit, session, mode),
        *(a for s in stations for a in _against_the_law(s)),
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


def _against_the_law(data: Stations) -> list[str]:
    """Say where friction falls with speed, or a bent robot has less of it than a straight one.

    By lines through the readings alone, since the fit itself keeps its parameters at 0 or above.
    """
    values = two_lines(data)[0]
    slope = resistance(np.abs(values), data.bends.share, data.lambda_rad, data.back)[0]
    found = points(data, values)
    errors_n = {part: sigmas[1] for part, sigmas in errors(data, slope).items()}
    alarms = []
    named = (("straight", "straight", 0), ("back", "upward-facing", 4), ("bent", "bent", 1))
    for part, name, k in named:
        speeds, error_n = found[part][0], errors_n[part]
        if len(speeds) < 2 or np.ptp(speeds) == 0.0:
            continue
        sigma = float(error_n.mean()) / (float(speeds.std()) * np.sqrt(len(speeds)))
        if values[k] < -_SURELY * sigma:
            alarms.append(
                f"Friction of the {name} robot falls with speed ({values[k]:.2g} ± {sigma:.1g} "
                "N s/m): no sum of dry and viscous friction does. Look for a misread incline, or a "
                "zero that moved."
            )
    forces = found["bent"][1]
    if len(forces) and forces.mean() < -_SURELY * errors_n["bent"].mean() / np.sqrt(len(forces)):
        alarms.append(
            "The bent robot has less friction than the straight one, though wheels grip across. "
            "Look at the bend, and whether the robot stood still on the belt."
        )
    return alarms
