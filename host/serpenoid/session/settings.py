"""The settings of a session, a dataclass for each table of session.toml.

session.toml is a file that people edit: what it says holds for all readings of the session.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ..base.checks import check_number
from ..base.errors import BadInput
from ..base.toml_table import Table, located
from ..model.drives import FRAME_S, ServoKind
from ..model.gait import Gait
from ..model.robot import Robot, check_links
from ..robot.wire.protocol import frame_us
from .declaration import in_si, number_field
from .instruments import MAX_INCLINE_DEG, MAX_LAMBDA_DEG, MAX_SPEED_M_S, Instruments
from .settings_table import SettingsTable, choice, in_si_units, read_by, toml_text
from .station import BENDS

FORMAT = 2
PLACES = ("treadmill", "floor")  # where a plan is carried out
PROVENANCE = ("measured", "regenerated", "simulated")
MAX_GRAVITY_M_S2 = 30.0
ASSUMED_LINK_KG = 0.0756  # of the 2005 robot, where nobody has weighed this one yet
NOT_WEIGHED = 0.05  # relative standard deviation of a mass that is an assumption
LATER = ("mass_kg", "supply_v")  # settings that may stay empty until somebody has measured them


@dataclass(frozen=True, kw_only=True)
class Provenance(SettingsTable):
    """The table [provenance]: where the readings come from."""

    kind: str = choice(*PROVENANCE, note="measured, simulated, or regenerated from published fits")
    source: str
    note: str


@dataclass(frozen=True, kw_only=True)
class RobotTable(SettingsTable):
    """The table [robot]. mass_kg: of the whole robot; None: nobody has weighed it yet."""

    links: int = read_by(check_links)
    link_length_m: float = number_field(
        0.001,
        10.0,
        words="length of a link, joint to joint (m, or 76 mm)",
        likely=(0.01, 1.0),
        note="joint to joint",
    )
    mass_kg: float | None = number_field(
        0.001,
        1000.0,
        words="mass of the whole robot as it crawls (kg, or 480 g; later)",
        likely=(0.02, 20.0),
        note='of the whole robot as it crawls, cables and all; "" until it is weighed',
    )
    wheels_kg: float | None = number_field(
        high=100.0,
        default=None,
        words="mass of all wheels together (kg, or 36 g; later)",
        likely=(0.001, 2.0),
        note="of all wheels together, which a push sets turning",
    )
    supply_v: float | None = number_field(
        1.0,
        60.0,
        default=None,
        words="servos: voltage at their plug while they move (V; later)",
        likely=(4.0, 15.0),
        note="at the servos' plug, as they move",
    )
    frame_ms: float | None = number_field(
        1.0, 100.0, default=None, note='of the board; "": its own'
    )
    tag_mm: float | None = number_field(3.0, 1000.0, default=None, note="side of its printed tags")

    @classmethod
    def read(cls, table: Table) -> RobotTable:
        """Return a file's table; an older file has the mass of one link, or says it was assumed."""
        values = dict(table.values)
        if "link_mass_kg" in values:
            values["mass_kg"] = table.number("link_mass_kg") * table.whole("links")
        if not values.get("weighed", True):
            values["mass_kg"] = ""
        kept = {k: v for k, v in values.items() if k not in ("link_mass_kg", "weighed")}
        return super().read(replace(table, values=kept))

    @property
    def weighs(self) -> bool:
        """Tell whether the mass is no assumption."""
        return self.mass_kg is not None

    @property
    def mean_link_kg(self) -> float:
        """Return the mass over the number of links, an assumed one where nobody weighed it."""
        return ASSUMED_LINK_KG if self.mass_kg is None else self.mass_kg / self.links

    @property
    def tag_side_m(self) -> float | None:
        """Return the side of a printed tag; None where nobody said it."""
        return None if self.tag_mm is None else in_si("tag_mm", self.tag_mm)


@dataclass(frozen=True, kw_only=True)
class Laboratory(SettingsTable):
    """The table [laboratory]; friction holds for its surface alone."""

    surface: str = read_by(
        lambda value: _text("surface", value), note="what the wheels roll on; friction holds for it"
    )
    place: str
    people: str
    gravity_m_s2: float = number_field(high=MAX_GRAVITY_M_S2, open_low=True)


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise BadInput(f"{name} is {value!r}; it must be text in quotes")
    return value.strip()


def _planned_gaits(values: Sequence[Any]) -> tuple[Gait, ...]:
    """Return the gaits of a list of {alpha_deg, beta_deg, omega_rad_s or frequency_hz}."""
    return tuple(value if isinstance(value, Gait) else _planned_gait(value) for value in values)


