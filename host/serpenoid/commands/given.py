"""The friction that a command takes from a calibration: --session DIR or --ground fit.json."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ..calibration.friction_result import FrictionFit


def take_fit(given: dict[str, Any]) -> FrictionFit | None:
    """Take the fit of --session or --ground, None if neither was given."""
    session, ground = given.pop("session", None), given.pop("ground_file", None)
    if session is not None and ground is not None:
        raise click.UsageError("give one of --session and --ground")
    if session is not None:
        return session_fit(session)
    if ground is None:
        return None
    from ..calibration.fit_file import load_fit

    return _tell_age(load_fit(ground))


def session_fit(folder: Path) -> FrictionFit:
    """Return a session's fit.json if it is that of its readings, else fit them now."""
    from ..calibration.fit_file import NAME, load_fit
    from ..calibration.friction_fit import fit_friction
    from ..calibration.session_file import load_session

    session = load_session(folder)
    if (folder / NAME).exists():
        kept = load_fit(folder)
        if kept.session_sha256 == session.sha256:
            return kept
    return fit_friction(session)


def _tell_age(fit: FrictionFit) -> FrictionFit:
    for note in fit.notes:
        if "is older than the readings" in note:
            click.echo(f"serpenoid: warning: {note}", err=True)
    return fit
