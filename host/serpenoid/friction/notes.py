"""Refuse readings that do not determine friction, and write a fit's alarms and notes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import count_text
from ..base.errors import BadInput
from ..model.unit_doubts import unit_doubts
from ..session.session import Session, belt_note
from .bends import BEND_ERROR
from .parameters import ZERO, ZERO_SIGMA_RAD, Rows
from .posterior import MapEstimate
from .result import DOUBTFUL, NO_ZERO, NOT_WEIGHED, FrictionFit

if TYPE_CHECKING:
    from .stations import Stations

APART_CHI2 = 2 * math.log(10.0)  # Difference of chi2 for a likelihood ratio of ten.
# Pushes that determine the frictions along the wheels, and those across.
STRAIGHT_PUSHES = "pushes of the straight robot at 0.9 m/s, both ways, filmed"
BENT_PUSHES = "pushes in the balanced bend of 42 degrees, both ways, filmed"
READING = "reading "  # Start of the names of suspects that are readings.


@dataclass(frozen=True)
class FitLimits:
    """What readings must show, and what is worth a note or an alarm.

    min_bend_sigmas, safe_bend_sigmas: smallest bends, in their sigma, that are accepted, and that
    are advised, advised_lambda_deg at least. Below the first, sin^2 of the bend is unknown; below
    the second, cn is biased by 3 (sigma / lambda)^2, more than 3 %.
    min_span_sigmas: smallest range of the speeds, in their sigma. With less, noise could determine
    the line, and the intervals of a linearised fit would be too narrow.
    open_share: sigma of a friction's force over all force, above which it is not determined.
    weak_information: of a prior that gives undetermined frictions a huge sigma.
    moved_sigmas: difference of two zeros, in its sigma, above which a note is written.
    min_films: fewest films of one place from which a wrong direction is found.
    negative_sigmas: distance of a friction below 0, in its sigma, that is an alarm.
    rough_share: relative sigma above which a friction is known only roughly.
    """

    min_bend_sigmas: float = 5.0
    safe_bend_sigmas: float = 10.0
    advised_lambda_deg: float = 15.0
    min_span_sigmas: float = 4.0
    open_share: float = 0.5
    weak_information: float = 1e-6
    moved_sigmas: float = 2.0
    min_films: int = 3
    negative_sigmas: float = 3.0
    rough_share: float = 0.25


LIMITS = FitLimits()


def check_readings(session: Session, stations: Stations, min_count: int) -> None:
    """Raise BadInput if stations do not determine a friction.

    min_count: fewest straight, and fewest bent, readings. The range of bent readings' speeds counts
    across the wheels.
    """
    sigma_rad = session.setup.instruments.lambda_sigma_rad
    advised_deg = max(
        LIMITS.advised_lambda_deg, math.ceil(math.degrees(sigma_rad) * LIMITS.safe_bend_sigmas)
    )
    across = np.where(stations.bent, np.sin(stations.lambda_rad), 1.0)
    needed_m_s = LIMITS.min_span_sigmas * stations.speed_sigma_m_s
    parts = [
        ("ct and ft0", "straight", "straight (lambda_deg = 0)"),
        ("cn and fn0", "bent", f"with lambda_deg = {advised_deg:g}"),
    ]
    for names, part, pose in parts:
        rows = stations.parts[part]
        count, speeds_m_s = int(rows.sum()), stations.slip_m_s * across
        span_m_s = float(np.ptp(speeds_m_s[rows]) / across[rows].mean()) if count else 0.0
        readings = count_text(count, f"{part} reading")
        if count < min_count or span_m_s < needed_m_s:
            raise BadInput(
                f"{session.where}: {names} cannot be told from {readings} whose "
                f"speeds span {span_m_s:.2g} m/s; they need at least {min_count}, {pose}, whose "
                f"belt speeds span {needed_m_s:.2g} m/s (0.2 and 0.8 m/s, say); take more"
            )
    largest_rad = max(stations.bends.angle_rad)
    if largest_rad <= LIMITS.min_bend_sigmas * sigma_rad:
        raise BadInput(
            f"{session.where}: cn and fn0 cannot be told: lambda_deg is "
            f"{math.degrees(largest_rad):g} with a standard deviation of "
            f"{math.degrees(sigma_rad):g}; a bend must be more than "
            f"{LIMITS.min_bend_sigmas:g} of these from straight; two readings with lambda_deg = "
            f"{advised_deg:g} would do it"
        )


def check_poses(session: Session) -> None:
    """Raise BadInput if no reading of a floor's session is of the bent robot."""
    if not any(reading.lambda_rad for reading in session.fitted):
        raise BadInput(
            f"{session.where}: cn and fn0 cannot be told: in all readings the robot is straight; "
            f"take {BENT_PUSHES}"
        )


