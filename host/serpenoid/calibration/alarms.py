"""What makes a fit no ground for any prediction: readings that contradict each other or the law."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .fitting.data import FitData, Floats
from .fitting.influence import leave_one_out
from .fitting.joint import Minimum, minimise, starting_point
from .fitting.paper_fit import points, two_lines
from .friction_result import DOUBTFUL, FrictionFit
from .session import Session

_REFITTED = 5  # so many suspects are fitted without, since a gross outlier is no linear step
_TOLD_APART = 2 * math.log(10.0)  # of chi2: one suspect is then ten times as likely as another
_SURELY = 3.0  # standard deviations below 0, from which a friction is an alarm


def with_alarms(
    fit: FrictionFit, session: Session, data: FitData, found: Minimum | None = None
) -> FrictionFit:
    """Return a fit that says in words why it is not to be trusted; unchanged where it may be.

    found: the joint minimum, solved for if it is not given. The alarms are the first of the notes,
    too.
    """
    alarms = [*_contradiction(fit, session, data, found), *_against_the_law(data)]
    return replace(fit, alarms=tuple(alarms), notes=(*alarms, *_freedom(fit), *fit.notes))


def parts(data: FitData) -> tuple[int, int, int]:
    """Return how many readings are straight forwards, straight backwards, and bent."""
    straight, back = ~data.bent & ~data.back, ~data.bent & data.back
    return int(np.sum(straight)), int(np.sum(back)), int(np.sum(data.bent))


def _freedom(fit: FrictionFit) -> list[str]:
    if fit.dof > 0:
        return []
    return [
        f"{len(fit.residuals)} readings for {len(fit.names)} frictions leave no degree of freedom: "
        "nothing tells whether they agree. Take one more of each kind."
    ]


def _contradiction(
    fit: FrictionFit, session: Session, data: FitData, found: Minimum | None
) -> list[str]:
    """Say that the readings disagree, and without which one they would disagree least.

    Residuals would mislead, for a line follows its outlier. A part is left with two readings at
    least. Where only two are left, any line may pass, and several readings are suspects alike.
    """
    if fit.p_value is None or fit.p_value > DOUBTFUL:
        return []
    told = (
        f"chi2 is {fit.chi2:.1f} for {fit.dof} degrees of freedom (p = {fit.p_value:.1g}): the "
        "readings disagree by more than the stated uncertainties allow, so do not trust the "
        "intervals."
    )
    found = found or minimise(data, starting_point(two_lines(data)[0], data))
    enough = np.array(parts(data))[np.where(data.bent, 2, data.back)] > 2
    chi2 = np.where(enough, leave_one_out(found, len(data)).chi2, np.inf)
    suspects = [int(k) for k in np.argsort(chi2)[:_REFITTED] if enough[k]]
    if not suspects:
        worst = int(np.argmax(np.abs(fit.residuals)))
        return [f"{told} Look at reading {session.kept[worst].number} first: it is furthest off."]
    left = {k: minimise(data.without(k), found.x).chi2 for k in suspects}
    return [f"{told} {_suspects({session.kept[k].number: left[k] for k in suspects})}"]


def _suspects(left: dict[int, float]) -> str:
    """Name the readings to look at; left: chi2 without each."""
    least = min(left.values())
    alike = sorted(number for number, chi2 in left.items() if chi2 < least + _TOLD_APART)
    if len(alike) == 1:
        return (
            f"Without reading {alike[0]} chi2 would be {least:.1f}: look at that one first, or fit "
            "with method 'robust'."
        )
    numbers = f"{', '.join(map(str, alike[:-1]))} or {alike[-1]}"
    most = max(left[number] for number in alike)
    return (
        f"Without reading {numbers} chi2 would be {most:.1f} or less: look at those first. Another "
        "reading of their series tells which one is wrong."
    )


def _against_the_law(data: FitData) -> list[str]:
    """Say where friction falls with speed, or a bent robot has less of it than a straight one.

    By lines through the readings alone, since the fit itself keeps its parameters at 0 or above.
    """
    values = two_lines(data)[0]
    found, errors = points(data, values), _errors_n(data)
    alarms = []
    named = (("straight", "straight", 0), ("back", "upward-facing", 4), ("bent", "bent", 1))
    for part, name, k in named:
        speeds, error_n = found[part][0], errors[part]
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
    if len(forces) and forces.mean() < -_SURELY * errors["bent"].mean() / np.sqrt(len(forces)):
        alarms.append(
            "The bent robot has less friction than the straight one, though wheels grip across. "
            "Look at the bend, and whether the robot stood still on the belt."
        )
    return alarms


def _errors_n(data: FitData) -> dict[str, Floats]:
    """Return part -> standard deviation of each point's force, N; speeds' errors by their slope."""
    (ct, _), cn = data.along(np.abs(two_lines(data)[0])), abs(two_lines(data)[0][1])
    alone = data.alone
    pull = alone.weight_n * np.cos(alone.incline_rad) * alone.incline_sigma_rad
    sin = np.maximum(np.sin(data.lambda_rad), 1e-9)
    slope = np.where(data.bent, ct + cn * sin**2, ct)
    force = np.hypot(pull, slope * data.speed_sigma_m_s)
    across = force / np.maximum(data.bent_share * sin, 1e-9)
    ahead, back = ~data.bent & ~data.back, ~data.bent & data.back
    return {"straight": force[ahead], "back": force[back], "bent": across[data.bent]}
