"""The settings of a session, a row each: session.toml is read, written and amended by these."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from ..model.checks import check_choice, check_whole
from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.robot import check_links
from ..model.toml_table import Table, located
from .kinds.instruments import MAX_SPEED_M_S
from .kinds.station import BENDS, MAX_INCLINE_DEG, MAX_LAMBDA_DEG
from .session import MAX_GRAVITY_M_S2, PLACES, PROVENANCE, Setup

DEG = math.radians(1.0)


@dataclass(frozen=True)
class Form:
    """How a setting is read from its table by its key, and how its value is written."""

    read: Callable[[Table, str], Any]
    write: Callable[[Any], str]


@dataclass(frozen=True)
class Setting:
    """One entry of session.toml.

    key: its name there, with its unit. path: the attribute of Setup that holds it, in SI. note:
    what stands behind it in a new file. needed: in files of both formats. fixed: it stays as it was
    set up, whatever is amended.
    """

    key: str
    path: str
    form: Form
    note: str = ""
    needed: bool = False
    fixed: bool = False

    def line(self, setup: Setup) -> str:
        """Return its line of session.toml; none where the set-up has no value."""
        value = attrgetter(self.path)(setup)
        return "" if value is None else f"{self.key} = {self.form.write(value)}{self.note}\n"


def quoted(text: str) -> str:
    """Return text as a TOML string."""
    return json.dumps("".join(c for c in text if c != "\x7f"), ensure_ascii=False)


def _number_text(value: float, digits: int = 10) -> str:
    text = f"{value:.{digits}g}"
    return text if any(c in text for c in ".en") else f"{text}.0"


def _degrees_text(value_rad: float) -> str:
    return _number_text(math.degrees(value_rad), 8)


def _number(*limits: float, unit: float = 1.0, open_low: bool = False) -> Form:
    """Return the form of a number between limits; unit: what one is in SI."""
    return Form(
        lambda table, key: unit * table.number(key, *limits, open_low=open_low),
        _degrees_text if unit == DEG else lambda value: _number_text(value / unit),
    )


def _checked(check: Callable[[str, Any], Any], write: Callable[[Any], str] = str) -> Form:
    """Return the form of a value that a function checks by its name."""

    def read(table: Table, key: str) -> Any:
        with located(table.where(key)):
            return check(key, table.values[key])

    return Form(read, write)


def _choice(choices: tuple[str, ...]) -> Form:
    return _checked(lambda key, value: check_choice(key, value, choices), quoted)


def _check_flag(key: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise BadInput(f"{key} is {value!r}; it must be true or false")
    return value


def _gaits(table: Table, key: str) -> tuple[Gait, ...]:
    given, where = table.values[key], table.where(key)
    if not isinstance(given, list) or not all(isinstance(g, dict) for g in given):
        raise BadInput(f"{where}: {key} must be a list of {{alpha_deg, beta_deg, frequency_hz}}")
    gaits = []
    for values in given:
        entry = Table(values, table.path, table.text, table.start)
        entry.only("alpha_deg", "beta_deg", optional=("omega_rad_s", "frequency_hz"))
        alpha, beta = (entry.number(f"{n}_deg", -360.0, 360.0) for n in ("alpha", "beta"))
        with located(where):
            gaits.append(Gait(math.radians(alpha), math.radians(beta), _rate(entry)))
    return tuple(gaits)


def _rate(gait: Table) -> float:
    """Return a planned gait's rate, rad/s, which may be given in Hz."""
    given = [name for name in ("omega_rad_s", "frequency_hz") if name in gait.values]
    if len(given) != 1:
        said = " and ".join(given) or "neither"
        raise BadInput(f"a gait wants one of omega_rad_s and frequency_hz; {said} is given")
    rate = gait.number(given[0], 0.0, open_low=True)
    return rate if given[0] == "omega_rad_s" else 2 * math.pi * rate


def _gaits_text(gaits: tuple[Gait, ...]) -> str:
    lines = [
        f"\n  {{ alpha_deg = {_degrees_text(g.alpha_rad)}, "
        f"beta_deg = {_degrees_text(g.beta_rad)}, "
        f"omega_rad_s = {_number_text(g.omega_rad_s)} }},"
        for g in gaits
    ]
    return f"[{''.join(lines)}{chr(10) * bool(gaits)}]"


