"""The calibration session on disk, read strictly: session.toml says how, readings.csv what.

A folder's files speak degrees, as people type them; the session that is made of them speaks SI.
Format 1 has one file of stations; format 2 (session_rows) has readings of every kind and events.
"""

from __future__ import annotations

from pathlib import Path

from ..model.checks import check_choice
from ..model.errors import BadInput
from ..model.files import csv_rows, read_text
from ..model.robot import Robot
from ..model.toml_table import Table, check_names, located
from .kinds.instruments import Uncertainty
from .kinds.station import Reading
from .session import Procedure, Session, Setup
from .session_rows import read_format_2, time_of, whole_number
from .settings import GRAVITY, SETTINGS, Setting, applied, changed

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
_BLANK = Setup(
    "",
    "",
    "",
    "",
    Robot(2, 1.0, 1.0),
    Procedure((), 0.0, 0.0, 0.0, 0.0),
    Uncertainty(1.0, 1.0, 1.0, 1.0),
)


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
    return read_format_2(setup, folder)


def load_setup(folder: str | Path) -> Setup:
    """Read a session's session.toml alone; raises BadInput as load_session does."""
    return _setup(_load_toml(folder))


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
    tables = SETTINGS
    said = ("format", "name")
    if top.whole("format") == 1:
        tables = _tables_of_format_1()
    else:
        said += ("program", "created_utc")
    top.only(*said, *tables)
    setup = changed(_BLANK, {"name": top.string("name")})
    for name, settings in tables.items():
        table = top.table(name)
        needed = [s.key for s in settings if s.needed]
        table.only(*needed, optional=tuple(s.key for s in settings if not s.needed))
        setup = applied(setup, table, settings)
    return setup


def _tables_of_format_1() -> dict[str, tuple[Setting, ...]]:
    needed = {name: tuple(s for s in rows if s.needed) for name, rows in SETTINGS.items()}
    return {
        "provenance": SETTINGS["provenance"],
        "robot": SETTINGS["robot"],
        "procedure": (*needed["plan"], GRAVITY),
        "uncertainty": needed["instruments"],
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
    return Reading(
        number=whole_number("reading", row["reading"]),
        voided=check_choice("status", row["status"], STATUSES) == "void",
        comment=row["comment"],
        time_utc=time_of(row["time_utc"]),
        **{f.name: f.read(row.get(f.column, "")) for f in Reading.fields},  # type: ignore[arg-type]
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
