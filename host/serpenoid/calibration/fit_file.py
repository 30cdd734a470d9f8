"""A friction fit on disk: fit.json beside its session, written whole or not at all."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ..base.checks import check_number
from ..base.errors import BadInput
from ..base.files import read_json, write_text
from ..base.vectors import number_array
from ..model.robot import Robot
from ..session.session import Session
from .fitting.shared import FRICTIONS
from .fitting.suspects import Influence
from .friction_result import (
    METHODS,
    WHOLE,
    Estimate,
    FitDraws,
    Floats,
    FrictionFit,
    fit_of,
    normal_draws,
)

FORMAT = 3  # 2 had draws of what readings share, too, 1 had none
NAME = "fit.json"
_LONGEST = 200  # letters of a reason
# By SciPy, from the covariance, or, where a file of format 1 has none, at random.
_COMPUTED = ("p_value", "parameters", "draws")


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
    path = Path(path)
    path = path / NAME if path.is_dir() else path
    text = json.dumps(_as_json(fit), allow_nan=False) + "\n"
    write_text(path, text)
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
        given = read_json(path)
    except BadInput as error:
        raise BadInput(f"{error}; `serpenoid fit DIR` writes it anew") from None
    try:
        fit = _from_json(given)
        _check_sound(fit, given)
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)[:_LONGEST]
        raise BadInput(
            f"{path}: not a fit of this program: {what}; `serpenoid fit DIR` writes it anew"
        ) from error
    return _with_age(fit, path)


def rests_on(fit: FrictionFit, session: Session) -> bool:
    """Return whether a fit is that of a session as it is now."""
    return session.sha256 == fit.session_sha256


def _with_age(fit: FrictionFit, path: Path) -> FrictionFit:
    """Note that the readings beside the file are no longer those it was fitted to."""
    from ..session.folder import load_session

    folder = path.parent
    if not (folder / "session.toml").exists():
        return fit
    try:
        if rests_on(fit, load_session(folder)):
            return fit
    except BadInput:
        pass  # readings that cannot be read are others, too
    note = f"{path} is older than the readings beside it: run `serpenoid fit {folder}` again."
    return replace(fit, notes=(*fit.notes, note))


def _as_json(fit: FrictionFit) -> dict[str, Any]:
    from importlib.metadata import version

    values = {"format": FORMAT, "serpenoid_version": version("serpenoid")} | fit.to_dict()
    return values | {"sha256": _hash(values)}


def _hash(values: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a fit's own numbers and texts."""
    text = json.dumps(values, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _check(given: Mapping[str, Any]) -> None:
    """Raise BadInput where the file is of a later format, or not as a fit wrote it."""
    if check_number("format", given["format"], 1) > FORMAT:
        raise BadInput(
            f"format is {given['format']}; this version reads formats up to {FORMAT}; install a "
            "newer one"
        )
    if given["method"] not in METHODS:
        raise BadInput(f"method is {given['method']}; this version fits by {' or '.join(METHODS)}")
    if given.get("sha256") != _hash({k: v for k, v in given.items() if k != "sha256"}):
        raise BadInput(
            "sha256 is not that of its numbers: an older version wrote it, or it was edited"
        )


def _check_sound(fit: FrictionFit, given: Mapping[str, Any]) -> None:
    """Raise BadInput where numbers are none of a fit, or a file says other than its fit would."""
    again = json.loads(json.dumps(fit.to_dict()))
    differ = [k for k in again if k in given and k not in _COMPUTED and again[k] != given[k]]
    covariance, draws = fit.covariance, fit.draws
    count = len(fit.parameters)
    least = float(np.linalg.eigvalsh(covariance)[0])
    intervals = [(0.0, row.low, row.value, row.high) for row in fit.rows()]
    sound = {
        "intervals": all(sorted(ends) == list(ends) for ends in intervals),
        "covariance": np.abs(covariance - covariance.T).max() <= 1e-6 * covariance.max()
        and least >= -1e-6 * float(covariance.max()),
        "draws": draws.names[:count] == fit.names
        and len(draws) > 0
        and bool(np.all(draws.rows[:, :count] >= 0.0)),
        "chi2": fit.chi2 >= 0.0 and fit.dof >= 0,
    }
    wrong = [*differ, *(part for part, well in sound.items() if not well)]
    if wrong:
        raise BadInput(f"{wrong[0]}: not what a fit would write")


def _check_numbers(given: Any) -> None:
    """Raise BadInput where a number, however deep, is no finite one of a size that can be."""
    if isinstance(given, Mapping | list):
        for part in given.values() if isinstance(given, Mapping) else given:
            _check_numbers(part)
    elif isinstance(given, int | float):
        check_number("a number of it", given)


def _from_json(given: Mapping[str, Any]) -> FrictionFit:
    """Return the fit that a file holds."""
    _check(given)
    _check_numbers(given)
    names = tuple(name for name in FRICTIONS if name + WHOLE in given["parameters"])
    parts = [given["parameters"][name + WHOLE] for name in names]
    values = number_array("value", [part["value"] for part in parts])
    ends = number_array("interval", [part["interval"] for part in parts])
    covariance = number_array("covariance", given["covariance"]["values"])
    covariance = covariance.reshape((len(names),) * 2)
    return fit_of(
        Robot(**given["robot"]),
        values,
        covariance,
        ends,
        method=str(given["method"]),
        sigma=str(given["sigma"]),
        chi2=float(given["chi2"]),
        dof=int(given["dof"]),
        nuisances=MappingProxyType(
            {
                n: Estimate(float(e["value"]), float(e["sigma"]))
                for n, e in given["nuisances"].items()
            }
        ),
        residuals=tuple(map(float, given["residuals"])),
        influence=tuple(map(_influence, given["influence"])),
        notes=tuple(map(str, given["notes"])),
        alarms=tuple(map(str, given["alarms"])),
        session_name=given["session"]["name"],
        session_sha256=given["session"]["sha256"],
        draws=_draws(given, names, (values, covariance, ends)),
    )


def _draws(
    given: Mapping[str, Any], names: tuple[str, ...], told: tuple[Floats, Floats, Floats]
) -> FitDraws:
    """Return a file's draws; told: values, covariance and intervals.

    Of a file of format 1 without them draws of these.
    """
    if given["format"] > 1:
        draws = given["draws"]
        return FitDraws(tuple(draws["order"]), number_array("draws", draws["values"]))
    return FitDraws(names, normal_draws(*told))


def _influence(given: Mapping[str, Any]) -> Influence:
    leverage, studentised = float(given["leverage"]), float(given["studentised"])
    shift = tuple(map(float, given["shift_in_sigmas"].values()))
    return Influence(
        int(given["reading"]), leverage, studentised, shift, float(given["chi2_without"])
    )
