"""The calibration session on disk, read strictly: session.toml says how, readings.csv what.

A folder's files speak degrees, as people type them; the session that is made of them speaks SI.
Format 1 has one file of stations; format 2 (session_rows) has readings of every kind and events.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..model.checks import check_choice, check_whole
from ..model.errors import BadInput
from ..model.files import csv_rows, read_text
from ..model.gait import Gait
from ..model.robot import Robot
from ..model.toml_table import Table, check_names, located
from .kinds.instruments import MAX_SPEED_M_S, FloorTools, Stopwatch, TreadmillSteps, Uncertainty
from .kinds.station import BENDS, MAX_INCLINE_DEG, MAX_LAMBDA_DEG, STATION, Reading
from .session import MAX_GRAVITY_M_S2, PLACES, PROVENANCE, Procedure, Session, Setup
from .session_rows import change_of, read_format_2, time_of

FORMAT = 2
COLUMNS = (
    "reading",
    "time_utc",
    "lambda_deg",
    "incline_deg",
    "belt_speed_m_s",
    "drift_m_s",
    "status",
    "comment",
)
STATUSES = ("kept", "void")
_SIGMAS = (
    "incline_sigma_deg",
    "incline_zero_sigma_deg",
    "belt_speed_sigma_m_s",
    "lambda_sigma_deg",
)
_SHARED = {  # optional, since sessions of before do not state them: key -> field, its unit in SI
    "belt_scale_sigma_percent": ("belt_scale_sigma", 0.01),
    "mass_sigma_percent": ("mass_sigma", 0.01),
    "joint_sigma_deg": ("joint_sigma_rad", math.radians(1.0)),
}
_STEPS = (
    "incline_step_percent",
    "belt_speed_step_m_s",
    "belt_speed_least_m_s",
    "distance_sigma_m",
    "time_sigma_s",
)
_FLOOR = {  # optional, of pushes and slides: key -> field of FloorTools, its unit in SI
    "film_scale_sigma_percent": ("film_scale_sigma", 0.01),
    "push_time_sigma_s": ("push_time_sigma_s", 1.0),
    "floor_slope_sigma_deg": ("slope_sigma_rad", math.radians(1.0)),
}
_PLUG = {  # optional, of the robot: key -> field of Setup, its unit in SI, limits
    "supply_v": ("supply_v", 1.0, 1.0, 60.0),
    "frame_ms": ("frame_s", 1e-3, 1.0, 100.0),
    "tag_mm": ("tag_side_m", 1e-3, 3.0, 1000.0),
}
_WORDS = ("surface", "place", "people")
_PLAN_TOO = ("gaits", "gait_runs", "ratchet", "bend", "on", "pushes", "push_lambda_deg")
_PLAN = ("lambda_deg", "incline_start_deg", "incline_step_deg", "belt_speed_max_m_s")


def load_session(folder: str | Path) -> Session:
    """Read a session's folder, of either format.

    Parameters
    ----------
    folder
        Holds session.toml and readings.csv.

    Returns
    -------
    Session
        The set-up and all readings.

    Raises
    ------
    BadInput
        If anything is missing, unknown, in other units, out of range or of a newer format, or if no
        reading is left to use. The message names file, line, value and limits.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> len(session.kept)
    11
    """
    session = read_session(folder)
    if not (session.kept or session.on_floor or session.kept_gait_runs or session.kept_films):
        raise BadInput(
            f"{session.where}: no reading to use among {len(session.readings)}; take some"
        )
    return session


def read_session(folder: str | Path) -> Session:
    """Read a session's folder as load_session does, one that has no readings yet, too."""
    folder = Path(folder)
    top = _load_toml(folder)
    setup = _setup(top)
    path = folder / "readings.csv"
    if top.whole("format") == 1:
        return Session(setup, _load_readings(path), str(path), folder=folder)
    return read_format_2(setup, folder, amended)


def load_setup(folder: str | Path) -> Setup:
    """Read a session's session.toml alone; raises BadInput as load_session does."""
    return _setup(_load_toml(folder))


