"""The settings of a session: a dataclass for each table of session.toml.

People edit session.toml; its settings hold for all readings of the session.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from ..base.checks import check_number
from ..base.errors import BadInput
from ..base.toml_table import Table, located
from ..model.bends import BENDS
from ..model.gait import Gait
from ..model.robot import MAX_DENSITY_KG_M3, MAX_LINKS, Robot
from .declaration import (
    SettingsTable,
    in_si,
    in_si_units,
    number_field,
    toml_text,
    word_field,
)

ASSUMED_LINK_KG = 0.0756  # Mass of a link of the 2005 robot, for a robot that is not weighed.
# Limits of readings; beyond them a unit was mistaken. Joints cannot reach bends of 60 degrees, the
# snake tumbles before 45 degrees, and no treadmill runs faster than 10 m/s.
MAX_LAMBDA_DEG, MAX_INCLINE_DEG, MAX_SPEED_M_S = 60.0, 45.0, 10.0
# Largest sigma of an angle; the fit takes small angles as linear.
MAX_ANGLE_SIGMA_DEG = math.degrees(0.2)
MAX_PLACE_SIGMA_M = 0.05  # Largest sigma of a position; those of tape and film are 1 to 5 mm.


def text_field(note: str = "", words: str = "") -> Any:
    """Declare a text that must not be empty. note, words: as of a Field."""
    return word_field(default=MISSING, blank=False, note=note, words=words)


@dataclass(frozen=True, kw_only=True)
class Provenance(SettingsTable):
    """The table [provenance]: where the readings come from."""

    kind: str = word_field(
        "measured",
        "regenerated",
        "simulated",
        default=MISSING,
        note="measured, simulated, or regenerated from published fits",
    )
    source: str = text_field()
    note: str = text_field()


@dataclass(frozen=True, kw_only=True)
class RobotTable(SettingsTable):
    """The table [robot]. mass_kg: mass of the whole robot; None if it is not weighed yet."""

    links: int = number_field(2, MAX_LINKS, words="number of links")
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

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.wheels_kg and self.mass_kg and self.wheels_kg >= self.mass_kg:
            raise BadInput(
                f"wheels_kg is {self.wheels_kg:g}; all wheels together weigh less than the whole "
                f"robot, {self.mass_kg:g} kg; were they given in grams?"
            )

    @classmethod
    def read(cls, table: Table) -> RobotTable:
        """Return a file's table. An older file has the mass of one link, or marks it as assumed.

        Raises BadInput for a mass without its unit that would make links denser than any metal.
        """
        values = dict(table.values)
        if "link_mass_kg" in values:
            values["mass_kg"] = table.number("link_mass_kg") * table.integer("links")
        if not values.get("weighed", True):
            values["mass_kg"] = ""
        values = {k: v for k, v in values.items() if k not in ("link_mass_kg", "weighed")}
        robot = super().read(replace(table, values=values))
        if not isinstance(values["mass_kg"], str):
            with located(table.where("mass_kg")):
                robot.check_mass()
        return robot

    def check_mass(self) -> None:
        """Raise BadInput if links are denser than any metal, so that the unit is doubtful."""
        if self.mass_kg and self.too_heavy:
            raise BadInput(
                f"mass_kg is {self.mass_kg:g}; then a link of {self.link_length_m:g} m is heavier "
                f"than solid metal. In grams? In kg it is {self.mass_kg / 1e3:g}. If it is right, "
                f'session.toml takes it with its unit: mass_kg = "{self.mass_kg:g} kg"'
            )

    def file_value(self, name: str) -> Any:
        """Return the value of a key for a new file, with its unit if that is doubtful."""
        value = super().file_value(name)
        return f"{value:.10g} kg" if name == "mass_kg" and self.too_heavy else value

    @property
    def too_heavy(self) -> bool:
        """Return whether a link is heavier than a cube of the densest metal."""
        return (self.mass_kg or 0.0) / self.links > MAX_DENSITY_KG_M3 * self.link_length_m**3

    @property
    def tag_side_m(self) -> float | None:
        """Return the side of a printed tag, m; None if it is not stated."""
        return None if self.tag_mm is None else in_si("tag_mm", self.tag_mm)


@dataclass(frozen=True, kw_only=True)
class Laboratory(SettingsTable):
    """The table [laboratory]; friction holds for its surface alone."""

    surface: str = text_field(
        "what the wheels roll on; friction holds for it",
        "what the wheels roll on (the belt's or the floor's surface)",
    )
    place: str = text_field()
    people: str = text_field()
    gravity_m_s2: float = number_field(high=30.0, open_low=True)


def _planned_gaits(values: Any) -> tuple[Gait, ...]:
    """Return the gaits of a list of {alpha_deg, beta_deg, omega_rad_s or frequency_hz}."""
    return tuple(map(_planned_gait, values if isinstance(values, (list, tuple)) else [values]))


def _planned_gait(value: Any) -> Gait:
    if isinstance(value, Gait):
        return value
    in_hertz = {"omega_rad_s": 1.0 / math.tau, "frequency_hz": 1.0}
    rates = [name for name in in_hertz if isinstance(value, Mapping) and name in value]
    if len(rates) != 1 or set(value) != {"alpha_deg", "beta_deg", *rates}:
        raise BadInput(
            f"gaits has {value!r}; a gait is {{alpha_deg, beta_deg, frequency_hz}}, with one of "
            "omega_rad_s and frequency_hz"
        )
    hertz = check_number(rates[0], value[rates[0]]) * in_hertz[rates[0]]
    return Gait.degrees(value["alpha_deg"], value["beta_deg"], hertz=hertz)


@dataclass(frozen=True, kw_only=True)
class Instruments(SettingsTable):
    """The table [instruments]: standard deviations (0: exact), and smallest steps.

    Standard deviations of single readings: incline_sigma_deg of the inclinometer,
    belt_speed_sigma_m_s of the belt's speed past the snake, lambda_sigma_deg of a bend,
    joint_sigma_deg of each joint's error from straight, distance_sigma_m and time_sigma_s of tape
    and stopwatch, push_time_sigma_s of a push timed by hand.

    Standard deviations of errors that all readings share: incline_zero_sigma_deg of the
    inclinometer's zero, belt_scale_sigma_percent of the ratio of true to shown belt speed,
    mass_sigma_percent of the mass, film_scale_sigma_percent of lengths in films,
    floor_slope_sigma_deg of the floor's slope, before it is fitted.
    """

    incline_sigma_deg: float = number_field(
        high=MAX_INCLINE_DEG,
        open_low=True,
        words="inclinometer: smallest step it shows (deg)",
        note="steps of d give d / sqrt(12)",
    )
    incline_zero_sigma_deg: float = number_field(
        high=MAX_INCLINE_DEG,
        note="assumed of phones; a zero measured by reversal takes its place",
    )
    belt_speed_sigma_m_s: float = number_field(high=MAX_SPEED_M_S, open_low=True)
    lambda_sigma_deg: float = number_field(
        high=MAX_LAMBDA_DEG, note="of one bend, protractor and joints"
    )
    belt_scale_sigma_percent: float = number_field(
        high=50.0, default=0.0, note="of the speed that the treadmill shows"
    )
    mass_sigma_percent: float = number_field(high=50.0, default=0.0, note="of the robot's mass")
    joint_sigma_deg: float = number_field(
        high=MAX_ANGLE_SIGMA_DEG,
        default=0.0,
        words="joints: each is off straight by (deg; 0.5 by servos or straightedge, 1.5 by hand)",
        note="of each joint about straight",
    )
    incline_step_percent: float = number_field(
        high=20.0,
        default=0.5,
        open_low=True,
        words="treadmill: smallest step of its incline (% or deg)",
        note="what the treadmill can be set to",
    )
    belt_speed_unit: str = word_field(
        "m/s",
        "km/h",
        "mph",
        words="unit of the belt's speed (m/s, km/h, mph)",
        note="that the treadmill shows: of a speed typed without one",
    )
    belt_speed_step_m_s: float = number_field(
        high=MAX_SPEED_M_S,
        default=0.1 / 3.6,
        open_low=True,
        words="belt: smallest step it can be set to",
    )
    belt_speed_least_m_s: float = number_field(
        high=MAX_SPEED_M_S, default=0.0, words="belt: least speed above 0"
    )
    distance_sigma_m: float = number_field(
        high=MAX_PLACE_SIGMA_M, default=0.005, note="of a gait run: tape and marks; stopwatch"
    )
    time_sigma_s: float = number_field(default=0.2)
    film_scale_sigma_percent: float = number_field(
        high=20.0, default=0.5, note="of lengths in a film of pushes"
    )
    push_time_sigma_s: float = number_field(
        high=10.0, default=0.12, open_low=True, note="of a push timed by hand"
    )
    floor_slope_sigma_deg: float = number_field(
        high=MAX_ANGLE_SIGMA_DEG,
        default=0.3,
        open_low=True,
        note="of the floor, before both ways tell it",
    )

    incline_sigma_rad = in_si_units("incline_sigma_deg")
    incline_zero_sigma_rad = in_si_units("incline_zero_sigma_deg")
    lambda_sigma_rad = in_si_units("lambda_sigma_deg")
    belt_scale_sigma = in_si_units("belt_scale_sigma_percent")
    mass_sigma = in_si_units("mass_sigma_percent")
    joint_sigma_rad = in_si_units("joint_sigma_deg")
    incline_step_rad = in_si_units("incline_step_percent")
    film_scale_sigma = in_si_units("film_scale_sigma_percent")
    floor_slope_sigma_rad = in_si_units("floor_slope_sigma_deg")

    def speed(self, distance_m: float, time_s: float) -> tuple[float, float]:
        """Return the mean speed over a distance, and its standard deviation, m/s."""
        speed_m_s = distance_m / time_s
        sigma_m = math.hypot(self.distance_sigma_m, speed_m_s * self.time_sigma_s)
        return speed_m_s, sigma_m / time_s


@dataclass(frozen=True, kw_only=True)
class Plan(SettingsTable):
    """The table [plan]: the stations or pushes to take, and the gaits to run.

    On a treadmill, stations are taken in every bend of lambda_deg, at inclines from
    incline_start_deg in steps of incline_step_deg until the belt would exceed belt_speed_max_m_s.
    On a floor, each bend of push_lambda_deg has `pushes` pushes. Afterwards each of gaits is run
    gait_runs times on level ground. bend: "balanced", or "zigzag" for a robot that is guided.
    """

    on: str = word_field(
        "treadmill", "floor", note="treadmill; or floor: pushes instead of stations"
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
    bend: str = word_field(*BENDS, note="balanced; or zigzag, for a robot guided on the belt")
    gait_runs: int = number_field(
        1, 100, default=3, note="of each gait, on level ground of the same surface"
    )
    gaits: tuple[Gait, ...] = word_field(default=(), tidy=_planned_gaits)

    incline_step_rad = in_si_units("incline_step_deg")

    @classmethod
    def read(cls, table: Table) -> Plan:
        """Return a file's table; raises BadInput for the ratchet wheels of older versions."""
        what = "a fit knows one friction along the wheels, not another backwards"
        return super().read(table.without_removed({"ratchet": what}))