def _planned_gait(value: Any) -> Gait:
    rates = {"omega_rad_s": 1.0, "frequency_hz": 2 * math.pi}
    named = [name for name in rates if isinstance(value, Mapping) and name in value]
    if len(named) != 1 or set(value) != {"alpha_deg", "beta_deg", *named}:
        raise BadInput(
            f"gaits has {value!r}; a gait is {{alpha_deg, beta_deg, frequency_hz}}, with one of "
            "omega_rad_s and frequency_hz"
        )
    alpha, beta = (check_number(n, value[n], -360.0, 360.0) for n in ("alpha_deg", "beta_deg"))
    rate = check_number(named[0], value[named[0]], 0.0, open_low=True)
    return Gait(math.radians(alpha), math.radians(beta), rate * rates[named[0]])


@dataclass(frozen=True, kw_only=True)
class Plan(SettingsTable):
    """The table [plan]: which stations or pushes are to be taken, and which gaits to run.

    On a treadmill: every bend of lambda_deg, from the first incline up to the top speed. On a
    floor: in each bend of push_lambda_deg `pushes` pushes. gaits: to be run on level ground
    afterwards, each gait_runs times. bend: "balanced", or "zigzag" for a robot that is guided.
    """

    on: str = choice(
        *PLACES, default="treadmill", note="treadmill; or floor: pushes instead of stations"
    )
    push_lambda_deg: tuple[float, ...] = number_field(
        high=MAX_LAMBDA_DEG, default=(0.0, 20.0, 45.0)
    )
    pushes: int = number_field(
        0, 100, default=8, note="in each of these bends, half of them either way"
    )
    lambda_deg: tuple[float, ...] = number_field(
        high=MAX_LAMBDA_DEG, note="7.5 as in 2005; 15 and 30 tell cn three to ten times better"
    )
    incline_start_deg: float = number_field(high=MAX_INCLINE_DEG, open_low=True)
    incline_step_deg: float = number_field(high=MAX_INCLINE_DEG, open_low=True)
    belt_speed_max_m_s: float = number_field(high=MAX_SPEED_M_S, open_low=True)
    bend: str = choice(
        *BENDS, default="zigzag", note="balanced; or zigzag, for a robot guided on the belt"
    )
    gait_runs: int = number_field(
        1, 100, default=3, note="of each gait, on level ground of the same surface"
    )
    gaits: tuple[Gait, ...] = read_by(_planned_gaits, ())

    incline_start_rad = in_si_units("incline_start_deg")
    incline_step_rad = in_si_units("incline_step_deg")

    @classmethod
    def read(cls, table: Table) -> Plan:
        """Return a file's table; raises BadInput for ratchet wheels, which older programs knew."""
        what = "a fit knows one friction along the wheels, not another backwards"
        return super().read(table.without_removed({"ratchet": what}))

    @property
    def lambda_rad(self) -> tuple[float, ...]:
        """Return the bends of stations, rad."""
        return tuple(map(math.radians, self.lambda_deg))

    @property
    def push_lambda_rad(self) -> tuple[float, ...]:
        """Return the bends of pushes, rad."""
        return tuple(map(math.radians, self.push_lambda_deg))

    @property
    def bends_rad(self) -> tuple[float, ...]:
        """Return the bends that the robot is to lie in where the plan is carried out."""
        return self.push_lambda_rad if self.on == "floor" else self.lambda_rad


TABLES: dict[str, type[SettingsTable]] = {
    "provenance": Provenance,
    "robot": RobotTable,
    "laboratory": Laboratory,
    "instruments": Instruments,
    "plan": Plan,
}


