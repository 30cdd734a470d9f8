"""A Scene as a TOML file: Scene's fields under Scene's names, its parts as tables."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import BadInput
from ..base.files import write_named
from ..base.toml_table import Table, located
from ..model.drives import REMOVED, Servo, TorqueTable
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.link_state import LinkState
from ..model.robot import Robot
from .scene import Scene

FORMAT = 2
# Where a file's key is not the field's name: its unit is spelt out.
_KEYS = {"ct": "ct_n_s_m", "cn": "cn_n_s_m", "ft0": "ft0_n", "fn0": "fn0_n", "locked": "locked_rad"}
_MAKERS: dict[str, Callable[..., Any]] = {
    "": Scene,
    "robot": Robot.whole_body,
    "ground": Ground.whole_body,
    "gait": Gait,
    "servo": Servo,
    "start": LinkState,
}
# Settings of older files: what to do about a file in which one is not 0.
_REMOVED = {
    "servo": REMOVED,
    "": {
        "smoothing_m_s": "serpenoid no longer smooths dry friction, which let stuck wheels creep; "
        "remove the line, and wheels stick exactly (method 'nonsmooth')"
    },
}


def load_scene(path: str | Path) -> Scene:
    """Read a scene from a TOML file.

    At the top stand `format = 2` and those numbers, words and lists of a Scene that differ from
    their defaults. The tables [robot], [ground] and [gait] are required. [robot] has links, the
    whole robot's mass_kg, link_length_m, and link_inertia_kg_m2 unless links are uniform rods;
    [ground] has the whole snake's ct_n_s_m, cn_n_s_m, ft0_n and fn0_n. [servo] goes with
    drive = "servo". [torque] goes with drive = "torque" and has torque_nm: constants, or one row
    for each time of t_s. [locked_rad] has the angle of each locked joint by its number. `start` is
    a word, or a table of the six lists of a LinkState. Any angle may be in degrees: alpha_deg
    instead of alpha_rad.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Scene
        The scene, checked.

    Raises
    ------
    BadInput
        If something is missing, unknown, of a wrong type, out of range or of a newer format. The
        message names file, line, value and limits.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> sn.save_scene(sn.Scene(robot, ground, gait, duration_s=0.5), "scene.toml")
    >>> sn.load_scene("scene.toml").duration_s
    0.5
    """
    top = Table.load(Path(path))
    top.check_format(
        FORMAT,
        "whose mass and friction are those of one link; write "
        f"format = {FORMAT}, mass_kg of the whole robot in place of link_mass_kg, and in [ground] "
        "the whole snake's friction: each number times the links",
    )
    return _read_part(top, "")


def save_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene to a TOML file: `load_scene` returns the same numbers.

    Mass and friction, which a file has of the whole robot, may differ in their last digit.

    Parameters
    ----------
    scene
        The scene.
    path
        The file; it is written whole or not at all.

    Raises
    ------
    BadInput
        For a torque that is a Python function.
    SerpenoidError
        If the file cannot be written.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> sn.save_scene(sn.Scene(robot, ground, gait, duration_s=0.5), "scene.toml")
    >>> sn.load_scene("scene.toml").duration_s
    0.5
    """
    import tomli_w

    head = """\
# A scene of serpenoid: SI units and radians (an angle may be typed in degrees, alpha_deg = 70);
# links and joints count from the tail; mass and friction are those of the whole robot.
"""
    write_named(path, head + tomli_w.dumps({"format": FORMAT} | scene_values(scene)))


def scene_values(scene: Scene) -> dict[str, Any]:
    """Return a scene as plain numbers, words, lists and dicts, under a scene file's keys."""
    if callable(scene.torque):
        raise BadInput(
            f"torque is a Python function, {scene.torque!r}, which no file can hold; sample it "
            "into a TorqueTable"
        )
    robot, values = scene.robot, asdict(scene, dict_factory=_plain)
    names = "links", "mass_kg", "link_length_m", "link_inertia_kg_m2"
    values["robot"] = _plain([(name, getattr(robot, name)) for name in names])
    values["ground"] = asdict(scene.ground.scaled(*4 * [robot.links]), dict_factory=_plain)
    if scene.locked:
        values["locked_rad"] = {str(joint): angle for joint, angle in scene.locked.items()}
    return values


def _plain(fields: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return what is there of fields under a file's keys, arrays as lists."""
    values = {
        _KEYS.get(name, name): value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in fields
    }
    return {key: value for key, value in values.items() if value is not None and value != {}}


def _read_part(table: Table, section: str, links: int = 0) -> Any:
    """Make Scene ("") or one of its parts of a table; links: those of the robot, for the ground.

    A BadInput begins with file and line: of the first field that its text names.
    """
    table = table.without_removed(_REMOVED.get(section, {}))
    maker = partial(Ground.whole_body, links) if section == "ground" else _MAKERS[section]
    present = _present(table, maker)
    values: dict[str, Any] = {}
    for name, key in present.items():  # the robot is the first of a scene
        robot = values.get("robot")
        values[name] = _value(table, name, key, robot.links if robot else 0)
    try:
        return maker(**values)
    except BadInput as error:
        words = re.findall(r"\w+", str(error))
        key = next((present[word] for word in words if word in present), "")
        where = table.where(key) if key else table.heading
        raise BadInput(f"{where}: {error}") from error


def _present(table: Table, maker: Callable[..., Any]) -> dict[str, str]:
    """Return each argument that a table has for a maker, with its key there.

    Raises BadInput for keys that are unknown, missing, or there in degrees, too.
    """
    present: dict[str, str] = {}
    missing, optional = [], ["format"] if maker is Scene else []
    for name, parameter in signature(maker).parameters.items():
        key = _KEYS.get(name, name)
        is_angle = key.endswith("_rad") and "_nm" not in key
        keys = [key, key.removesuffix("_rad") + "_deg"] if is_angle else [key]
        optional += keys
        typed = [name for name in keys if name in table.values]
        if len(typed) > 1:
            raise BadInput(f"{table.where(typed[1])}: {key} is there too; keep one of the two")
        if typed:
            present[name] = typed[0]
        elif parameter.default is parameter.empty:
            missing.append(key)
    table.check_keys(*missing, optional=tuple(optional))
    return present


def _value(top: Table, name: str, key: str, links: int) -> Any:
    """Read one field of Scene or of a part; whom it goes to checks it."""
    value, degrees = top.values[key], key.endswith("_deg")
    if name in _MAKERS and (name != "start" or isinstance(value, dict)):
        return _read_part(top.table(key), name, links)
    if name == "torque":
        return _torque(top.table(key))
    if name == "locked":
        table, turned = top.table(key), math.radians if degrees else float
        # Scene refuses what is no number of a joint.
        joints = {text: int(text) for text in table.values if re.fullmatch("[0-9]{1,8}", text)}
        return {joints.get(text, text): turned(table.number(text)) for text in table.values}
    return math.radians(top.number(key)) if degrees else value


def _torque(table: Table) -> Any:
    """Read constant torques, or a table of them by time."""
    table.check_keys("torque_nm", optional=("t_s",))
    if "t_s" not in table.values:
        return table.numbers("torque_nm")
    with located(table.heading):
        return TorqueTable(**table.values)