TABLES: dict[str, type[SettingsTable]] = {
    "provenance": Provenance,
    "robot": RobotTable,
    "laboratory": Laboratory,
    "instruments": Instruments,
    "plan": Plan,
}


@dataclass(frozen=True)
class Setup:
    """The set-up of a session: its name, and the tables of session.toml."""

    name: str
    provenance: Provenance
    robot_table: RobotTable
    laboratory: Laboratory
    instruments: Instruments
    plan: Plan

    @classmethod
    def read(cls, top: Table) -> Setup:
        """Return the set-up of a session.toml; raises BadInput."""
        top.check_keys("format", "name", "program", "created_utc", *TABLES)
        parts: list[Any] = [kind.read(top.table(name)) for name, kind in TABLES.items()]
        return cls(top.string("name"), *parts)

    @property
    def tables(self) -> dict[str, SettingsTable]:
        """Return the tables by their names in session.toml."""
        values = self.provenance, self.robot_table, self.laboratory, self.instruments, self.plan
        return dict(zip(TABLES, values, strict=True))

    @cached_property
    def robot(self) -> Robot:
        """Return the robot with the measured mass, or the assumed one."""
        table = self.robot_table
        link_kg = ASSUMED_LINK_KG if table.mass_kg is None else table.mass_kg / table.links
        return Robot(table.links, link_kg, table.link_length_m)

    def in_words(self) -> str:
        """Return the settings that a fit uses, in words, and those that are still empty."""
        tools, robot = self.instruments, self.robot
        grams, mm = 1000 * robot.links * robot.link_mass_kg, 1000 * robot.link_length_m
        treadmill = (
            f"inclinometer ± {tools.incline_sigma_deg:.2g} deg, belt ± "
            f"{tools.belt_speed_sigma_m_s:.2g} m/s, "
        )
        text = (
            f"{robot.links} links of {mm:.4g} mm, {grams:.4g} g ± {100 * self.mass_sigma:g} %, "
            f"{treadmill * (self.plan.on != 'floor')}bends ± {tools.lambda_sigma_deg:.2g} deg, "
            f"joints ± {tools.joint_sigma_deg:.2g} deg"
        )
        later = "mass_kg", "supply_v"  # empty until somebody has measured them
        empty = [key for key in later if getattr(self.robot_table, key) is None]
        return text + (f"; still to be filled in: {', '.join(empty)}" if empty else "")

    @property
    def mass_sigma(self) -> float:
        """Return the relative standard deviation of the mass; at least 5 % if it is assumed."""
        stated = self.instruments.mass_sigma
        return max(stated, 0.05) if self.robot_table.mass_kg is None else stated

    @property
    def weight_n(self) -> float:
        """Return the weight of the whole snake, N: m g of Eqs. 58 and 60."""
        return self.robot.links * self.robot.link_mass_kg * self.laboratory.gravity_m_s2

    def text(self, program: str, created_utc: str) -> str:
        """Return the text of session.toml."""
        head = (
            "# How this session is set up. Correct here what is mistyped, and fill in what is "
            "empty: it holds for\n# all readings of the session, and the next fit takes it. "
            "Another robot, surface or instrument is\n# another session.\nformat = 2\n"
            f"name = {toml_text(self.name)}\nprogram = {toml_text(program)}\n"
            f"created_utc = {toml_text(created_utc)}\n"
        )
        return head + "".join(f"\n[{name}]\n{t.text()}" for name, t in self.tables.items())