@dataclass(frozen=True)
class Setup:
    """All of a session but its readings: its name, and the tables of session.toml."""

    name: str
    provenance: Provenance
    robot_table: RobotTable
    laboratory: Laboratory
    instruments: Instruments
    plan: Plan

    @classmethod
    def read(cls, top: Table) -> Setup:
        """Return the set-up of a session.toml; raises BadInput."""
        top.only("format", "name", "program", "created_utc", *TABLES)
        return cls(
            top.string("name"),
            Provenance.read(top.table("provenance")),
            RobotTable.read(top.table("robot")),
            Laboratory.read(top.table("laboratory")),
            Instruments.read(top.table("instruments")),
            Plan.read(top.table("plan")),
        )

    @property
    def tables(self) -> dict[str, SettingsTable]:
        """Return the tables by their names in session.toml."""
        values = self.provenance, self.robot_table, self.laboratory, self.instruments, self.plan
        return dict(zip(TABLES, values, strict=True))

    @cached_property
    def robot(self) -> Robot:
        """Return the robot, as weighed and measured."""
        table = self.robot_table
        return Robot(table.links, table.mean_link_kg, table.link_length_m)

    def with_robot(self, robot: Robot) -> Setup:
        """Return the set-up with another robot's links, mass and length."""
        mass_kg = robot.links * robot.link_mass_kg
        body = {"links": robot.links, "mass_kg": mass_kg, "link_length_m": robot.link_length_m}
        return replace(self, robot_table=replace(self.robot_table, **body))

    def in_words(self) -> str:
        """Return what a fit takes from session.toml, and what of it is still to be filled in."""
        body, tools, robot = self.robot_table, self.instruments, self.robot
        grams, mm = 1000 * robot.links * robot.link_mass_kg, 1000 * robot.link_length_m
        text = (
            f"{robot.links} links of {mm:.4g} mm, {grams:.4g} g ± {100 * self.mass_sigma:g} %, "
            f"inclinometer ± {tools.incline_sigma_deg:.2g} deg, belt ± "
            f"{tools.belt_speed_sigma_m_s:.2g} m/s, bends ± {tools.lambda_sigma_deg:.2g} deg, "
            f"joints ± {tools.joint_sigma_deg:.2g} deg"
        )
        empty = [key for key in LATER if getattr(body, key) is None]
        return text + (f"; still to be filled in: {', '.join(empty)}" if empty else "")

    @property
    def mass_sigma(self) -> float:
        """Return the relative standard deviation of the mass; 5 % where it was not weighed."""
        stated = self.instruments.mass_sigma
        return stated if self.robot_table.weighs else max(stated, NOT_WEIGHED)

    @property
    def weight_n(self) -> float:
        """Return the weight of the whole snake, the m g of Eqs. 58 and 60."""
        return self.robot.links * self.robot.link_mass_kg * self.laboratory.gravity_m_s2

    def driving(self, kind: ServoKind) -> ServoKind:
        """Return a kind of servo at the session's voltage and frames, where it states none."""
        table = self.robot_table
        if table.supply_v is not None and kind.sigma.get("supply_v"):
            kind = kind.at_volts(table.supply_v)
        if kind.servo.frame_s != FRAME_S:
            return kind
        own_ms = 1e-3 * frame_us(table.links - 1)
        return kind.at_frames(in_si("frame_ms", table.frame_ms or own_ms))

    def text(self, program: str, created_utc: str) -> str:
        """Return session.toml."""
        head = TEXT.format(*(toml_text(text) for text in (self.name, program, created_utc)))
        return head + "".join(f"\n[{name}]\n{t.text()}" for name, t in self.tables.items())


TEXT = """\
# How this session is set up. Correct here what is mistyped, and fill in what is empty: it holds for
# all readings of the session, and the next fit takes it. Another robot, surface or instrument is
# another session.
format = 2
name = {}
program = {}
created_utc = {}
"""


def changes(before: Setup, now: Setup) -> list[str]:
    """Return what differs between two set-ups, a line a setting."""
    lines = list[str]()
    for (name, old), new in zip(before.tables.items(), now.tables.values(), strict=True):
        for part in fields(old):
            was, is_ = getattr(old, part.name), getattr(new, part.name)
            if was != is_:
                text, was_text = toml_text(is_).strip(), toml_text(was).strip()
                lines.append(f"{name}.{part.name} is {text} now; it was {was_text}")
    return lines


def amended(top: Table, details: Sequence[str], path: Path) -> Table:
    """Return session.toml with the amendments that older programs kept in events.csv put in.

    Raises BadInput where instruments changed: a session has one set of them.
    """
    values: dict[str, Any] = {
        name: dict(part) if isinstance(part, dict) else part for name, part in top.values.items()
    }
    for detail in details:
        with located(str(path)):
            try:
                change = Table.parsed(detail, path).values
            except ValueError as error:
                raise BadInput(f"the amendment {detail!r} is not TOML: {error}") from error
            for name, part in change.items():
                if name not in TABLES or not isinstance(part, dict):
                    raise BadInput(f"the amendment {detail!r} has no table {name!r}")
                if name == "instruments":
                    raise BadInput(
                        f"{', '.join(part)} was amended in mid-session, but a session has one set "
                        "of instruments. Begin a new session for others; if session.toml was "
                        "mistyped, correct it there, and take that line out of events.csv"
                    )
                values[name].update(part)
    return replace(top, values=values)