def check_floor(session: Session, estimate: MapEstimate) -> None:
    """Raise BadInput if a friction's error is as large as all the force there is on a floor."""
    fast = max(kind.fastest_m_s for kind in estimate.posterior.kinds)
    pairs = [("ct and ft0", 0, 2, STRAIGHT_PUSHES), ("cn and fn0", 1, 3, BENT_PUSHES)]
    information = estimate.slopes.T @ estimate.slopes
    covariance = np.linalg.inv(information + LIMITS.weak_information * np.eye(len(information)))
    sigma = np.sqrt(np.diag(covariance))
    for names, viscous, dry, cure in pairs:
        force = max(estimate.x[viscous] * fast + estimate.x[dry], 1e-9)
        relative_error = max(sigma[viscous] * fast, sigma[dry]) / force
        if not relative_error <= LIMITS.open_share:
            raise BadInput(
                f"{session.where}: {names} cannot be told from these pushes: their error is "
                f"{min(relative_error, 1.0):.0%} of the force or more; take {cure}"
            )


def alarms_of(
    fit: FrictionFit, estimate: MapEstimate, refits: Mapping[str, MapEstimate | None]
) -> tuple[str, ...]:
    """Return what makes a fit no ground for any prediction.

    estimate: MAP of all readings. refits: without each suspect.
    """
    alarms = []
    if fit.p_value is not None and fit.p_value <= DOUBTFUL:
        alarms.append(
            f"chi2 is {fit.chi2:.1f} for {fit.dof} degrees of freedom (p = {fit.p_value:.1g}): the "
            "readings disagree by more than the stated uncertainties allow, so do not trust the "
            f"intervals. {_suspects_in_words(estimate, refits)}"
        )
    for kind in estimate.posterior.kinds:
        if kind.on_belt:
            alarms += _against_the_law(kind, estimate)
    return tuple(alarms)


def notes_on(fit: FrictionFit, session: Session) -> tuple[str, ...]:
    """Return what a reader of the numbers should know beside alarms."""
    doubts = unit_doubts(session.setup.robot, None)
    notes = [f"By session.toml {doubt}." for doubt in doubts]
    if fit.dof <= 0:
        notes.append(
            f"{len(fit.residuals)} readings for 4 frictions leave no degree of freedom: nothing "
            "tells whether they agree. Take one more of each kind."
        )
    weak = []
    for name, (value, sigma) in zip(fit.whole_snake, fit.parameters.values(), strict=True):
        if value == 0.0:
            notes.append(f"{name} ends at its limit of 0: only an upper end is known.")
        elif sigma > LIMITS.rough_share * value:
            weak.append(f"{name} to {sigma / value:.0%}")
    if weak:
        notes.append(
            f"Known only roughly: {', '.join(weak)}. `serpenoid advise DIR` names the reading that "
            "makes speeds surer."
        )
    regenerated = session.setup.provenance.kind == "regenerated"
    if regenerated:
        notes.append(
            "The readings are regenerated from published fits, not measured, and show no scatter; "
            "a joint fit's intervals come from assumed instrument uncertainties."
        )
    robot = session.setup.robot_table
    if robot.mass_kg is None:
        notes.append(
            f"{NOT_WEIGHED}, and one per cent of mass is one per cent of friction: "
            f"weigh it, and write mass_kg = 0.48, say, into session.toml."
        )
    if session.kept_stations and not session.zero.readings and not regenerated:
        sigma_rad = session.zero.sigma_rad or ZERO_SIGMA_RAD
        notes.append(
            f"{NO_ZERO}: 0 ± {math.degrees(sigma_rad):.2g} degrees are assumed, which is "
            f"± {sigma_rad * session.setup.weight_n:.2g} N of ft0. Read it both ways round; that "
            "takes a minute: `serpenoid calibrate add DIR zero incline_deg=0.1 reversed_deg=0`."
        )
    if session.zero.moved_sigmas > LIMITS.moved_sigmas:
        notes.append(
            "The inclinometer's zero moved between before and after by more than its readings' "
            "errors: half of that is in the zero's uncertainty. Let it warm up, and measure again."
        )
    if any(r.lambda_rad and r.bend == "zigzag" for r in session.kept_stations):
        notes.append(
            "The bent readings are of zigzags, every link at lambda (Eq. 60). A robot let go in "
            "one turns within a second, and is then not held by this law. Was it guided? If not, "
            "take them again in the balanced bend."
        )
    kinds = {"station": "voided reading", "push": "voided push"}
    counts = {
        name: sum(r.voided for r in session.readings_of(kind)) for kind, name in kinds.items()
    }
    notes += [f"{count_text(count, name)} left out." for name, count in counts.items() if count]
    if fit.method == "naive":
        notes.append(
            "Naive intervals leave out the errors that readings share (bend, inclinometer zero, "
            "tangential friction in Eq. 61) and are too narrow."
        )
    floor = _floor_notes(session) if session.on_floor else []
    return tuple(filter(None, [*notes, belt_note(session), *floor]))


