"""A Scene as a TOML file: Scene's fields under Scene's names, its parts as tables."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
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
_HEAD = """\
# A scene of serpenoid: SI units and radians (an angle may be typed in degrees, alpha_deg = 70);
# links and joints count from the tail; mass and friction are those of the whole robot.
"""


@dataclass(frozen=True)
class _WholeRobot:
    """The table [robot]: arguments of Robot.whole_body."""

    links: int
    mass_kg: float
    link_length_m: float
    link_inertia_kg_m2: float | None = None


_PARTS = {"robot": _WholeRobot, "ground": Ground, "gait": Gait, "servo": Servo}
# Where a file's key is not the field's name: its unit is spelt out.
_KEYS = {"ct": "ct_n_s_m", "cn": "cn_n_s_m", "ft0": "ft0_n", "fn0": "fn0_n", "locked": "locked_rad"}
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

    write_named(path, _HEAD + tomli_w.dumps({"format": FORMAT} | scene_values(scene)))


def scene_values(scene: Scene) -> dict[str, Any]:
    """Return a scene as plain numbers, words, lists and dicts, under a scene file's keys."""
    if callable(scene.torque):
        raise BadInput(
            f"torque is a Python function, {scene.torque!r}, which no file can hold; sample it "
            "into a TorqueTable"
        )
    fields = {f.name: getattr(scene, f.name) for f in dataclasses.fields(scene)}
    robot = scene.robot
    body = robot.links, robot.mass_kg, robot.link_length_m, robot.link_inertia_kg_m2
    fields["robot"] = _WholeRobot(*body)
    fields["ground"] = scene.ground.scaled(*4 * [robot.links])
    plain = {_KEYS.get(name, name): _plain(value) for name, value in fields.items()}
    return {key: value for key, value in plain.items() if value is not None and value != {}}


def _plain(value: Any) -> Any:
    """Return a field's value in the types that TOML and JSON share."""
    if dataclasses.is_dataclass(value):
        names = [f.name for f in dataclasses.fields(value)]
        return {_KEYS.get(name, name): _plain(getattr(value, name)) for name in names}
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    return [_plain(cell) for cell in value] if isinstance(value, (list, tuple)) else value


def _present(table: Table, section: str) -> dict[str, str]:
    """Return each field that a table has, with its key there; section: "" above all tables.

    Raises BadInput for keys that are unknown, missing, or there in degrees, too.
    """
    present: dict[str, str] = {}
    missing, optional = [], [] if section else ["format"]
    for field in dataclasses.fields(_PARTS.get(section, Scene)):
        key = _KEYS.get(field.name, field.name)
        is_angle = key.endswith("_rad") and "_nm" not in key
        keys = [key, key.removesuffix("_rad") + "_deg"] if is_angle else [key]
        optional += keys
        typed = [name for name in keys if name in table.values]
        if len(typed) > 1:
            raise BadInput(f"{table.where(typed[1])}: {key} is there too; keep one of the two")
        if typed:
            present[field.name] = typed[0]
        elif (field.default, field.default_factory) == (dataclasses.MISSING,) * 2:
            missing.append(key)
    table.only(*missing, optional=tuple(optional))
    return present


def _read_part(table: Table, section: str, links: int = 0) -> Any:
    """Make Scene or one of its parts of a table, located at the key that an error names."""
    table = table.without_removed(_REMOVED.get(section, {}))
    present = _present(table, section)
    values: dict[str, Any] = {}
    for name, key in present.items():  # the robot is the first of a scene
        robot = values.get("robot")
        values[name] = _value(table, name, key, robot.links if robot else 0)
    makers = {
        "": Scene,
        "robot": Robot.whole_body,
        "ground": partial(Ground.whole_body, links),
        "gait": Gait,
        "servo": Servo,
    }
    try:
        return makers[section](**values)
    except BadInput as error:
        words = re.findall(r"\w+", str(error))
        key = next((present[word] for word in words if word in present), "")
        where = table.where(key) if key else table.heading
        raise BadInput(f"{where}: {error}") from error


def _value(top: Table, name: str, key: str, links: int) -> Any:
    """Read one field of Scene or of a part; whom it goes to checks it."""
    value, degrees = top.values[key], key.endswith("_deg")
    if name in _PARTS:
        return _read_part(top.table(key), name, links)
    if name == "torque":
        return _torque(top.table(key))
    if name == "start" and isinstance(value, dict):
        return _start(top.table(key))
    if name == "locked":
        table = top.table(key)
        return {_joint(text): _angle(table, text, degrees) for text in table.values}
    return _angle(top, key, True) if degrees else value


def _angle(table: Table, key: str, degrees: bool) -> float:
    return math.radians(table.number(key)) if degrees else table.number(key)


def _joint(text: str) -> Any:
    """Return the number of a joint; Scene refuses any other text."""
    return int(text) if re.fullmatch("[0-9]{1,8}", text) else text


def _torque(table: Table) -> Any:
    """Read constant torques, or a table of them by time."""
    table.only("torque_nm", optional=("t_s",))
    if "t_s" not in table.values:
        return table.numbers("torque_nm")
    with located(table.heading):
        return TorqueTable(np.array(table.numbers("t_s")), table.values["torque_nm"])


def _start(table: Table) -> LinkState:
    names = LinkState.__slots__
    table.only(*names)
    with located(table.heading):
        return LinkState(*(np.array(table.numbers(name)) for name in names))
