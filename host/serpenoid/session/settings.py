"""The settings of a session, a row each: session.toml is read, written and amended by these."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from ..base.checks import check_choice, check_number, check_whole
from ..base.errors import BadInput
from ..base.toml_table import Table, located
from ..model.gait import Gait
from ..model.robot import Robot, check_links
from .declaration import BELT_UNITS, in_si, in_unit
from .instruments import MAX_SPEED_M_S, Uncertainty
from .push_size import unlikely_sigma
from .session import MAX_GRAVITY_M_S2, PLACES, PROVENANCE, Procedure, Setup
from .station import BENDS, MAX_INCLINE_DEG, MAX_LAMBDA_DEG

FORMAT = 2
Reader = Callable[[Table, str], Any]
_BLANK = Setup(
    "",
    "",
    "",
    "",
    Robot(2, 1.0, 1.0),
    Procedure((), 0.0, 0.0, 0.0, 0.0),
    Uncertainty(1.0, 1.0, 1.0, 1.0),
)


@dataclass(frozen=True)
class Setting:
    """One entry of session.toml.

    key: its name there, with its unit. path: the attribute of Setup that holds it, in SI. read:
    returns the value of a table's key, in SI. note: what stands behind it in a new file. fixed: it
    stays as it was set up, whatever is amended.
    """

    key: str
    path: str
    read: Reader
    note: str = ""
    fixed: bool = False

    @property
    def needed(self) -> bool:
        """Tell whether a file must have it: nothing stands for it."""
        if self.path in ("surface", "place", "people", "robot.mass_kg"):
            return True  # in Setup the words may be blank, and a link's mass follows
        part, _, name = self.path.rpartition(".")
        field = (attrgetter(part)(_BLANK) if part else _BLANK).__dataclass_fields__[name]
        return field.default is MISSING and field.default_factory is MISSING

    def line(self, setup: Setup) -> str:
        """Return its line of session.toml; none where the set-up has no value."""
        value = attrgetter(self.path)(setup)
        return "" if value is None else f"{self.key} = {toml_text(self.key, value)}{self.note}\n"


def toml_text(key: str, value: Any) -> str:
    """Return a value in SI as TOML has it, in the unit of its key."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            return quoted(value)
        case float():
            text = f"{in_unit(key, value):.{8 if key.endswith('_deg') else 10}g}"
            return text if any(c in text for c in ".en") else f"{text}.0"
        case Gait():
            names = "alpha_rad", "beta_rad", "omega_rad_s"
            keys = "alpha_deg", "beta_deg", "omega_rad_s"
            numbers = zip(keys, attrgetter(*names)(value), strict=True)
            entries = (f"{name} = {toml_text(name, number)}" for name, number in numbers)
            return f"\n  {{ {', '.join(entries)} }},"
        case tuple():
            parts = [toml_text(key, part) for part in value]
            return f"[{''.join(parts)}\n]" if "\n" in "".join(parts) else f"[{', '.join(parts)}]"
    return str(value)


def quoted(text: str) -> str:
    """Return text as a TOML string."""
    return json.dumps("".join(c for c in text if c != "\x7f"), ensure_ascii=False)


def _number(*limits: float, open_low: bool = False) -> Reader:
    """Return the reader of a number between limits, in the unit of its key."""
    return lambda table, key: in_si(key, table.number(key, *limits, open_low=open_low))


def _checked(check: Callable[[str, Any], Any]) -> Reader:
    """Return the reader of a value that a function checks by its name."""

    def read(table: Table, key: str) -> Any:
        with located(table.where(key)):
            return check(key, table.values[key])

    return read


def _choice(choices: tuple[str, ...]) -> Reader:
    return _checked(lambda key, value: check_choice(key, value, choices))