def _floor_notes(session: Session) -> list[str]:
    """Return notes on what pushes do not determine, and on doubtful ones."""
    notes = []
    if odd := _turned_round(session):
        notes.append(
            f"Pushes {', '.join(map(str, odd))} went the other way in the picture than those of "
            "the same word: is there and back mixed up, or was the camera moved? Void and add them "
            "again with the right way; a wrong one spoils ft0 unseen."
        )
    if session.setup.robot_table.wheels_kg is None:
        from .drift import wheels_share

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
        for place, directions in ways.items()
        if len(directions) == 1
    ]
    return notes


def _turned_round(session: Session) -> list[int]:
    """Return the numbers of filmed pushes whose direction contradicts most others of their place.

    A camera that is not moved shows "there" and "back" in opposite directions.
    """
    films = [push for push in session.kept_pushes if push.source == "film"]
    turned: list[int] = []
    for place in {push.place for push in films}:
        same_place = [push for push in films if push.place == place]
        ways_m = np.array([push.counted[1:, -1] - push.counted[1:, 0] for push in same_place])
        ways_m[[push.way == "back" for push in same_place]] *= -1.0
        directions = ways_m / np.linalg.norm(ways_m, axis=1, keepdims=True)
        opposite = directions @ np.median(directions, axis=0) < 0.0
        if len(same_place) >= LIMITS.min_films:
            turned += [same_place[k].number for k in np.flatnonzero(opposite)]
    return sorted(turned)


def _against_the_law(stations: Any, estimate: MapEstimate) -> list[str]:
    """Return alarms if friction falls with speed, or is less for a bent robot than a straight one.

    The frictions are those of one Gauss-Newton step from the MAP estimate, without limits.
    """
    covariance = estimate.covariance
    free = estimate.x - covariance @ estimate.slopes.T @ estimate.residuals

    def negative(*terms: float) -> str:
        """Return terms times (ct, cn, ft0, fn0) in words if the sum is significantly below 0."""
        value = float(free[:4] @ terms)
        sigma = math.sqrt(terms @ covariance[:4, :4] @ terms)
        return f"{value:.2g} ± {sigma:.1g} N" if value < -LIMITS.negative_sigmas * sigma else ""

    alarms = [
        f"Friction of the {name} robot falls with speed ({value} s/m): no sum of dry and viscous "
        "friction does. Look for a misread incline, or a zero that moved."
        for name, value in (("straight", negative(1, 0, 0, 0)), ("bent", negative(0, 1, 0, 0)))
        if value
    ]
    across_m_s = (stations.slip_m_s * np.sin(stations.lambda_rad))[stations.bent]
    if len(across_m_s) and negative(0.0, float(across_m_s.mean()), 0.0, 1.0):
        alarms.append(
            "The bent robot has less friction than the straight one, though wheels grip across. "
            "Look at the bend, and whether the robot stood still on the belt."
        )
    return alarms


def suspects(session: Session, estimate: MapEstimate) -> dict[str, Rows]:
    """Return masks of residuals that may be wrong together: of readings, files, bends, the zero."""
    posterior = estimate.posterior
    rows = {f"{READING}{number}": posterior.numbers == number for number in posterior.readings}
    files: dict[str, list[int]] = {}
    for push in session.kept_pushes:
        files.setdefault(push.file_sha256, []).append(push.number)
    for sha256, numbers in files.items():
        if sha256 and len(numbers) > 1:
            listed = f"the file of readings {', '.join(map(str, numbers))}"
            rows[listed] = np.isin(posterior.numbers, numbers)
    priors = np.arange(len(posterior.numbers)) - len(posterior.numbers) + len(posterior.names)
    for k, name in enumerate(posterior.names):
        words = "the inclinometer's zero as it was read" if name == ZERO else ""
        if name.startswith(BEND_ERROR):
            degrees, _, where = name.removeprefix(BEND_ERROR).partition("_deg")
            words = f"the bend of {degrees}°{' on the floor' * bool(where)} as it was set"
        if words:
            rows[words] = rows.get(words, False) | (priors == k)
    return rows


def _suspects_in_words(estimate: MapEstimate, refits: Mapping[str, MapEstimate | None]) -> str:
    """Return a sentence on the suspects without which chi2 is smallest.

    Residuals would mislead, since a line follows its outlier. Only suspects without which the other
    readings still determine all frictions are compared.
    """
    sound = {words: refit for words, refit in refits.items() if refit}
    if not sound:
        return "No reading can be left out to see which one is wrong: take more."
    rows = len(estimate.residuals)
    score = {
        w: fit.chi2 + 2.0 * (rows - np.count_nonzero(fit.residuals)) for w, fit in sound.items()
    }
    named = [words for words in sound if score[words] < min(score.values()) + APART_CHI2]
    numbers = sorted(int(w.removeprefix(READING)) for w in named if w.startswith(READING))
    parts = [READING + _listed(list(map(str, numbers)))] if numbers else []
    parts += [words for words in named if not words.startswith(READING)]
    return (
        f"Without {_listed(parts)} chi2 would be {max(sound[w].chi2 for w in named):.1f} or less: "
        "look there first, and void what was misread."
    )


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
