"""A friction fit on disk: fit.json beside its session, written whole or not at all."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ..model.checks import check_number
from ..model.errors import BadInput
from ..model.robot import Robot
from .fitting.influence import BOTH_WAYS, Influence
from .friction_result import NAMES, WHOLE, Estimate, FrictionFit, WholeSnake, ground_of

FORMAT = 1
NAME = "fit.json"


def save_fit(fit: FrictionFit, path: str | Path) -> Path:
    """Write a fit to a file, or as fit.json into a session's folder; return the file.

    The file holds the fit, the hash of the readings it rests on and this program's version. It is
    there whole, or the one before it stays. The same readings give the same file. Raises OSError.
    """
    path = Path(path)
    path = path / NAME if path.is_dir() else path
    text = json.dumps(_as_json(fit), indent=2, allow_nan=False) + "\n"
    half_done = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with half_done.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        half_done.replace(path)
    finally:
        half_done.unlink(missing_ok=True)
    return path


def load_fit(path: str | Path) -> FrictionFit:
    """Read a fit from a file, or from fit.json in a session's folder.

    If the session's readings have changed since, its notes say so. Raises BadInput, naming the file
    and what is wrong with it.
    """
    path = Path(path)
    path = path / NAME if path.is_dir() else path
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BadInput(f"{path}: no such file; `serpenoid fit DIR` writes one") from None
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path}: not JSON: {error}; `serpenoid fit DIR` writes it anew") from error
    try:
        fit = _from_json(given)
    except (KeyError, TypeError, ValueError, AttributeError, BadInput) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise BadInput(
            f"{path}: not a fit of this program: {what}; `serpenoid fit DIR` writes it anew"
        ) from error
    return _with_age(fit, path)


def _with_age(fit: FrictionFit, path: Path) -> FrictionFit:
    """Note that the readings beside the file are no longer those it was fitted to."""
    from .session_file import load_session

    folder = path.parent
    if not (folder / "session.toml").exists():
        return fit
    try:
        now = load_session(folder).sha256
    except BadInput as error:
        now = f"unreadable: {error}"
    if now == fit.session_sha256:
        return fit
    note = f"{path} is older than the readings beside it: run `serpenoid fit {folder}` again."
    return replace(fit, notes=(*fit.notes, note))


def _as_json(fit: FrictionFit) -> dict[str, Any]:
    from importlib.metadata import version

    return {"format": FORMAT, "serpenoid_version": version("serpenoid")} | fit.to_dict()


def _check_format(given: Mapping[str, Any]) -> None:
    if check_number("format", given["format"], 1) > FORMAT:
        raise BadInput(
            f"format is {given['format']}; this version reads formats up to {FORMAT}; install a "
            "newer one"
        )


def _from_json(given: Mapping[str, Any]) -> FrictionFit:
    _check_format(given)
    names = [name for name in BOTH_WAYS if name in NAMES or name + WHOLE in given["parameters"]]
    whole = [given["parameters"][name + WHOLE] for name in names]
    values = [check_number(n + WHOLE, p["value"], 0.0) for n, p in zip(names, whole, strict=True)]
    size = len(names)
    covariance = np.array(given["covariance"]["values"], dtype=float)
    if covariance.shape != (size, size) or not (np.linalg.eigvalsh(covariance) > 0.0).all():
        raise BadInput(f"covariance is not a positive definite matrix of {size} by {size} numbers")
    covariance.flags.writeable = False
    robot = Robot(**given["robot"])
    nuisances = {name: Estimate(**e) for name, e in given["nuisances"].items()}
    return FrictionFit(
        method=given["method"],
        sigma=given["sigma"],
        parameters=_named(
            Estimate(v, float(p["sigma"])) for v, p in zip(values, whole, strict=True)
        ),
        intervals=_named(tuple(map(float, p["interval"])) for p in whole),
        covariance=covariance,
        robot=robot,
        ground=ground_of(robot.links, values),
        chi2=float(given["chi2"]),
        dof=int(given["dof"]),
        nuisances=MappingProxyType(nuisances),
        residuals=tuple(map(float, given["residuals"])),
        outliers=tuple(map(int, given["outliers"])),
        influence=tuple(map(_influence, given["influence"])),
        notes=tuple(map(str, given["notes"])),
        session_name=str(given["session"]["name"]),
        session_sha256=str(given["session"]["sha256"]),
    )


def _named(values: Any) -> WholeSnake[Any]:
    return WholeSnake(dict(zip(BOTH_WAYS, values, strict=False)))


def _influence(given: Mapping[str, Any]) -> Influence:
    shift = given["shift_in_sigmas"]
    return Influence(
        int(given["reading"]), float(given["leverage"]), float(given["studentised"]),
        tuple(float(shift[name]) for name in BOTH_WAYS if name in NAMES or name in shift),
        float(given["chi2_without"]),
    )  # fmt: skip
