"""Common servos: what data sheets and identifications say, and how far to believe it.

Data sheets give the stalled torque, the time for 60 degrees, and the dead band. They do not give
the rotor, the gear's friction or the loop. For these there are identified servos: BAM (Rhoban,
github.com/Rhoban/bam, model M1; Duclusaud et al., arXiv:2410.08650) has

    servo      rotor kg m^2   S / w0, N m s/rad   their ratio   friction N m (over S)
    XL-320     1.12e-3        0.0274              41 ms         0.028 (0.13)
    XL-330     1.99e-3        0.0391              51 ms         0.018 (0.03)
    STS3215    2.61e-2        0.559               47 ms         0.052 (0.015)
    MX-64      1.20e-2        0.667               18 ms         0.090 (0.02)

with S / w0 = kt^2 / R, S = kt U / R at U = 7.4, 5, 7.4 and 12 V. So the motor's time constant is
taken as 37 ms and the friction as 0.035 S wherever they have not been measured; the sigmas are the
spread of these four, and somewhat more. The loop's stiffness is S over the error at which the
servo asks for its whole torque: about 0.17 rad, within a factor of 1.6.
"""

from __future__ import annotations

import math
from pathlib import Path

from ..model.drives import Servo, ServoKind
from ..model.errors import BadInput
from .servo_file import load_servo

_MOTOR_S, _FRICTION, _FULL_RAD = 0.037, 0.035, 0.17
_KG_CM = 0.0980665  # N m
_ANALOGUE, _DIGITAL = 50.0, 300.0  # looks a second
_UNMEASURED = {
    "stiffness_nm_rad": 0.5,
    "armature_kg_m2": 0.5,
    "gear_friction_nm": 0.9,
    "gear_damping_nms_rad": 1.0,
    "dead_band_rad": 0.5,
    "supply_sag": 0.7,
}
_SHEET = {"torque_limit_nm": 0.2, "speed_limit_rad_s": 0.12}
_TYPICAL = {"torque_limit_nm": 0.35, "speed_limit_rad_s": 0.2, "dead_band_rad": 0.7}
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
    name: str, kg_cm: float, s_60_deg: float, band_us: float, update_hz: float, source: str = ""
) -> ServoKind:
    """Return a kind by its data sheet: kg cm, seconds for 60 degrees, whole dead band in us.

    Values without a source are typical ones, in more doubt.
    """
    torque, speed = kg_cm * _KG_CM, math.radians(60) / s_60_deg
    line = torque / speed
    band = math.radians(0.09 * band_us / 2)  # 1000 us are 90 degrees
    servo = Servo(
        torque / _FULL_RAD,
        line,
        torque,
        speed,
        band,
        armature_kg_m2=_MOTOR_S * line,
        gear_friction_nm=_FRICTION * torque,
        gear_damping_nms_rad=0.1 * line,
        update_hz=update_hz,
        supply_sag=0.04,
    )
    sheet = _SHEET if source else _TYPICAL
    return ServoKind(name, servo, _UNMEASURED | sheet, (), source or "typical, no source")


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
    )
    return ServoKind(name, servo, _MEASURED, (), f"github.com/Rhoban/bam, M1, at {volt:g} V")


def _hobby() -> ServoKind:
    """Return the servo of which nothing is known but that it is a hobby servo."""
    kind = _of_sheet("hobby", 4.0, 0.15, 6.0, _ANALOGUE, "between all servos of this table")
    sigma = dict(kind.sigma) | {"torque_limit_nm": 0.5, "speed_limit_rad_s": 0.25}
    return ServoKind("hobby", kind.servo, sigma, (_ANALOGUE, _DIGITAL), kind.source)


_KINDS = [
    _hobby(),
    _of_sheet(
        "SG90",
        1.8,
        0.10,
        10,
        _ANALOGUE,
        "data sheet, 4.8 V, as smarthon-docs-zh."
        "readthedocs.io has it; dead band in copies of the sheet on GitHub",
    ),
    _of_sheet(
        "MG90S",
        2.2,
        0.08,
        5,
        _ANALOGUE,
        "data sheet, 6 V: github.com/TrDA-hab/Projects, Servo+ESP8266/MG90S-Datasheet.pdf",
    ),
    _of_sheet(
        "MG996R",
        11.0,
        0.14,
        5,
        _ANALOGUE,
        "data sheet, 6 V: github.com/neko0xff/"
        "note_hardware, motor_mg996r; shops say 9.4 to 15 kg cm",
    ),
    _of_sheet("HS-422", 4.1, 0.16, 8, _ANALOGUE),
    _of_sheet(
        "S3003",
        4.1,
        0.19,
        8,
        _ANALOGUE,
        "data sheet, 6 V: github.com/rngadam/"
        "XinCheJian-GGHC/wiki/Mechanical-design; dead band typical",
    ),
    _of_sheet("DS3218", 19.0, 0.16, 3, _DIGITAL),
    _identified("XL-320", 0.98695, 35.609, 7.4, 1.1190e-3, 0.027515, 0.0033176),
    _identified("XL-330", 0.37005, 3.4983, 5.0, 1.9898e-3, 0.018212, 0.0059020),
    _identified("STS3215", 1.17763, 2.47868, 7.4, 0.0260829, 0.0515205, 0.0598916),
    _identified("MX-64", 1.62247, 3.94943, 12.0, 0.0119512, 0.0903868, 0.0116916),
]
SERVOS = {kind.name: kind for kind in _KINDS}
HOBBY = SERVOS["hobby"]  # what every prediction from a session takes unless told


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
    """
    wanted = str(name).lower().replace("-", "").replace(" ", "")
    for known, kind in SERVOS.items():
        if wanted == known.lower().replace("-", ""):
            return kind
    if Path(name).suffix == ".toml":
        return load_servo(name)
    raise BadInput(
        f"servo is {str(name)!r}; known are {', '.join(SERVOS)}; or give a file, NAME.toml"
    )
