"""What a reader of a fit should know, in words: alarms, suspects, and what nobody measured."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..base.errors import NotConverged
from ..session.session import Session, belt_note
from .bends import BEND_ERROR
from .drift import wheels_share
from .identifiability import bend_note
from .parameters import Floats
from .posterior import MapEstimate
from .result import DOUBTFUL, NO_ZERO, NOT_WEIGHED, FrictionFit
from .stations import ZERO, ZERO_SIGMA_RAD, Stations

APART_CHI2 = 2 * math.log(10.0)  # one suspect is then ten times as likely as another
MOVED_SIGMAS = 2.0  # of its difference, beyond which a zero that moved is told
NEGATIVE_SIGMAS = 3.0  # below 0, from which a friction is an alarm
WEAK = 0.25  # relative standard deviation of a friction that is known only roughly
Rows = NDArray[np.bool_]


def alarms_of(
    fit: FrictionFit,
    session: Session,
    estimate: MapEstimate,
    refits: Mapping[int, tuple[float, Floats] | None],
) -> tuple[str, ...]:
    """Return what makes a fit no ground for any prediction.

    estimate: MAP of all readings. refits: without each reading.
    """
    alarms = []
    if fit.p_value is not None and fit.p_value <= DOUBTFUL:
        alarms.append(
            f"chi2 is {fit.chi2:.1f} for {fit.dof} degrees of freedom (p = {fit.p_value:.1g}): the "
            "readings disagree by more than the stated uncertainties allow, so do not trust the "
            f"intervals. {_suspects_in_words(session, estimate, refits)}"
        )
    for kind in estimate.posterior.kinds:
        if isinstance(kind, Stations):
            alarms += _against_the_law(kind, estimate)
    return tuple(alarms)


def notes_on(fit: FrictionFit, session: Session) -> tuple[str, ...]:
    """Return what a reader of the numbers should know beside alarms."""
    notes = []
    if fit.dof <= 0:
        notes.append(
            f"{len(fit.residuals)} readings for 4 frictions leave no degree of freedom: nothing "
            "tells whether they agree. Take one more of each kind."
        )
    notes += _weak_notes(fit)
    regenerated = session.setup.provenance.kind == "regenerated"
    if regenerated:
        notes.append(
            "The readings are regenerated from published fits, not measured, and show no scatter; "
            "a joint fit's intervals come from assumed instrument uncertainties."
        )
    robot = session.setup.robot_table
    if not robot.weighs:
        notes.append(
            f"{NOT_WEIGHED}, and one per cent of mass is one per cent of friction: "
            f"weigh it, and write mass_kg = 0.48, say, into session.toml."
        )
    if session.kept and not session.zero.readings and not regenerated:
        sigma_rad = session.zero.sigma_rad or ZERO_SIGMA_RAD
        notes.append(
            f"{NO_ZERO}: 0 ± {math.degrees(sigma_rad):.2g} degrees are assumed, which is "
            f"± {sigma_rad * session.setup.weight_n:.2g} N of ft0. Read it both ways round; that "
            "takes a minute: `serpenoid calibrate add DIR zero incline_deg=0.1 reversed_deg=0`."
        )
    if session.zero_moved_sigmas > MOVED_SIGMAS:
        notes.append(
            "The inclinometer's zero moved between before and after by more than its readings' "
            "errors: half of that is in the zero's uncertainty. Let it warm up, and measure again."
        )
    if any(r.lambda_rad and r.bend == "zigzag" for r in session.kept):
        notes.append(
            "The bent readings are of zigzags, every link at lambda (Eq. 60). A robot let go in "
            "one turns within a second, and is then not held by this law. Was it guided? If not, "
            "take them again in the balanced bend."
        )
    for kind, name in (("station", "reading"), ("push", "push")):
        voided = sum(reading.voided for reading in session.of(kind))
        if voided:
            notes.append(f"{voided} voided {name}(s) left out.")
    if fit.method == "naive":
        notes.append(
            "Naive intervals leave out the errors that readings share (bend, inclinometer zero, "
            "tangential friction in Eq. 61) and are too narrow."
        )
    floor = _floor_notes(session) if session.on_floor else []
    return tuple(filter(None, [*notes, belt_note(session), bend_note(session), *floor]))


def _weak_notes(fit: FrictionFit) -> list[str]:
    """Return which frictions are known only roughly."""
    notes, weak = [], []
    for name, (value, sigma) in zip(fit.whole_snake, fit.parameters.values(), strict=True):
        if value == 0.0:
            notes.append(f"{name} ends at its limit of 0: only an upper end is known.")
        elif sigma > WEAK * value:
            weak.append(f"{name} to {sigma / value:.0%}")
    if weak:
        notes.append(
            f"Known only roughly: {', '.join(weak)}. `serpenoid advise DIR` names the reading that "
            "makes speeds surer."
        )
    return notes


def _floor_notes(session: Session) -> list[str]:
    """Return what pushes leave open, and what was odd about them."""
    notes = []
    if odd := _turned_round(session):
        notes.append(
            f"Push(es) {', '.join(map(str, odd))} went the other way in the picture than those of "
            "the same word: is there and back mixed up, or was the camera moved? Void and add them "
            "again with the right way; a wrong one spoils ft0 unseen."
        )
    if session.setup.robot_table.wheels_kg is None:
        mean, sigma = wheels_share(session)
        notes.append(
            f"Nobody said what the wheels weigh: their turning is taken for {mean:.1%} ± "
            f"{sigma:.1%} of the mass. wheels_kg in session.toml makes all four frictions surer."
        )
    ways: dict[str, set[str]] = {}
    for push in session.kept_pushes:
        ways.setdefault(push.place, set()).add(push.way)
    slope_deg = math.degrees(session.setup.instruments.floor_slope_sigma_rad)
    notes += [
        f"All pushes{' at ' + place if place else ''} went one way: the floor may slope by "
        f"{slope_deg:.2g} degrees, and ft0 is only as sure as that. Push as often the other way."
        for place, both in ways.items()
        if len(both) == 1
    ]
    return notes


def _turned_round(session: Session) -> list[int]:
    """Return the filmed pushes that go the other way in the picture than their word says.

    By the most of a place: a camera that stays shows "there" and "back" in opposite directions.
    """
    ways: dict[str, dict[int, NDArray[np.float64]]] = {}
    for push in session.kept_pushes:
        if push.by == "film":
            _, x, y = push.counted
            sign = 1.0 if push.way == "there" else -1.0
            way = sign * np.array([x[-1] - x[0], y[-1] - y[0]])
            ways.setdefault(push.place, {})[push.number] = way / np.hypot(*way)
    turned = []
    for numbered in ways.values():
        usual = np.median(list(numbered.values()), axis=0)
        if len(numbered) > 2:
            turned += [number for number, way in numbered.items() if way @ usual < 0.0]
    return sorted(turned)


def _against_the_law(stations: Stations, estimate: MapEstimate) -> list[str]:
    """Say where friction falls with speed, or a bent robot has less of it than a straight one.

    By one linear step from the MAP estimate, which no limit of 0 ends.
    """
    covariance = estimate.covariance
    free = estimate.x - covariance @ estimate.slopes.T @ estimate.residuals

    def negative(*terms: float) -> str:
        """Return the sum of ct, cn, ft0, fn0 times terms in words, if it is surely below 0."""
        value = float(free[:4] @ terms)
        sigma = math.sqrt(terms @ covariance[:4, :4] @ terms)
        return f"{value:.2g} ± {sigma:.1g} N" if value < -NEGATIVE_SIGMAS * sigma else ""

    viscous = {"straight": negative(1.0, 0.0, 0.0, 0.0), "bent": negative(0.0, 1.0, 0.0, 0.0)}
    alarms = [
        f"Friction of the {name} robot falls with speed ({value} s/m): no sum of dry and viscous "
        "friction does. Look for a misread incline, or a zero that moved."
        for name, value in viscous.items()
        if value
    ]
    speeds = (stations.slip_m_s * np.sin(stations.lambda_rad))[stations.bent]
    if len(speeds) and negative(0.0, float(speeds.mean()), 0.0, 1.0):
        alarms.append(
            "The bent robot has less friction than the straight one, though wheels grip across. "
            "Look at the bend, and whether the robot stood still on the belt."
        )
    return alarms


def _suspects_in_words(
    session: Session, estimate: MapEstimate, refits: Mapping[int, tuple[float, Floats] | None]
) -> str:
    """Name what to look at first: without it the readings disagree least.

    Residuals would mislead, for a line follows its outlier. A suspect is one without which the
    others still tell every friction.
    """
    posterior = estimate.posterior
    left = {f"reading {number}": one[0] for number, one in refits.items() if one is not None}
    rows = {words: int(np.sum(posterior.numbers == int(words.split()[1]))) for words in left}
    for words, omitted in _shared_suspects(session, estimate).items():
        try:
            one = posterior.estimate(estimate.x, omitted)
        except NotConverged:
            continue
        if one.determined:
            left[words], rows[words] = one.chi2, int(omitted.sum())
    if not left:
        size = np.where(posterior.numbers >= 0, np.abs(estimate.residuals), 0.0)
        worst = posterior.numbers[int(np.argmax(size))]
        return f"Look at reading {worst} first: it is furthest off."
    score = {words: chi2 + 2.0 * rows[words] for words, chi2 in left.items()}
    least = min(score.values())
    return _named({w: chi2 for w, chi2 in left.items() if score[w] < least + APART_CHI2})


def _shared_suspects(session: Session, estimate: MapEstimate) -> dict[str, Rows]:
    """Return residuals that may be wrong together, by what they are: files, bends, zero."""
    posterior, suspects = estimate.posterior, dict[str, Rows]()
    files: dict[str, list[int]] = {}
    for push in session.kept_pushes:
        files.setdefault(push.file_sha256, []).append(push.number)
    for sha256, numbers in files.items():
        if sha256 and len(numbers) > 1:
            named = ", ".join(map(str, numbers))
            suspects[f"the file of readings {named}"] = np.isin(posterior.numbers, numbers)
    first = len(posterior.numbers) - len(posterior.names)  # of priors, less the frictions' names
    for k, name in enumerate(posterior.names[4:], first + 4):
        words = "the inclinometer's zero as it was read" if name == ZERO else ""
        if name.startswith(BEND_ERROR):
            degrees, _, where = name.removeprefix(BEND_ERROR).partition("_deg")
            place = " on the floor" if where.startswith("_on_floor") else ""
            words = f"the bend of {degrees}°{place} as it was set"
        if words:
            own = np.arange(len(posterior.numbers)) == k
            suspects[words] = suspects.get(words, False) | own
    return suspects


def _named(left: Mapping[str, float]) -> str:
    """Say what to look at; left: chi2 without each."""
    if len(left) == 1:
        ((words, chi2),) = left.items()
        return (
            f"Without {words} chi2 would be {chi2:.1f}: look at that one first. Void it if it was "
            "misread."
        )
    numbers = sorted(int(w.removeprefix("reading ")) for w in left if w.startswith("reading "))
    others = [words for words in left if not words.startswith("reading ")]
    parts = [f"reading {_listed(list(map(str, numbers)))}"] if numbers else []
    return (
        f"Without {_listed([*parts, *others])} chi2 would be {max(left.values()):.1f} or less: "
        "look at those first. Another reading of their series tells which one is wrong."
    )


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
