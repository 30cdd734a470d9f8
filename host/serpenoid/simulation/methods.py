"""Every method: what it runs, and which one suits a scene; read from the core's registry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from .. import _core

if TYPE_CHECKING:
    from ..model.drives import Servo


@dataclass(frozen=True, slots=True)
class MethodKind:
    """Say which scenes a method runs; a row of host/core/scene/method_table.hpp.

    order: of convergence at recorded times, for smooth motion. adaptive: formulations in which it
    takes steps of its own to scene.tolerance; in the others steps of dt_s. records: what it can
    record besides the motion. plain: whether all joints must follow the gait, on the level. faults:
    whether it runs with limp or locked joints.
    """

    order: int
    formulations: tuple[str, ...]
    adaptive: tuple[str, ...]
    drives: tuple[str, ...]
    laws: tuple[str, ...]
    records: tuple[str, ...]
    plain: bool
    faults: bool


_WORDS = ("formulations", "adaptive", "drives", "laws", "records")


def _kind(row: dict[str, Any]) -> MethodKind:
    words: dict[str, Any] = {name: tuple(row[name].split()) for name in _WORDS}
    return MethodKind(**{**row, **words})


METHODS = {row.pop("name"): _kind(row) for row in _core.method_table()}

_FIRST_ADVISED = ("dop853", "rk4", "radau")  # behind the one that suits a scene
_ANY_WAY = "formulation 'explicit' without smoothing_m_s, and leave the method to the scene"


class Asked(Protocol):
    """Say what a scene asks of a method; Scene has all of it."""

    @property
    def formulation(self) -> str:
        """Return one of FORMULATIONS."""
        ...

    @property
    def drive(self) -> str:
        """Return one of DRIVES."""
        ...

    @property
    def law(self) -> str:
        """Return one of LAWS."""
        ...

    @property
    def servo(self) -> Servo | None:
        """Return what moves the joints when the drive is "servo"."""
        ...

    @property
    def limp(self) -> tuple[int, ...]:
        """Return the joints without torque."""
        ...

    @property
    def locked(self) -> Mapping[int, float]:
        """Return the joints that stay, and where."""
        ...

    @property
    def incline_rad(self) -> float:
        """Return the slope of the ground."""
        ...

    @property
    def record(self) -> tuple[str, ...]:
        """Return which of RECORDS to keep."""
        ...


GONE = ("euler", "semi_implicit_euler")  # of order 1


class OwnChoice(str):
    """Hold a method's name that a scene chose by itself: changed, the scene chooses anew."""

    __slots__ = ()


def objection(
    name: str, scene: Asked, formulation: str | None = None, record: tuple[str, ...] | None = None
) -> str | None:
    """Return why a method does not run a scene, or None if it does; what is given replaces."""
    kind = METHODS[name]
    formulation = formulation or scene.formulation
    for what, value, runs in (
        ("formulation", formulation, kind.formulations),
        ("drive", scene.drive, kind.drives),
        ("law", scene.law, kind.laws),
    ):
        if value not in runs:
            return f"does not run with {what} {value!r}"
    if (why := _servo_objection(name, formulation, scene.servo)) is not None:
        return why
    if (scene.limp or scene.locked) and (kind.plain or not kind.faults):
        return "does not run with limp or locked joints"
    if scene.incline_rad > 0 and kind.plain:
        return "does not run with an incline"
    asked = scene.record if record is None else record
    lacks = [one for one in asked if one not in kind.records]
    return f"cannot record {lacks[0]!r}" if lacks else None


_HAVE_PLAY = (("explicit", "nonsmooth"), ("explicit", "dop853"))


def _servo_objection(name: str, formulation: str, servo: Servo | None) -> str | None:
    if servo is None:
        return None
    if servo.backlash_rad > 0 and (formulation, name) not in _HAVE_PLAY:
        return f"with formulation {formulation!r} does not run gears with play, whose teeth hit"
    if name == "radau" and not servo.simple:
        return "does not run with rotors, gear friction, a loop that holds or a supply that sags"
    if name == "dop853" and servo.gear_friction_nm > 0:
        return "does not run with gear friction"
    return None


def default_method(scene: Asked) -> str:
    """Return the method for a scene that names none: exact sticking on dry ground, else rk4."""
    servo = scene.servo
    gears = servo is not None and (servo.gear_friction_nm > 0 or servo.backlash_rad > 0)
    dry = (scene.law == "dry" or gears) and objection("nonsmooth", scene) is None
    return "nonsmooth" if dry else "rk4"


def ways_out(name: str, scene: Asked) -> str:
    """Return what to take where a method does not run a scene: each has been found to run."""
    methods = dict.fromkeys((default_method(scene), *_FIRST_ADVISED))
    runs = [repr(m) for m in methods if objection(m, scene) is None][:2]
    ways = [f"method {' or '.join(runs)}"] if runs else []
    ways += [
        f"formulation {one!r}"
        for one in ("explicit", "implicit")
        if objection(name, scene, formulation=one) is None
    ]
    ways += [
        f"record without {one!r}"
        for one in scene.record
        if objection(name, scene, record=tuple(r for r in scene.record if r != one)) is None
    ]
    return ", or ".join(ways) or _ANY_WAY
