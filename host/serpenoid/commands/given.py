"""The friction that a command takes from a calibration: --session DIR or --ground fit.json."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..model.errors import BadInput
from ..show.screen import say

if TYPE_CHECKING:
    from ..calibration.friction_result import FrictionFit
    from ..calibration.speed_samples import SpeedBand
    from ..model.drives import ServoKind
    from ..model.gait import Gait
    from ..model.ground import Ground
    from ..model.robot import Robot

ALARMS = "serpenoid.alarms"  # of click's context: keys that show_json puts into every answer


def take_fit(given: dict[str, Any]) -> FrictionFit | None:
    """Take the fit of --session or --ground, None if neither was given; its alarms are told."""
    session, ground = given.pop("session", None), given.pop("ground_file", None)
    if session is not None and ground is not None:
        raise click.UsageError("give one of --session and --ground")
    if session is not None:
        return session_fit(session)
    if ground is None:
        return None
    from ..calibration.fit_file import load_fit

    fit = load_fit(ground)
    return tell_alarms(fit, [note for note in fit.notes if "is older than the readings" in note])


def session_fit(folder: Path, with_crawls: bool = True) -> FrictionFit:
    """Return a session's fit.json if it is that of its readings, else fit them now.

    with_crawls: whether one that rests on crawls will do, which is no test of them.
    """
    from ..calibration.fit_file import NAME, load_fit, rests_on
    from ..calibration.friction_fit import fit_friction
    from ..calibration.session_file import load_session

    session = load_session(folder)
    if (folder / NAME).exists():
        try:
            kept = load_fit(folder)
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
        except BadInput as error:  # an older version's, or edited: the readings are there
            say(f"serpenoid: warning: {error}; fitted anew", err=True)
    return tell_alarms(fit_friction(session))


def servo_as_filmed(
    kind: ServoKind | None, session: Path | None, fit: FrictionFit | None
) -> ServoKind | None:
    """Return the kind with the servos that a fit's crawls or a session's films leave; tell it.

    At the session's voltage, with the frames of its board.
    """
    from ..calibration.session_file import read_session

    if kind is None or fit is None:
        return kind
    if session is not None:
        kind = read_session(session).setup.driving(kind)
    if fit.servos is not None and fit.servos.kind == kind.name:
        say(f"servos: those of {kind.name} that the fit's crawls leave possible", err=True)
        return replace(kind, drawn=tuple(fit.sample_servos(kind, len(fit.servos.index))))
    if session is None:
        return kind
    from ..calibration.filmed_joints import servo_seen

    films = read_session(session).kept_films
    seen = servo_seen(kind, films, fit)
    if seen is not kind:
        say(f"servos: those of {kind.name} that would move the joints as filmed", err=True)
    return seen


def predicted_band(
    fit: FrictionFit | None,
    robot: Robot,
    ground: Ground,
    gait: Gait,
    servo: ServoKind | None = None,
    commanded: Gait | None = None,
) -> SpeedBand | None:
    """Return the one 95 % band of a gait's speed; None where robot and ground are not a fit's.

    commanded: as for `speed_band`.
    """
    if fit is None or (robot, ground) != (fit.robot, fit.ground):
        return None
    from ..calibration.speed_samples import speed_band

    return speed_band(fit, gait, servo=servo, commanded=commanded)


def tell_alarms(fit: FrictionFit, more: list[str] | None = None) -> FrictionFit:
    """Warn of what forbids to trust a fit, note what was not measured; show_json has both."""
    alarms = [*fit.alarms, *(more or [])]
    for alarm in alarms:
        say(f"serpenoid: warning: {alarm}", err=True)
    for note in fit.unmeasured:
        say(f"note: {note}", err=True)
    context = click.get_current_context(silent=True)
    if context is not None:
        answers = {"fit_alarms": alarms, "fit_notes": fit.unmeasured}
        context.meta[ALARMS] = {key: words for key, words in answers.items() if words}
    return fit