_WORDS = Form(Table.string, quoted)
_FLAG = _checked(_check_flag, lambda value: str(value).lower())
_ABOVE_0, _FROM_0 = _number(0.0, open_low=True), _number(0.0)
_PERCENT = _number(0.0, unit=0.01)
_INCLINE = _number(0.0, MAX_INCLINE_DEG, unit=DEG, open_low=True)
_SPEED = _number(0.0, MAX_SPEED_M_S, open_low=True)
_BENDS = Form(
    lambda table, key: tuple(map(math.radians, table.numbers(key, 0.0, MAX_LAMBDA_DEG))),
    lambda bends_rad: str([float(_degrees_text(bend)) for bend in bends_rad]),
)
GRAVITY = Setting(
    "gravity_m_s2",
    "procedure.gravity_m_s2",
    _number(0.0, MAX_GRAVITY_M_S2, open_low=True),
    needed=True,
    fixed=True,
)
SETTINGS: dict[str, tuple[Setting, ...]] = {
    "provenance": (
        Setting(
            "kind",
            "kind",
            _choice(PROVENANCE),
            "          # measured, or simulated",
            needed=True,
            fixed=True,
        ),
        Setting("source", "source", _WORDS, needed=True, fixed=True),
        Setting("note", "note", _WORDS, needed=True, fixed=True),
    ),
    "robot": (
        Setting(
            "links",
            "robot.links",
            _checked(lambda key, value: check_links(value)),
            needed=True,
            fixed=True,
        ),
        Setting(
            "link_mass_kg",
            "robot.link_mass_kg",
            _ABOVE_0,
            "       # the whole robot's mass, cables and all, over the links",
            needed=True,
            fixed=True,
        ),
        Setting(
            "link_length_m",
            "robot.link_length_m",
            _ABOVE_0,
            "      # joint to joint",
            needed=True,
        ),
        Setting(
            "weighed",
            "weighed",
            _FLAG,
            "          # false: the mass is an assumption, asked for when readings are taken",
            fixed=True,
        ),
        Setting("wheels_kg", "floor.wheels_kg", _FROM_0, "          # all wheels together"),
        Setting(
            "supply_v",
            "supply_v",
            _number(1.0, 60.0),
            "              # at the servos' plug, as they move",
        ),
        Setting(
            "frame_ms",
            "frame_s",
            _number(1.0, 100.0, unit=1e-3),
            "              # of the board",
        ),
        Setting(
            "tag_mm",
            "tag_side_m",
            _number(3.0, 1000.0, unit=1e-3),
            "    # of its printed tags",
        ),
    ),
    "laboratory": (
        Setting(
            "surface",
            "surface",
            _WORDS,
            "    # what the wheels roll on; friction holds for it alone",
            needed=True,
        ),
        Setting("place", "place", _WORDS, needed=True),
        Setting("people", "people", _WORDS, needed=True),
        GRAVITY,
    ),
    "instruments": (
        Setting("incline_sigma_deg", "uncertainty.incline_sigma_rad", _INCLINE, needed=True),
        Setting(
            "incline_zero_sigma_deg",
            "uncertainty.incline_zero_sigma_rad",
            _number(0.0, MAX_INCLINE_DEG, unit=DEG),
            "    # where it is not measured by reversal",
            needed=True,
        ),
        Setting("belt_speed_sigma_m_s", "uncertainty.belt_speed_sigma_m_s", _SPEED, needed=True),
        Setting(
            "lambda_sigma_deg",
            "uncertainty.lambda_sigma_rad",
            _number(0.0, MAX_LAMBDA_DEG, unit=DEG),
            "          # of one bend, protractor and joints",
            needed=True,
        ),
        Setting(
            "belt_scale_sigma_percent",
            "uncertainty.belt_scale_sigma",
            _PERCENT,
            "  # of the speed that the treadmill shows",
        ),
        Setting(
            "mass_sigma_percent",
            "uncertainty.mass_sigma",
            _PERCENT,
            "        # of the robot's mass",
        ),
        Setting(
            "joint_sigma_deg",
            "uncertainty.joint_sigma_rad",
            _number(0.0, unit=DEG),
            "           # of each joint about straight, once aligned",
        ),
        Setting(
            "incline_step_percent",
            "treadmill.incline_step_rad",
            replace(_PERCENT, read=lambda table, key: table.number(key, 0.0) / 100),
            "      # what the treadmill can be set to",
        ),
        Setting("belt_speed_step_m_s", "treadmill.belt_step_m_s", _FROM_0),
        Setting("belt_speed_least_m_s", "treadmill.belt_least_m_s", _FROM_0),
        Setting(
            "distance_sigma_m",
            "stopwatch.distance_sigma_m",
            _FROM_0,
            "        # of a gait run: tape and marks; stopwatch",
        ),
        Setting("time_sigma_s", "stopwatch.time_sigma_s", _FROM_0),
        Setting(
            "film_scale_sigma_percent",
            "floor.film_scale_sigma",
            _PERCENT,
            "  # of lengths in a film of pushes",
        ),
        Setting(
            "push_time_sigma_s",
            "floor.push_time_sigma_s",
            _FROM_0,
            "         # of a push or a slide timed by hand",
        ),
        Setting(
            "floor_slope_sigma_deg",
            "floor.slope_sigma_rad",
            _number(0.0, unit=DEG),
            "     # of the floor, before both ways tell it",
        ),
    ),
    "plan": (
        Setting(
            "on",
            "procedure.on",
            _choice(PLACES),
            "              # treadmill; or floor: pushes instead of stations",
        ),
        Setting("push_lambda_deg", "procedure.push_lambda_rad", _BENDS),
        Setting(
            "pushes",
            "procedure.pushes",
            _checked(lambda key, value: check_whole(key, value, 0, 100)),
            "                  # in each of these bends, half of them either way",
        ),
        Setting(
            "lambda_deg",
            "procedure.lambda_rad",
            _BENDS,
            "    # 7.5 as in 2005; 15 and 30 tell cn three to ten times better",
            needed=True,
        ),
        Setting("incline_start_deg", "procedure.incline_start_rad", _INCLINE, needed=True),
        Setting("incline_step_deg", "procedure.incline_step_rad", _INCLINE, needed=True),
        Setting("belt_speed_max_m_s", "procedure.belt_speed_max_m_s", _SPEED, needed=True),
        Setting(
            "bend",
            "procedure.bend",
            _choice(BENDS),
            "             # balanced; or zigzag, for a robot that is guided on the belt",
        ),
        Setting(
            "ratchet",
            "procedure.ratchet",
            _FLAG,
            "             # true: straight stations also facing up, where wheels roll back",
        ),
        Setting(
            "gait_runs",
            "procedure.gait_runs",
            Form(Table.whole, str),
            "              # of each gait, on level ground of the same surface",
        ),
        Setting("gaits", "procedure.gaits", Form(_gaits, _gaits_text)),
    ),
}