def amended(setup: Setup, change: Table) -> Setup:
    """Return a set-up with some entries changed; raises BadInput.

    [instruments] and [plan] hold from here on. [robot] and [laboratory] correct what was mistyped
    or left open, for all of the session.
    """
    change.only(optional=("instruments", "plan", "robot", "laboratory"))
    if "robot" in change.values:
        setup = _corrected(change.table("robot"), setup)
    if "laboratory" in change.values:
        table = change.table("laboratory")
        table.only(optional=_WORDS)
        setup = replace(setup, **{name: table.string(name) for name in table.values})
    if "instruments" in change.values:
        table = change.table("instruments")
        table.only(optional=(*_SIGMAS, *_STEPS, *_SHARED, *_FLOOR))
        setup = replace(setup, **_instruments(table, setup))
    if "plan" in change.values:
        table = change.table("plan")
        table.only(optional=(*_PLAN, *_PLAN_TOO))
        setup = replace(setup, procedure=_plan(table, setup.procedure))
    return setup


def _corrected(table: Table, setup: Setup) -> Setup:
    """Return a set-up with the robot's mass, wheels or length of links corrected."""
    table.only(optional=("mass_kg", "link_length_m", "wheels_kg", *_PLUG))
    setup = replace(setup, **_plug(table))
    if "wheels_kg" in table.values:
        wheels_kg = table.number("wheels_kg", 0.0)
        setup = replace(setup, floor=replace(setup.floor, wheels_kg=wheels_kg))
    robot = setup.robot
    mass_kg, length_m = robot.links * robot.link_mass_kg, robot.link_length_m
    if "mass_kg" in table.values:
        mass_kg = table.number("mass_kg", 0.0, open_low=True)
        setup = replace(setup, weighed=True)
    if "link_length_m" in table.values:
        length_m = table.number("link_length_m", 0.0, open_low=True)
    with located(table.heading):
        return replace(setup, robot=Robot(robot.links, mass_kg / robot.links, length_m))


def check_amendment(setup: Setup, text: str, folder: Path) -> Setup:
    """Return a set-up with an amendment's line of TOML applied, or raise BadInput."""
    return amended(setup, change_of(text, folder / "events.csv"))


def _load_toml(folder: str | Path) -> Table:
    path = Path(folder) / "session.toml"
    if not path.exists():
        raise BadInput(
            f"{folder}: no session here (no session.toml); `serpenoid calibrate new {folder}` "
            "begins one"
        )
    top = Table.load(path)
    top.check_format(FORMAT)
    return top


def _setup(top: Table) -> Setup:
    old = top.whole("format") == 1
    if old:
        top.only("format", "name", "provenance", "robot", "procedure", "uncertainty")
    else:
        tables = ("provenance", "robot", "laboratory", "instruments", "plan")
        top.only("format", "name", "program", "created_utc", *tables)
    provenance = top.table("provenance")
    provenance.only("kind", "source", "note")
    with located(provenance.where("kind")):
        kind = check_choice("kind", provenance.values["kind"], PROVENANCE)
    words = {
        "name": top.string("name"),
        "kind": kind,
        "source": provenance.string("source"),
        "note": provenance.string("note"),
        "robot": _robot(top.table("robot")),
        "weighed": _flag(top.table("robot"), "weighed", usual=True),
    } | _plug(top.table("robot"))
    if "wheels_kg" in top.table("robot").values:
        words["floor"] = FloorTools(wheels_kg=top.table("robot").number("wheels_kg", 0.0))
    return _setup_1(top, words) if old else _setup_2(top, words)


def _setup_1(top: Table, words: dict[str, Any]) -> Setup:
    procedure, uncertainty = top.table("procedure"), top.table("uncertainty")
    procedure.only(*_PLAN, "gravity_m_s2")
    uncertainty.only(*_SIGMAS)
    plan = _plan(procedure, replace(_NO_PLAN, gravity_m_s2=_gravity(procedure)))
    return Setup(procedure=plan, uncertainty=_uncertainty(uncertainty), **words)


def _setup_2(top: Table, words: dict[str, Any]) -> Setup:
    laboratory, plan = top.table("laboratory"), top.table("plan")
    instruments = top.table("instruments")
    laboratory.only("surface", "place", "people", "gravity_m_s2")
    plan.only(*_PLAN, optional=_PLAN_TOO)
    instruments.only(*_SIGMAS, optional=(*_STEPS, *_SHARED, *_FLOOR))
    procedure = _plan(plan, replace(_NO_PLAN, gravity_m_s2=_gravity(laboratory)))
    setup = Setup(
        procedure=procedure,
        uncertainty=_uncertainty(instruments),
        **{name: laboratory.string(name) for name in _WORDS},
        **words,
    )
    return replace(setup, **_instruments(instruments, setup))