def changes(earlier: Setup, setup: Setup) -> list[str]:
    """Return the differences between two set-ups, a line for each setting."""
    lines = list[str]()
    for (name, old), new in zip(earlier.tables.items(), setup.tables.values(), strict=True):
        for key in old.declared:
            texts = [toml_text(getattr(table, key)) for table in (new, old)]
            if texts[0] != texts[1]:
                lines.append(f"{name}.{key} is {texts[0]} now; it was {texts[1]}")
    return lines


def amended(top: Table, details: Sequence[str], path: Path) -> Table:
    """Return session.toml with the amendments that older versions kept in events.csv.

    details: amendments as TOML. path: events.csv. Raises BadInput if instruments were amended.
    """
    values, tables = dict(top.values), ("robot", "laboratory", "plan", "provenance")
    with located(str(path)):
        for detail in details:
            try:
                change = Table.parsed(detail, path).values
            except ValueError as error:
                raise BadInput(f"the amendment {detail!r} is not TOML: {error}") from error
            for name, part in change.items():
                if name not in tables or not isinstance(part, dict):
                    raise BadInput(
                        f"the amendment {detail!r} is of {name!r}; a session has one set of "
                        f"instruments, and only {', '.join(tables)} were amended. If session.toml "
                        "was mistyped, correct it there, and take that line out of events.csv; "
                        "other instruments are another session"
                    )
                values[name] = {**values[name], **part}
    return replace(top, values=values)
