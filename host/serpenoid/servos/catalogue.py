"""Common servos: what data sheets and identifications say, how far to believe it; their files.

Data sheets give the stalled torque and the time for 60 degrees, both of the whole servo at some
voltage. They do not give the rotor, the gear or the loop. For these there are identified servos:
BAM (Rhoban, github.com/Rhoban/bam, model M1; Duclusaud et al., arXiv:2410.08650) has

    servo      rotor kg m^2   S / w0, N m s/rad   ratio   friction N m (q)   damping over S / w0 (g)
    XL-320     1.12e-3        0.0274              41 ms   0.028 (0.13)       0.12
    XL-330     1.99e-3        0.0391              51 ms   0.018 (0.03)       0.15
    STS3215    2.61e-2        0.559               47 ms   0.052 (0.015)      0.11
    MX-64      1.20e-2        0.667               18 ms   0.090 (0.02)       0.018

with S / w0 = kt^2 / R, S = kt U / R at U = 7.4, 5, 7.4 and 12 V. So there is one prior of all that
sheets do not give: the motor's time constant 37 ms, the gear's friction q = 0.05 S and damping
g = 0.07 S / w0. Its sigmas are the spread of these four, and somewhat more: all four lie inside
its 95 %. The loop's stiffness is S over the error at which the servo asks for its whole torque:
about 0.17 rad, within a factor of 1.6. `hobby` is this prior with torque and speed in wide doubt.
A sheet's name is the same prior with two numbers changed: its torque and its speed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ..base.errors import BadInput
from ..base.files import write_named
from ..base.toml_table import Table, located
from ..model.drives import REMOVED, UNCERTAIN, Servo, ServoKind

# Sigma of the logarithms of what nobody has measured. The voltage at the plug is 4.8 to 6 V, all as
# likely.
_UNMEASURED = {
    "stiffness_nm_rad": 0.5,
    "armature_kg_m2": 0.5,
    "gear_friction_nm": 0.9,
    "gear_damping_nms_rad": 1.1,
    "dead_band_rad": 0.5,
    "supply_sag": 0.7,
    "supply_v": math.log(6.0 / 4.8) / math.sqrt(12),
}
_MEASURED = {
    "torque_limit_nm": 0.1,
    "speed_limit_rad_s": 0.1,
    "armature_kg_m2": 0.15,
    "gear_friction_nm": 0.3,
    "gear_damping_nms_rad": 0.5,
    "stiffness_nm_rad": 0.4,
    "dead_band_rad": 0.5,
    "supply_sag": 0.7,
}


def _of_sheet(
    name: str,
    kg_cm: float,
    s_60_deg: float,
    supply_v: float = 6.0,
    source: str = "typical, no source; all but torque and speed as hobby",
    *,
    torque_sigma: float = 0.35,
    speed_sigma: float = 0.2,
    friction: float = 0.05,
    damping: float = 0.07,
) -> ServoKind:
    """Return the prior with a sheet's torque, kg cm, and seconds for 60 degrees at a voltage.

    friction, damping: the gear's, over the motor's torque and over its torque by speed.
    """
    # One kg cm is 0.0980665 N m.
    torque = kg_cm * 0.0980665 / (1 - friction)
    speed = math.radians(60) / s_60_deg * (1 + damping) / (1 - friction)
    line = torque / speed
    servo = Servo(
        torque / 0.17,
        line,
        torque,
        speed,
        math.radians(0.27),  # 6 us in all, of which sheets say 3 to 10; 1000 us are 90 degrees
        armature_kg_m2=0.037 * line,
        gear_friction_nm=friction * torque,
        gear_damping_nms_rad=damping * line,
        update_hz=50.0,
        supply_sag=0.04,
        supply_v=supply_v,
    )
    doubt = _UNMEASURED | {"torque_limit_nm": torque_sigma, "speed_limit_rad_s": speed_sigma}
    # Analogue servos look 50 times a second, digital ones 300 times.
    return ServoKind(name, servo.at_volts(math.sqrt(4.8 * 6.0)), doubt, (50.0, 300.0), source)


def _identified(
    name: str, kt: float, ohm: float, volt: float, rotor: float, dry: float, viscous: float
) -> ServoKind:
    """Return a kind that BAM has identified (M1), with its loop's default gain."""
    torque, speed = kt * volt / ohm, volt / kt
    servo = Servo(
        torque / 0.2,
        torque / speed,
        torque,
        speed,
        0.003,
        armature_kg_m2=rotor,
        gear_friction_nm=dry,
        gear_damping_nms_rad=viscous,
        update_hz=1000.0,
        supply_sag=0.04,
        supply_v=volt,
    )
    return ServoKind(name, servo, _MEASURED, (), f"github.com/Rhoban/bam, M1, at {volt:g} V")


def _measured_sheet(name: str, kg_cm: float, s_60_deg: float, volt: float, page: str) -> ServoKind:
    """Return the prior with the numbers of a data sheet that is on a page."""
    source = f"data sheet, {volt:g} V: {page}; all but torque and speed as hobby"
    return _of_sheet(name, kg_cm, s_60_deg, volt, source, torque_sigma=0.2, speed_sigma=0.12)