def _gravity(table: Table) -> float:
    return table.number("gravity_m_s2", 0.0, MAX_GRAVITY_M_S2, open_low=True)


_NO_PLAN = Procedure((), 0.0, 0.0, 0.0, 0.0)


def _robot(table: Table) -> Robot:
    table.only("links", "link_mass_kg", "link_length_m", optional=("weighed", "wheels_kg", *_PLUG))
    links = table.whole("links")
    mass_kg = table.number("link_mass_kg", 0.0, open_low=True)
    length_m = table.number("link_length_m", 0.0, open_low=True)
    with located(table.where("links")):
        return Robot(links, mass_kg, length_m)


def _plug(table: Table) -> dict[str, float]:
    """Return what a table says of the servos' plug, by the fields of Setup."""
    return {
        field: unit * table.number(name, low, high)
        for name, (field, unit, low, high) in _PLUG.items()
        if name in table.values
    }


def _flag(table: Table, name: str, *, usual: bool) -> bool:
    value = table.values.get(name, usual)
    if not isinstance(value, bool):
        raise BadInput(f"{table.where(name)}: {name} is {value!r}; it must be true or false")
    return value


def _plan(table: Table, before: Procedure) -> Procedure:
    """Return a plan with what the table has of it changed."""
    found: dict[str, Any] = {}
    if "lambda_deg" in table.values:
        bends_deg = table.numbers("lambda_deg", 0.0, MAX_LAMBDA_DEG)
        found["lambda_rad"] = tuple(map(math.radians, bends_deg))
    for name in ("incline_start", "incline_step"):
        if f"{name}_deg" in table.values:
            value_deg = table.number(f"{name}_deg", 0.0, MAX_INCLINE_DEG, open_low=True)
            found[f"{name}_rad"] = math.radians(value_deg)
    if "belt_speed_max_m_s" in table.values:
        most_m_s = table.number("belt_speed_max_m_s", 0.0, MAX_SPEED_M_S, open_low=True)
        found["belt_speed_max_m_s"] = most_m_s
    if "gait_runs" in table.values:
        found["gait_runs"] = table.whole("gait_runs")
    if "ratchet" in table.values:
        found["ratchet"] = _flag(table, "ratchet", usual=False)
    if "bend" in table.values:
        with located(table.where("bend")):
            found["bend"] = check_choice("bend", table.values["bend"], BENDS)
    if "gaits" in table.values:
        found["gaits"] = _gaits(table)
    if "on" in table.values:
        with located(table.where("on")):
            found["on"] = check_choice("on", table.values["on"], PLACES)
    if "pushes" in table.values:
        with located(table.where("pushes")):
            found["pushes"] = check_whole("pushes", table.values["pushes"], 0, 100)
    if "push_lambda_deg" in table.values:
        bends_deg = table.numbers("push_lambda_deg", 0.0, MAX_LAMBDA_DEG)
        found["push_lambda_rad"] = tuple(map(math.radians, bends_deg))
    return replace(before, **found)


def _gaits(table: Table) -> tuple[Gait, ...]:
    given = table.values["gaits"]
    where = table.where("gaits")
    if not isinstance(given, list) or not all(isinstance(g, dict) for g in given):
        raise BadInput(f"{where}: gaits must be a list of {{alpha_deg, beta_deg, frequency_hz}}")
    found = []
    for values in given:
        one = Table(values, table.path, table.text, table.start)
        one.only("alpha_deg", "beta_deg", optional=("omega_rad_s", "frequency_hz"))
        alpha, beta = (one.number(f"{n}_deg", -360.0, 360.0) for n in ("alpha", "beta"))
        with located(where):
            found.append(Gait(math.radians(alpha), math.radians(beta), _rate(one)))
    return tuple(found)


