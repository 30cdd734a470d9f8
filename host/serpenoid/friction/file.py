"""A friction fit on disk: fit.json beside its session, written whole or not at all."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..base.checks import check_number
from ..base.errors import BadInput
from ..base.files import read_json, write_text
from .result import FrictionFit

# Formats that are read: 2 had more draws, of what readings share, too; 1 had none.
OLDEST, FORMAT = 2, 3
NAME = "fit.json"


def save_fit(fit: FrictionFit, path: str | Path) -> Path:
    """Write a fit to a file, or as fit.json into a session's folder.

    An interrupted write leaves the old file. The same readings give the same file.

    Parameters
    ----------
    fit
        Written with the hash of its readings and this program's version.
    path
        The file, or a folder.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> path = sn.save_fit(sn.fit_friction(session), "fit.json")
    >>> path.name
    'fit.json'
    """
    from importlib.metadata import version

    path = Path(path)
    path = path / NAME if path.is_dir() else path
    values = {"format": FORMAT, "serpenoid_version": version("serpenoid")} | fit.to_dict()
    values["sha256"] = hash_of(values)
    write_text(path, json.dumps(values, allow_nan=False) + "\n")
    return path


def load_fit(path: str | Path) -> FrictionFit:
    """Read a fit from a file, or from fit.json in a session's folder.

    Parameters
    ----------
    path
        The file, or a folder.

    Returns
    -------
    FrictionFit
        Its notes say if the session's readings have changed since.

    Raises
    ------
    BadInput
        The message names the file and what is wrong with it.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> path = sn.save_fit(sn.fit_friction(session), "fit.json")
    >>> sn.load_fit(path).ground.ct > 0
    True
    """
    path = Path(path)
    path = path / NAME if path.is_dir() else path
    if not path.exists():
        raise BadInput(f"{path}: no such file; `serpenoid fit DIR` writes one")
    try:
        content = read_json(path)
    except BadInput as error:
        raise BadInput(f"{error}; `serpenoid fit DIR` writes it anew") from None
    try:
        _check(content)
        fit = FrictionFit.from_dict(content)
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)[:200]
        raise BadInput(
            f"{path}: not a fit of this program: {what}; `serpenoid fit DIR` writes it anew"
        ) from error
    return _with_age(fit, path)


def hash_of(values: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a fit's values."""
    text = json.dumps(values, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _check(content: Mapping[str, Any]) -> None:
    """Raise BadInput if the file has another format, or was edited."""
    written = check_number("format", content["format"])
    if not OLDEST <= written <= FORMAT:
        raise BadInput(f"format is {written}; this version reads formats {OLDEST} to {FORMAT}")
    if content.get("sha256") != hash_of({k: v for k, v in content.items() if k != "sha256"}):
        raise BadInput(
            "sha256 is not that of its numbers: an older version wrote it, or it was edited"
        )


def _with_age(fit: FrictionFit, path: Path) -> FrictionFit:
    """Return the fit, with an alarm if the readings beside the file have changed since."""
    from ..session.folder import load_session

    folder = path.parent
    if not (folder / "session.toml").exists():
        return fit
    with suppress(BadInput):  # Readings that cannot be read count as changed.
        if fit.session_sha256 == load_session(folder).sha256:
            return fit
    alarm = f"{path} is older than the readings beside it: run `serpenoid fit {folder}` again."
    return replace(fit, notes=(*fit.notes, alarm), alarms=(*fit.alarms, alarm))
