"""The friction that a command takes from a calibration: --session DIR or --ground fit.json."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

import serpenoid as sn

from ..show.screen import say
from .declare import FOLDER, Given, option

if TYPE_CHECKING:
    from ..prediction.speed_samples import SpeedBand
    from ..session.film import FilmReading

ALARMS = "serpenoid.alarms"  # of click's context: keys that show_json puts into every answer


def take_fit(given: Given) -> sn.FrictionFit | None:
    """Take the fit of --session or --ground, None if neither was given; its alarms are told."""
    session, ground = given.pop("session", None), given.pop("ground_file", None)
    if session is not None and ground is not None:
        raise click.UsageError("give one of --session and --ground")
    if session is not None:
        return session_fit(session)
    if ground is None:
        return None

    fit = sn.load_fit(ground)
    return tell_alarms(fit, [note for note in fit.notes if "is older than the readings" in note])


def session_fit(folder: Path, with_crawls: bool = True) -> sn.FrictionFit:
    """Return a session's fit.json if it is that of its readings, else fit them now.

    with_crawls: whether one that rests on crawls will do, which is no test of them.
    """
    from ..calibration.fit_file import NAME, rests_on

    session = sn.load_session(folder)
    if (folder / NAME).exists():
        try:
            kept = sn.load_fit(folder)
            if not with_crawls and kept.with_crawls:
                say(
                    "note: fit.json has crawls in it, so it is no test of them: fitted without",
                    err=True,
                )
            elif rests_on(kept, session):
                return tell_alarms(kept)
            elif kept.with_crawls:
                say(
                    f"serpenoid: warning: {folder / NAME} is older than the readings: fitted anew, "
                    f"without crawls; `serpenoid fit {folder} --crawls` takes them",
                    err=True,
                )
        except sn.BadInput as error:  # an older version's, or edited: the readings are there
            say(f"serpenoid: warning: {error}; fitted anew", err=True)
    return tell_alarms(sn.fit_friction(session))


def servo_as_filmed(kind: sn.ServoKind | None, fit: sn.FrictionFit | None) -> sn.ServoKind | None:
    """Return the kind with the servos that a fit's crawls or --session's films leave; tell it.

    At the session's voltage, with the frames of its board.
    """
    from ..prediction.filmed_joints import servo_seen
    from ..session.folder import read_session

    if kind is None or fit is None:
        return kind
    folder = click.get_current_context().params["session"]
    session = None if folder is None else read_session(folder)
    if session is not None:
        kind = session.setup.driving(kind)
    if fit.servos is not None and fit.servos.kind == kind.name:
        say(f"servos: those of {kind.name} that the fit's crawls leave possible", err=True)
        return replace(kind, drawn=tuple(fit.sample_servos(kind, len(fit.servos.index))))
    if session is None:
        return kind
    filmed = servo_seen(kind, session.kept_films, fit)
    if filmed is not kind:
        say(f"servos: those of {kind.name} that would move the joints as filmed", err=True)
    return filmed


def is_of_fit(fit: sn.FrictionFit | None, robot: sn.Robot, ground: sn.Ground) -> bool:
    """Return whether robot and ground are a fit's own, without an option that changes them."""
    return fit is not None and (robot, ground) == (fit.robot, fit.ground)


def predicted_band(
    fit: sn.FrictionFit | None,
    robot: sn.Robot,
    ground: sn.Ground,
    gait: sn.Gait,
    servo: sn.ServoKind | None = None,
    commanded: sn.Gait | None = None,
) -> SpeedBand | None:
    """Return the one 95 % band of a gait's speed; None where robot and ground are not a fit's.

    commanded: as for `speed_band`.
    """
    if fit is None or not is_of_fit(fit, robot, ground):
        return None
    from ..prediction.speed_samples import speed_band

    return speed_band(fit, gait, servo=servo, commanded=commanded)


def tell_alarms(fit: sn.FrictionFit, more: list[str] | None = None) -> sn.FrictionFit:
    """Warn of what forbids to trust a fit, note what was not measured; show_json has both."""
    alarms = [*fit.alarms, *(more or [])]
    for alarm in alarms:
        say(f"serpenoid: warning: {alarm}", err=True)
    for note in fit.unmeasured:
        say(f"note: {note}", err=True)
    context = click.get_current_context(silent=True)
    if context is not None:
        answers = {"fit_alarms": alarms, "fit_notes": fit.unmeasured}
        alarms_of_answer = context.meta.setdefault(ALARMS, {})
        alarms_of_answer.update({key: words for key, words in answers.items() if words})
    return fit


def tell_remark(kind: sn.ServoKind) -> None:
    """Warn once of a servo file whose test the model did not describe; show_json has it, too."""
    context = click.get_current_context()
    alarms = context.meta.setdefault(ALARMS, {})
    if kind.remark and "servo_remark" not in alarms:
        alarms["servo_remark"] = kind.remark
        say(f"serpenoid: warning: servo {kind.name}: {kind.remark}", err=True)


_SAME_RAD, _SAME_RATE = 1e-3, 0.01
joints_option = option(
    "--joints",
    "Session with a film: its joints' gains and phases, in place of the commanded ones.",
    type=FOLDER,
    metavar="SESSION",
)


def latest_film(session: Path, links: int) -> FilmReading:
    """Return the latest film of a session. Raises BadInput: none, or of another robot."""
    from ..base.errors import BadInput
    from ..session.folder import read_session

    films = read_session(session).kept_films
    if not films:
        raise BadInput(
            f"{session}: holds no film; measure one with `serpenoid video FILE --session {session}`"
        )
    joints = len(films[-1].gait.joint_gain)
    if joints != links - 1:
        raise BadInput(f"{session}: its film shows {joints} joints; the robot has {links - 1}")
    return films[-1]


def with_joints(gait: sn.Gait, session: Path | None, links: int) -> sn.Gait:
    """Return the gait as a session's film says that the joints make it."""
    if session is None:
        return gait
    seen = latest_film(session, links).gait
    return replace(gait, joint_gain=seen.joint_gain, joint_shift_rad=seen.joint_shift_rad)


def was_filmed(gait: sn.Gait, session: Path, links: int) -> bool:
    """Tell whether a session's latest film shows this commanded gait; its board's clock errs."""
    asked = latest_film(session, links).commanded
    apart = abs(asked.alpha_rad - gait.alpha_rad), abs(asked.beta_rad - gait.beta_rad)
    return max(apart) < _SAME_RAD and abs(asked.omega_rad_s / gait.omega_rad_s - 1.0) < _SAME_RATE