def _rate(gait: Table) -> float:
    """Return a planned gait's rate, rad/s, which may be given in Hz."""
    given = [name for name in ("omega_rad_s", "frequency_hz") if name in gait.values]
    if len(given) != 1:
        said = " and ".join(given) or "neither"
        raise BadInput(f"a gait wants one of omega_rad_s and frequency_hz; {said} is given")
    rate = gait.number(given[0], 0.0, open_low=True)
    return rate if given[0] == "omega_rad_s" else 2 * math.pi * rate


def _uncertainty(table: Table, before: Uncertainty | None = None) -> Uncertainty:
    """Return the uncertainties with what the table has of them changed."""
    found: dict[str, float] = {}
    for name, most, above_0 in (
        ("incline_sigma_deg", MAX_INCLINE_DEG, True),
        ("incline_zero_sigma_deg", MAX_INCLINE_DEG, False),
        ("belt_speed_sigma_m_s", MAX_SPEED_M_S, True),
        ("lambda_sigma_deg", MAX_LAMBDA_DEG, False),
    ):
        if name in table.values:
            value = table.number(name, 0.0, most, open_low=above_0)
            in_degrees = name.endswith("_deg")
            field = name.replace("_deg", "_rad") if in_degrees else name
            found[field] = math.radians(value) if in_degrees else value
    for name, (field, unit) in _SHARED.items():
        if name in table.values:
            found[field] = unit * table.number(name, 0.0)
    return replace(before, **found) if before else Uncertainty(**found)


def _instruments(table: Table, setup: Setup) -> dict[str, Any]:
    """Return the fields of a set-up that a table of instruments changes."""
    given = {name: table.number(name, 0.0) for name in _STEPS if name in table.values}
    steps, watch = setup.treadmill, setup.stopwatch
    with located(table.heading):
        return {
            "uncertainty": _uncertainty(table, setup.uncertainty),
            "treadmill": TreadmillSteps(
                given.get("incline_step_percent", 100 * steps.incline_step_rad) / 100,
                given.get("belt_speed_step_m_s", steps.belt_step_m_s),
                given.get("belt_speed_least_m_s", steps.belt_least_m_s),
            ),
            "stopwatch": Stopwatch(
                given.get("distance_sigma_m", watch.distance_sigma_m),
                given.get("time_sigma_s", watch.time_sigma_s),
            ),
            "floor": replace(
                setup.floor,
                **{
                    field: unit * table.number(name, 0.0)
                    for name, (field, unit) in _FLOOR.items()
                    if name in table.values
                },
            ),
        }


def _load_readings(path: Path) -> tuple[Reading, ...]:
    header, *rows = csv_rows(read_text(path), path) or [[]]
    check_names(header, COLUMNS, f"{path}:1", "column", ("facing",))
    found: dict[int, Reading] = {}
    for number, cells in enumerate(rows, 2):
        with located(f"{path}:{number}"):
            reading = _reading(header, cells)
            _check_repeat(found.get(reading.number), reading)
        found[reading.number] = reading
    return tuple(found.values())


def _reading(header: list[str], cells: list[str]) -> Reading:
    if len(cells) != len(header):
        raise BadInput(
            f"{len(cells)} cells where the header has {len(header)}; a row cut short by a "
            "power cut may be deleted, and decimals take a point, not a comma"
        )
    row = {name: cell.strip() for name, cell in zip(header, cells, strict=True)}
    if not re.fullmatch("[1-9][0-9]{0,8}", row["reading"]):
        raise BadInput(f"reading is {row['reading']!r}; it must be a whole number from 1")
    return Reading(
        number=int(row["reading"]),
        voided=check_choice("status", row["status"], STATUSES) == "void",
        comment=row["comment"],
        time_utc=time_of(row["time_utc"]),
        **{f.name: f.read(row.get(f.column, "")) for f in STATION.fields},  # type: ignore[arg-type]
    )


def _check_repeat(earlier: Reading | None, later: Reading) -> None:
    """Let a row repeat an earlier one only to void it: the file is appended to, never rewritten."""
    if earlier is None:
        return

    def measured(r: Reading) -> tuple[float | str, ...]:
        return r.lambda_rad, r.incline_rad, r.belt_speed_m_s, r.drift_m_s, r.facing

    if earlier.voided or not later.voided or measured(earlier) != measured(later):
        raise BadInput(
            f"reading {later.number} is there already; a row may repeat it only to void it, once, "
            "with the same values; give a new reading a new number"
        )
