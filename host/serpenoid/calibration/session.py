"""The calibration session on disk, read strictly: session.toml says how, readings.csv what.

A folder's files speak degrees, as people type them; everything here is SI and radians.
"""

from __future__ import annotations

import csv
import io
import math
import re
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from ..model.checks import check_choice, check_number
from ..model.errors import BadInput
from ..model.robot import Robot
from ..model.toml_table import Table, check_names, located, read_text

FORMAT = 1
COLUMNS = (
    "reading", "time_utc", "lambda_deg", "incline_deg", "belt_speed_m_s", "drift_m_s", "status",
    "comment",
)  # fmt: skip
KINDS = ("measured", "regenerated", "simulated")
STATUSES = ("kept", "void")
# Beyond these a number is a slip of units, not a reading: the joints end before 60 degrees, the
# snake tumbles before 45, and no treadmill runs at 10 m/s.
MAX_LAMBDA_DEG, MAX_INCLINE_DEG, MAX_SPEED_M_S, MAX_GRAVITY_M_S2 = 60.0, 45.0, 10.0, 30.0


@dataclass(frozen=True, slots=True)
class Reading:
    """One station held: the belt speed at which the snake neither climbs nor slides.

    number: from 1, unique in a session. lambda_rad: angle of every link to the direction of the
    belt, alternately left and right; 0 when straight. incline_rad: gamma as the inclinometer shows
    it. belt_speed_m_s: uphill, so that the snake faces and rolls downhill. drift_m_s: what was left
    of the snake's own motion, positive when carried along with the belt. voided: not to be used,
    for the reason in comment. time_utc: ISO 8601, empty if not recorded. Raises BadInput.
    """

    number: int
    lambda_rad: float
    incline_rad: float
    belt_speed_m_s: float
    drift_m_s: float = 0.0
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def __post_init__(self) -> None:
        check_number("number", self.number, 1)
        check_number("lambda_rad", self.lambda_rad, 0.0, math.radians(MAX_LAMBDA_DEG))
        incline_limit = math.radians(MAX_INCLINE_DEG)
        check_number("incline_rad", self.incline_rad, 0.0, incline_limit, open_low=True)
        check_number("belt_speed_m_s", self.belt_speed_m_s, 0.0, MAX_SPEED_M_S)
        check_number("drift_m_s", self.drift_m_s, -MAX_SPEED_M_S, MAX_SPEED_M_S)
        if not self.voided and self.slip_speed_m_s <= 0.0:
            raise BadInput(
                f"belt_speed_m_s - drift_m_s is {self.slip_speed_m_s:g} in reading {self.number}; "
                "it must be more than 0, since wheels at rest hold any force up to their static "
                "friction; void the reading or correct it"
            )

    @property
    def slip_speed_m_s(self) -> float:
        """Return the speed of the belt past the snake, v_rel = v_belt - v_drift."""
        return self.belt_speed_m_s - self.drift_m_s


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """What the instruments may be off by, as standard deviations.

    incline_sigma_rad: of one reading of the inclinometer. incline_zero_sigma_rad: of its zero,
    common to the session. belt_speed_sigma_m_s: of one belt speed past the snake.
    lambda_sigma_rad: of the bend, common to all bent readings. Raises BadInput.
    """

    incline_sigma_rad: float
    incline_zero_sigma_rad: float
    belt_speed_sigma_m_s: float
    lambda_sigma_rad: float

    def __post_init__(self) -> None:
        for name in ("incline_sigma_rad", "belt_speed_sigma_m_s"):
            check_number(name, getattr(self, name), 0.0, open_low=True)
        for name in ("incline_zero_sigma_rad", "lambda_sigma_rad"):
            check_number(name, getattr(self, name), 0.0)


@dataclass(frozen=True, slots=True)
class Procedure:
    """Which stations are to be held: every bend, from the first incline up to the top speed."""

    lambda_rad: tuple[float, ...]
    incline_start_rad: float
    incline_step_rad: float
    belt_speed_max_m_s: float
    gravity_m_s2: float


@dataclass(frozen=True, slots=True)
class Setup:
    """All of a session but its readings; two sessions may be joined only if theirs are equal.

    kind: measured, regenerated (from published fits) or simulated. source, note: where the
    readings come from, in words.
    """

    name: str
    kind: str
    source: str
    note: str
    robot: Robot
    procedure: Procedure
    uncertainty: Uncertainty

    @property
    def weight_n(self) -> float:
        """Return the weight of the whole snake, the m g of Eqs. 58 and 60."""
        return self.robot.links * self.robot.link_mass_kg * self.procedure.gravity_m_s2


@dataclass(frozen=True, slots=True)
class Session:
    """A set-up and its readings in the order they were taken, voided ones among them.

    where: what errors call it, the readings' file if there is one.
    """

    setup: Setup
    readings: tuple[Reading, ...]
    where: str = "session"

    @property
    def kept(self) -> tuple[Reading, ...]:
        """Return the readings that were not voided."""
        return tuple(r for r in self.readings if not r.voided)


def load_session(folder: str | Path) -> Session:
    """Read a session's folder: session.toml and readings.csv.

    Raises BadInput, naming file, line, value and allowed range, for anything that is missing,
    unknown, in other units, out of range or of a newer format, and for no reading to use.
    """
    setup = load_setup(folder)
    path = Path(folder) / "readings.csv"
    session = Session(setup, _load_readings(path), str(path))
    if not session.kept:
        raise BadInput(f"{path}: no reading to use among {len(session.readings)}; take some")
    return session