# What every prediction from a session takes unless told.
HOBBY = _of_sheet(
    "hobby",
    4.0,
    0.15,
    source="between all servos of this table",
    torque_sigma=0.5,
    speed_sigma=0.25,
)
SERVOS = {
    kind.name: kind
    for kind in (
        HOBBY,
        _measured_sheet("SG90", 1.8, 0.10, 4.8, "smarthon-docs-zh.readthedocs.io"),
        _measured_sheet(
            "MG90S",
            2.2,
            0.08,
            6.0,
            "github.com/TrDA-hab/Projects, Servo+ESP8266/MG90S-Datasheet.pdf",
        ),
        _measured_sheet(
            "MG996R",
            11.0,
            0.14,
            6.0,
            "github.com/neko0xff/note_hardware, motor_mg996r; shops say 9.4 to 15 kg cm",
        ),
        _of_sheet("HS-422", 4.1, 0.16),
        _measured_sheet(
            "S3003",
            4.1,
            0.19,
            6.0,
            "github.com/rngadam/XinCheJian-GGHC/wiki/Mechanical-design",
        ),
        _of_sheet("DS3218", 19.0, 0.16),
        _identified("XL-320", 0.98695, 35.609, 7.4, 1.1190e-3, 0.027515, 0.0033176),
        _identified("XL-330", 0.37005, 3.4983, 5.0, 1.9898e-3, 0.018212, 0.0059020),
        _identified("STS3215", 1.17763, 2.47868, 7.4, 0.0260829, 0.0515205, 0.0598916),
        _identified("MX-64", 1.62247, 3.94943, 12.0, 0.0119512, 0.0903868, 0.0116916),
    )
}


def servo(name: str | Path = "hobby") -> ServoKind:
    """Return a kind of servo by its name in SERVOS, or from a TOML file.

    Parameters
    ----------
    name
        A name, or a file's path. "hobby" is any hobby servo: typical values with a wide sigma.

    Returns
    -------
    ServoKind
        The typical servo and the doubt about it.

    Raises
    ------
    BadInput
        For a name that is neither known nor a file.

    Examples
    --------
    >>> sn.servo("MG996R").name
    'MG996R'
    """
    plain = {re.sub("[- ]", "", title).lower(): kind for title, kind in SERVOS.items()}
    if kind := plain.get(re.sub("[- ]", "", str(name)).lower()):
        return kind
    if Path(name).suffix == ".toml":
        return load_servo(name)
    raise BadInput(
        f"servo is {str(name)!r}; known are {', '.join(SERVOS)}; or give a file, NAME.toml"
    )


FORMAT = 1


def load_servo(path: str | Path) -> ServoKind:
    """Read a kind of servo from a TOML file.

    The file has `format = 1` and may have `name`, `source` and a `remark` that warns of it. [servo]
    has Servo's fields; those that are missing have its defaults. [sigma] has standard deviations of
    the logarithm of some of them; the others are exact. [drawn] holds servos that a measurement
    leaves possible: a list for each field that differs.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    ServoKind
        The kind of servo.

    Raises
    ------
    BadInput
        The message names the file and what is wrong with it.

    Examples
    --------
    >>> sn.save_servo(sn.servo("MG996R"), "servo.toml")
    >>> sn.load_servo("servo.toml").name
    'MG996R'
    """
    top = Table.load(Path(path))
    top.check_format(FORMAT)
    readers: dict[str, Callable[[str], Any]] = {
        "name": top.string,
        "source": top.string,
        "remark": top.string,
        "updates_hz": lambda key: top.numbers(key, 0.0, 1e4),
        "sigma": lambda key: _numbers(top.table(key), tuple(UNCERTAIN), 0.0, 3.0),
        "drawn": lambda key: _drawn(top.table(key).without_removed(REMOVED), servo),
    }
    top.check_keys("format", "servo", optional=tuple(readers))
    table = top.table("servo").without_removed(REMOVED)
    with located(table.heading):
        servo = Servo(**_numbers(table, Servo.__match_args__))
    values: dict[str, Any] = {"name": Path(path).stem, "source": str(path)}
    values |= {key: read(key) for key, read in readers.items() if key in top.values}
    return ServoKind(servo=servo, **values)


def _numbers(table: Table, names: tuple[str, ...], *limits: float) -> dict[str, float]:
    """Return the numbers of a table that has some of these names."""
    table.check_keys(optional=names)
    return {name: table.number(name, *limits) for name in table.values}


def _drawn(table: Table, typical: Servo) -> tuple[Servo, ...]:
    """Return the servos of [drawn]: lists of equal length, by field."""
    table.check_keys(optional=Servo.__match_args__)
    columns = {name: table.numbers(name) for name in table.values}
    counts = {len(values) for values in columns.values()}
    if len(counts) != 1:
        raise BadInput(f"{table.heading}: lists of {sorted(counts)} numbers; all must be as long")
    with located(table.heading):
        rows = zip(*columns.values(), strict=True)
        return tuple(replace(typical, **dict(zip(columns, row, strict=True))) for row in rows)


def save_servo(kind: ServoKind, path: str | Path) -> None:
    """Write a kind of servo to a TOML file, which load_servo reads.

    Parameters
    ----------
    kind
        The kind of servo.
    path
        The file.

    Raises
    ------
    SerpenoidError
        If the file cannot be written.

    Examples
    --------
    >>> sn.save_servo(sn.servo("MG996R"), "servo.toml")
    >>> sn.load_servo("servo.toml").name
    'MG996R'
    """
    import tomli_w

    values: dict[str, Any] = {"format": FORMAT}
    values |= {key: getattr(kind, key) for key in ("name", "source", "remark", "updates_hz")}
    values |= {"servo": asdict(kind.servo), "sigma": dict(kind.sigma)}
    if kind.drawn:
        values["drawn"] = {
            name: [float(f"{getattr(servo, name):.6g}") for servo in kind.drawn]
            for name in Servo.__match_args__
        }
    write_named(path, tomli_w.dumps({key: value for key, value in values.items() if value}))