def _check_flag(key: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise BadInput(f"{key} is {value!r}; it must be true or false")
    return value


def _check_place_sigma(key: str, value: Any) -> float:
    sigma_m = check_number(key, value, 0.0)
    if told := unlikely_sigma(sigma_m):
        raise BadInput(told)
    return sigma_m


def _bends(table: Table, key: str) -> tuple[float, ...]:
    return tuple(map(math.radians, table.numbers(key, 0.0, MAX_LAMBDA_DEG)))


def _gaits(table: Table, key: str) -> tuple[Gait, ...]:
    given, where = table.values[key], table.where(key)
    if not isinstance(given, list) or not all(isinstance(g, dict) for g in given):
        raise BadInput(f"{where}: {key} must be a list of {{alpha_deg, beta_deg, frequency_hz}}")
    gaits = []
    for values in given:
        entry = Table(values, table.path, table.text, table.start)
        entry.only("alpha_deg", "beta_deg", optional=("omega_rad_s", "frequency_hz"))
        alpha, beta = (in_si(n, entry.number(n, -360.0, 360.0)) for n in ("alpha_deg", "beta_deg"))
        with located(where):
            gaits.append(Gait(alpha, beta, _rate(entry)))
    return tuple(gaits)


def _rate(gait: Table) -> float:
    """Return a planned gait's rate, rad/s, which may be given in Hz."""
    given = [name for name in ("omega_rad_s", "frequency_hz") if name in gait.values]
    if len(given) != 1:
        said = " and ".join(given) or "neither"
        raise BadInput(f"a gait wants one of omega_rad_s and frequency_hz; {said} is given")
    rate = gait.number(given[0], 0.0, open_low=True)
    return rate if given[0] == "omega_rad_s" else 2 * math.pi * rate


_WORDS, _FLAG = Table.string, _checked(_check_flag)
_ABOVE_0, _FROM_0, _SHARE = _number(0.0, open_low=True), _number(0.0), _number(0.0, 50.0)
_BEND, _SPEED = _number(0.0, MAX_LAMBDA_DEG), _number(0.0, MAX_SPEED_M_S, open_low=True)
_INCLINE = _number(0.0, MAX_INCLINE_DEG, open_low=True)
SETTINGS: dict[str, tuple[Setting, ...]] = {
    "provenance": (
        Setting(
            "kind", "kind", _choice(PROVENANCE), "          # measured, or simulated", fixed=True
        ),
        Setting("source", "source", _WORDS, fixed=True),
        Setting("note", "note", _WORDS, fixed=True),
    ),
    "robot": (
        Setting(
            "links", "robot.links", _checked(lambda key, value: check_links(value)), fixed=True
        ),
        Setting(
            "mass_kg",
            "robot.mass_kg",
            _ABOVE_0,
            "       # the whole robot, cables and all",
            fixed=True,
        ),
        Setting("link_length_m", "robot.link_length_m", _ABOVE_0, "      # joint to joint"),
        Setting(
            "weighed",
            "weighed",
            _FLAG,
            "          # false: the mass is an assumption, asked for when readings are taken",
            fixed=True,
        ),
        Setting(
            "wheels_kg", "floor.wheels_kg", _number(0.0, 100.0), "          # all wheels together"
        ),
        Setting(
            "supply_v",
            "supply_v",
            _number(1.0, 60.0),
            "              # at the servos' plug, as they move",
        ),
        Setting("frame_ms", "frame_s", _number(1.0, 100.0), "              # of the board"),
        Setting("tag_mm", "tag_side_m", _number(3.0, 1000.0), "    # of its printed tags"),
    ),
    "laboratory": (
        Setting(
            "surface",
            "surface",
            _WORDS,
            "    # what the wheels roll on; friction holds for it alone",
        ),
        Setting("place", "place", _WORDS),
        Setting("people", "people", _WORDS),
        Setting(
            "gravity_m_s2",
            "procedure.gravity_m_s2",
            _number(0.0, MAX_GRAVITY_M_S2, open_low=True),
            fixed=True,
        ),
    ),
    "instruments": (
        Setting("incline_sigma_deg", "uncertainty.incline_sigma_rad", _INCLINE),
        Setting(
            "incline_zero_sigma_deg",
            "uncertainty.incline_zero_sigma_rad",
            _number(0.0, MAX_INCLINE_DEG),
            "    # assumed of phones; a zero measured by reversal takes its place",
        ),
        Setting("belt_speed_sigma_m_s", "uncertainty.belt_speed_sigma_m_s", _SPEED),
        Setting(
            "lambda_sigma_deg",
            "uncertainty.lambda_sigma_rad",
            _BEND,
            "          # of one bend, protractor and joints",
        ),
        Setting(
            "belt_scale_sigma_percent",
            "uncertainty.belt_scale_sigma",
            _SHARE,
            "  # of the speed that the treadmill shows",
        ),
        Setting(
            "mass_sigma_percent",
            "uncertainty.mass_sigma",
            _SHARE,
            "        # of the robot's mass",
        ),
        Setting(
            "joint_sigma_deg",
            "uncertainty.joint_sigma_rad",
            _number(0.0, math.degrees(0.2)),
            "           # of each joint about straight: 0.5 by servos or straightedge, 1.5 by hand",
        ),
        Setting(
            "incline_step_percent",
            "treadmill.incline_step_rad",
            _ABOVE_0,
            "      # what the treadmill can be set to",
        ),
        Setting(
            "belt_speed_unit",
            "belt_speed_unit",
            _choice(BELT_UNITS),
            "          # that the treadmill shows: of a speed typed without one",
        ),
        Setting("belt_speed_step_m_s", "treadmill.belt_step_m_s", _ABOVE_0),
        Setting("belt_speed_least_m_s", "treadmill.belt_least_m_s", _number(0.0, MAX_SPEED_M_S)),
        Setting(
            "distance_sigma_m",
            "stopwatch.distance_sigma_m",
            _checked(_check_place_sigma),
            "        # of a gait run: tape and marks; stopwatch",
        ),
        Setting("time_sigma_s", "stopwatch.time_sigma_s", _FROM_0),
        Setting(
            "film_scale_sigma_percent",
            "floor.film_scale_sigma",
            _number(0.0, 20.0),
            "  # of lengths in a film of pushes",
        ),
        Setting(
            "push_time_sigma_s",
            "floor.push_time_sigma_s",
            _number(0.0, 10.0, open_low=True),
            "         # of a push timed by hand",
        ),
        Setting(
            "floor_slope_sigma_deg",
            "floor.slope_sigma_rad",
            _number(0.0, math.degrees(0.2), open_low=True),
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
        Setting("push_lambda_deg", "procedure.push_lambda_rad", _bends),
        Setting(
            "pushes",
            "procedure.pushes",
            _checked(lambda key, value: check_whole(key, value, 0, 100)),
            "                  # in each of these bends, half of them either way",
        ),
        Setting(
            "lambda_deg",
            "procedure.lambda_rad",
            _bends,
            "    # 7.5 as in 2005; 15 and 30 tell cn three to ten times better",
        ),
        Setting("incline_start_deg", "procedure.incline_start_rad", _INCLINE),
        Setting("incline_step_deg", "procedure.incline_step_rad", _INCLINE),
        Setting("belt_speed_max_m_s", "procedure.belt_speed_max_m_s", _SPEED),
        Setting(
            "bend",
            "procedure.bend",
            _choice(BENDS),
            "             # balanced; or zigzag, for a robot that is guided on the belt",
        ),
        Setting(
            "gait_runs",
            "procedure.gait_runs",
            Table.whole,
            "              # of each gait, on level ground of the same surface",
        ),
        Setting("gaits", "procedure.gaits", _gaits),
    ),
}


def setup_in(top: Table) -> Setup:
    """Return the set-up of a session.toml; raises BadInput."""
    top.only("format", "name", "program", "created_utc", *SETTINGS)
    setup = replace(_BLANK, name=top.string("name"))
    for name, rows in SETTINGS.items():
        table = _with_whole_mass(top.table(name))
        needed = (s.key for s in rows if s.needed)
        optional = (s.key for s in rows if not s.needed)
        table.only(*needed, optional=(*optional, *_without_ratchet(table)))
        setup = applied(setup, table, rows)
    return setup


def _with_whole_mass(table: Table) -> Table:
    """Return an older file's [robot] with the whole robot's mass in place of a link's."""
    if "link_mass_kg" not in table.values or "links" not in table.values:
        return table
    values = dict(table.values)
    del values["link_mass_kg"]
    values["mass_kg"] = table.whole("links") * _ABOVE_0(table, "link_mass_kg")
    return replace(table, values=values)


def _without_ratchet(plan: Table) -> tuple[str, ...]:
    """Return the key `ratchet` of older plans where it says false; raises BadInput where true."""
    if plan.values.get("ratchet") is True:
        raise BadInput(
            f"{plan.where('ratchet')}: ratchet is true, but a fit knows one friction along the "
            "wheels, not another backwards; such a session is not read"
        )
    return ("ratchet",) if plan.values.get("ratchet") is False else ()


def applied(setup: Setup, table: Table, settings: Iterable[Setting]) -> Setup:
    """Return a set-up with what a table has of some settings; raises BadInput."""
    values = {s.path: s.read(table, s.key) for s in settings if s.key in table.values}
    with located(table.heading):
        return changed(setup, values)


def changed(setup: Setup, values: Mapping[str, Any]) -> Setup:
    """Return a set-up with some values changed, given by their paths; raises BadInput."""
    for path, value in values.items():
        part, _, name = path.rpartition(".")
        new = {name: value}
        if part == "robot":  # its inertia follows from mass and length
            new["link_inertia_kg_m2"] = None
        if path == "robot.mass_kg":
            new = {"link_mass_kg": value / setup.robot.links, "link_inertia_kg_m2": None}
        setup = replace(setup, **({part: replace(getattr(setup, part), **new)} if part else new))
    return setup


def amended(setup: Setup, text: str, folder: Path) -> Setup:
    """Return a set-up with an amendment's line of TOML applied; raises BadInput.

    [plan] holds from here on. [robot], [laboratory] and [instruments] hold for all of the session.
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
        table.only(optional=(*mass, *(s.key for s in open_[name]), *_without_ratchet(table)))
        if "mass_kg" in table.values:
            mass_kg = _ABOVE_0(table, "mass_kg")
            setup = changed(setup, {"robot.mass_kg": mass_kg, "weighed": True})
        setup = applied(setup, table, open_[name])
    return setup