def load_setup(folder: str | Path) -> Setup:
    """Read a session's session.toml alone; raises BadInput as load_session does."""
    top = Table.load(Path(folder) / "session.toml")
    top.check_format(FORMAT)
    top.only("format", "name", "provenance", "robot", "procedure", "uncertainty")
    provenance = top.table("provenance")
    provenance.only("kind", "source", "note")
    with located(provenance.where("kind")):
        kind = check_choice("kind", provenance.values["kind"], KINDS)
    return Setup(
        name=top.string("name"),
        kind=kind,
        source=provenance.string("source"),
        note=provenance.string("note"),
        robot=_robot(top.table("robot")),
        procedure=_procedure(top.table("procedure")),
        uncertainty=_uncertainty(top.table("uncertainty")),
    )


def _robot(table: Table) -> Robot:
    table.only("links", "link_mass_kg", "link_length_m")
    links = table.whole("links")
    mass_kg = table.number("link_mass_kg", 0.0, open_low=True)
    length_m = table.number("link_length_m", 0.0, open_low=True)
    with located(table.where("links")):
        return Robot(links, mass_kg, length_m)


def _procedure(table: Table) -> Procedure:
    table.only(
        "lambda_deg", "incline_start_deg", "incline_step_deg", "belt_speed_max_m_s", "gravity_m_s2"
    )
    start_deg = table.number("incline_start_deg", 0.0, MAX_INCLINE_DEG, open_low=True)
    step_deg = table.number("incline_step_deg", 0.0, MAX_INCLINE_DEG, open_low=True)
    return Procedure(
        lambda_rad=tuple(map(math.radians, table.numbers("lambda_deg", 0.0, MAX_LAMBDA_DEG))),
        incline_start_rad=math.radians(start_deg),
        incline_step_rad=math.radians(step_deg),
        belt_speed_max_m_s=table.number("belt_speed_max_m_s", 0.0, MAX_SPEED_M_S, open_low=True),
        gravity_m_s2=table.number("gravity_m_s2", 0.0, MAX_GRAVITY_M_S2, open_low=True),
    )


def _uncertainty(table: Table) -> Uncertainty:
    table.only(
        "incline_sigma_deg", "incline_zero_sigma_deg", "belt_speed_sigma_m_s", "lambda_sigma_deg"
    )
    incline_deg = table.number("incline_sigma_deg", 0.0, MAX_INCLINE_DEG, open_low=True)
    zero_deg = table.number("incline_zero_sigma_deg", 0.0, MAX_INCLINE_DEG)
    return Uncertainty(
        incline_sigma_rad=math.radians(incline_deg),
        incline_zero_sigma_rad=math.radians(zero_deg),
        belt_speed_sigma_m_s=table.number(
            "belt_speed_sigma_m_s", 0.0, MAX_SPEED_M_S, open_low=True
        ),
        lambda_sigma_rad=math.radians(table.number("lambda_sigma_deg", 0.0, MAX_LAMBDA_DEG)),
    )


def _load_readings(path: Path) -> tuple[Reading, ...]:
    rows = csv.reader(io.StringIO(read_text(path), newline=""), strict=True)
    found: dict[int, Reading] = {}
    try:
        header = next(rows, [])
        check_names(header, COLUMNS, f"{path}:1", "column")
        for cells in rows:
            with located(f"{path}:{rows.line_num}"):
                reading = _reading(header, cells)
                _check_repeat(found.get(reading.number), reading)
            found[reading.number] = reading
    except csv.Error as error:
        raise BadInput(f"{path}:{rows.line_num}: not CSV: {error}") from error
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
        lambda_rad=math.radians(_cell(row, "lambda_deg", 0.0, MAX_LAMBDA_DEG)),
        incline_rad=math.radians(_cell(row, "incline_deg", 0.0, MAX_INCLINE_DEG, open_low=True)),
        belt_speed_m_s=_cell(row, "belt_speed_m_s", 0.0, MAX_SPEED_M_S),
        drift_m_s=_cell(row, "drift_m_s", -MAX_SPEED_M_S, MAX_SPEED_M_S),
        voided=check_choice("status", row["status"], STATUSES) == "void",
        comment=row["comment"],
        time_utc=_time(row["time_utc"]),
    )


def _cell(row: dict[str, str], name: str, *limits: float, open_low: bool = False) -> float:
    value: object = row[name]
    with suppress(ValueError):  # check_number then says what is there instead of a number
        value = float(row[name])
    return check_number(name, value, *limits, open_low=open_low)


def _time(text: str) -> str:
    try:
        if text:
            datetime.fromisoformat(text.removesuffix("Z"))
    except ValueError:
        raise BadInput(f"time_utc is {text!r}; it must be ISO 8601 or empty") from None
    return text


def _check_repeat(earlier: Reading | None, later: Reading) -> None:
    """Let a row repeat an earlier one only to void it: the file is appended to, never rewritten."""
    if earlier is None:
        return

    def measured(r: Reading) -> tuple[float, ...]:
        return r.lambda_rad, r.incline_rad, r.belt_speed_m_s, r.drift_m_s

    if earlier.voided or not later.voided or measured(earlier) != measured(later):
        raise BadInput(
            f"reading {later.number} is there already; a row may repeat it only to void it, once, "
            "with the same values; give a new reading a new number"
        )