def applied(
    setup: Setup,
    table: Table,
    settings: Iterable[Setting],
    more: Mapping[str, Any] | None = None,
) -> Setup:
    """Return a set-up with what a table has of some settings, and with more, by paths.

    Raises BadInput.
    """
    values = {s.path: s.form.read(table, s.key) for s in settings if s.key in table.values}
    with located(table.heading):
        return changed(setup, values | dict(more or {}))


def changed(setup: Setup, values: Mapping[str, Any]) -> Setup:
    """Return a set-up with some values changed, given by their paths; raises BadInput."""
    parts: dict[str, dict[str, Any]] = {"": {}}
    for path, value in values.items():
        part, _, name = path.rpartition(".")
        parts.setdefault(part, {})[name] = value
    direct = parts.pop("")
    if "robot" in parts:  # its inertia follows from mass and length
        parts["robot"]["link_inertia_kg_m2"] = None
    nested = {part: replace(getattr(setup, part), **new) for part, new in parts.items()}
    return replace(setup, **direct, **nested)


def amended(setup: Setup, text: str, folder: Path) -> Setup:
    """Return a set-up with an amendment's line of TOML applied; raises BadInput.

    [instruments] and [plan] hold from here on. [robot] and [laboratory] correct what was mistyped
    or left open, for all of the session.
    """
    path = folder / "events.csv"
    try:
        change = Table.parsed(text, path)
    except ValueError as error:
        raise BadInput(f"{path}: the amendment {text!r} is not TOML: {error}") from error
    open_ = {name: [s for s in rows if not s.fixed] for name, rows in SETTINGS.items()}
    change.only(optional=tuple(name for name, rows in open_.items() if rows))
    for name in change.values:
        table = change.table(name)
        mass = ("mass_kg",) if name == "robot" else ()
        table.only(optional=(*mass, *(s.key for s in open_[name])))
        more = {}
        if "mass_kg" in table.values:
            mass_kg = table.number("mass_kg", 0.0, open_low=True)
            more = {"robot.link_mass_kg": mass_kg / setup.robot.links, "weighed": True}
        setup = applied(setup, table, open_[name], more)
    return setup
