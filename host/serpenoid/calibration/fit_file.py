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
from numpy.typing import NDArray

from ..model.checks import check_number, check_whole
from ..model.drives import Servo
from ..model.errors import BadInput
from ..model.files import read_json, write_text
from ..model.robot import Robot
from ..model.vectors import number_array
from .fitting.shared import FRICTIONS
from .fitting.suspects import Influence
from .friction_result import (
    AMPLITUDE,
    NAMES,
    WHOLE,
    Estimate,
    FitDraws,
    FittedServos,
    FrictionFit,
    WholeSnake,
    ground_of,
    normal_draws,
)
from .session import Session

FORMAT = 2  # 1 had draws only where crawls were fitted
NAME = "fit.json"
_DRAWN = 1024  # for a file of format 1


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
    text = json.dumps(_as_json(fit), indent=2, allow_nan=False) + "\n"
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
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise BadInput(
            f"{path}: not a fit of this program: {what}; `serpenoid fit DIR` writes it anew"
        ) from error
    return _with_age(fit, path)


def rests_on(fit: FrictionFit, session: Session) -> bool:
    """Return whether a fit is that of a session as it is now, crawls in it if it took any."""
    now = session.sha256_with_crawls if fit.with_crawls else session.sha256
    return now == fit.session_sha256


def _with_age(fit: FrictionFit, path: Path) -> FrictionFit:
    """Note that the readings beside the file are no longer those it was fitted to."""
    from .session_file import load_session

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


def _check_format(given: Mapping[str, Any]) -> None:
    if check_number("format", given["format"], 1) > FORMAT:
        raise BadInput(
            f"format is {given['format']}; this version reads formats up to {FORMAT}; install a "
            "newer one"
        )


def _check_hash(given: Mapping[str, Any]) -> None:
    """Raise BadInput where the file is not as a fit wrote it."""
    if given.get("sha256") != _hash({k: v for k, v in given.items() if k != "sha256"}):
        raise BadInput(
            "sha256 is not that of its numbers: an older version wrote it, or it was edited"
        )


def _from_json(given: Mapping[str, Any]) -> FrictionFit:
    _check_format(given)
    _check_hash(given)
    names = [name for name in FRICTIONS if name in NAMES or name + WHOLE in given["parameters"]]
    whole = [given["parameters"][name + WHOLE] for name in names]
    values = [check_number(n + WHOLE, p["value"], 0.0) for n, p in zip(names, whole, strict=True)]
    robot = Robot(**given["robot"])
    ends = list(map(_interval, names, whole))
    covariance = _covariance(given["covariance"]["values"], len(names))
    if given["format"] == 1 and not given.get("draws"):
        drawn = normal_draws(np.array(values), covariance, np.array(ends), _DRAWN)
        draws = FitDraws(tuple(names), drawn)
    else:
        draws = _draws(given, names)
    return FrictionFit(
        method=str(given["method"]),
        sigma=str(given["sigma"]),
        parameters=_named(
            Estimate(v, check_number("sigma", p["sigma"], 0.0))
            for v, p in zip(values, whole, strict=True)
        ),
        intervals=_named(ends),
        covariance=covariance,
        robot=robot,
        ground=ground_of(robot.links, values),
        chi2=check_number("chi2", given["chi2"], 0.0),
        dof=check_whole("dof", given["dof"], -1000, 10**9),
        nuisances=MappingProxyType({n: _estimate(n, e) for n, e in given["nuisances"].items()}),
        residuals=tuple(check_number("residual", r) for r in given["residuals"]),
        outliers=tuple(check_whole("outlier", k, 0, 10**9) for k in given["outliers"]),
        influence=tuple(map(_influence, given["influence"])),
        notes=tuple(map(str, given["notes"])),
        alarms=tuple(map(str, given["alarms"])),
        session_name=str(given["session"]["name"]),
        session_sha256=str(given["session"]["sha256"]),
        draws=draws,
        servos=_servos(given.get("servos"), len(draws)),
    )


def _interval(name: str, given: Mapping[str, Any]) -> tuple[float, float]:
    """Return the ends of an interval that holds its value."""
    low, high = (check_number(f"interval of {name}{WHOLE}", x, 0.0) for x in given["interval"])
    if not low <= given["value"] <= high:
        raise BadInput(f"{name}{WHOLE} is {given['value']}, outside its interval {low} to {high}")
    return low, high


def _estimate(name: str, given: Mapping[str, Any]) -> Estimate:
    return Estimate(
        check_number(name, given["value"]), check_number(f"sigma of {name}", given["sigma"], 0.0)
    )


def _covariance(values: Any, size: int) -> NDArray[np.float64]:
    """Return a covariance that is one."""
    covariance = number_array("covariance", values)
    well = covariance.shape == (size, size) and np.isfinite(covariance).all()
    if not well or not (np.linalg.eigvalsh(covariance) > 0.0).all():
        raise BadInput(f"covariance is not a positive definite matrix of {size} by {size} numbers")
    covariance.flags.writeable = False
    return covariance


def _draws(given: Mapping[str, Any], names: list[str]) -> FitDraws:
    """Return a file's draws, the frictions first."""
    values: Any = given["draws"]
    if given["format"] == 1:
        values = {"order": [*names, AMPLITUDE], "values": values}
    order = tuple(map(str, values["order"]))
    rows = number_array("draws", values["values"])
    well = rows.ndim == 2 and rows.shape[1] == len(order) and len(rows) > 0
    if not well or not np.isfinite(rows).all() or order[: len(names)] != tuple(names):
        raise BadInput(f"draws is not rows of {', '.join(names)} and what comes after them")
    if rows[:, : len(names)].min() < 0.0:
        raise BadInput("draws has a friction below 0")
    return FitDraws(order, rows)


def _servos(given: Any, draws: int) -> FittedServos | None:
    """Return the servos that go with the draws."""
    if given is None:
        return None
    drawn = tuple(Servo(**one) for one in given["drawn"])
    last = len(drawn) - 1
    index = tuple(check_whole("index of a servo", k, 0, last) for k in given["index"])
    if len(index) != draws:
        raise BadInput(f"servos has {len(index)} indices for {draws} draws")
    return FittedServos(
        str(given["kind"]), drawn, index, check_whole("best servo", given["best"], 0, last)
    )


def _named(values: Any) -> WholeSnake[Any]:
    return WholeSnake(dict(zip(FRICTIONS, values, strict=False)))


def _influence(given: Mapping[str, Any]) -> Influence:
    shift = given["shift_in_sigmas"]
    return Influence(
        check_whole("reading", given["reading"], 0, 10**9),
        check_number("leverage", given["leverage"]),
        check_number("studentised", given["studentised"]),
        tuple(check_number(n, shift[n]) for n in FRICTIONS if n in NAMES or n in shift),
        check_number("chi2_without", given["chi2_without"]),
    )
