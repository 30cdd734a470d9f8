"""The calibration session on disk, read strictly: session.toml says how, readings.csv what.

A folder's files speak degrees, as people type them; the session that is made of them speaks SI.
Format 1 has one file of stations; format 2 (session_rows) has readings of every kind and events.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from ..model.checks import check_choice
from ..model.errors import BadInput
from ..model.toml_table import Table, located
from .kinds.rows import make_reading
from .kinds.station import Reading
from .session import Session, Setup
from .session_rows import read_format_2, rows_in, time_of, whole_number
from .settings import FORMAT, setup_in

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
    if not (session.kept or session.on_floor or session.kept_crawls):
        raise BadInput(
            f"{session.where}: no reading to use among {len(session.readings)}; take some"
        )
    return session


def read_session(folder: str | Path) -> Session:
    """Read a session's folder as load_session does, one that has no readings yet, too."""
    folder = Path(folder)
    top = _load_toml(folder)
    read = _read_format_1 if top.whole("format") == 1 else read_format_2
    return read(setup_in(top), folder)


def load_setup(folder: str | Path) -> Setup:
    """Read a session's session.toml alone; raises BadInput as load_session does."""
    return setup_in(_load_toml(folder))


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


def _read_format_1(setup: Setup, folder: Path) -> Session:
    """Return a session of stations; a row may repeat one only to void it."""
    path = folder / "readings.csv"
    readings: dict[int, Reading] = {}
    for row in rows_in(path, COLUMNS, optional=("facing",)):
        with located(row["where"]):
            number = whole_number("reading", row["reading"])
            common: dict[str, Any] = {
                "number": number,
                "voided": check_choice("status", row["status"], ("kept", "void")) == "void",
                "comment": row["comment"],
                "time_utc": time_of(row["time_utc"]),
            }
            reading = make_reading({**row, "kind": "station", "more": ""}, common)
            earlier = readings.get(number)
            voided = earlier and replace(earlier, **(common | {"voided": True}))
            if earlier and (earlier.voided or voided != reading):
                raise BadInput(
                    f"reading {number} is there already; a row may repeat it only to void it, "
                    "once, with the same values; give a new reading a new number"
                )
            readings[number] = reading
    return Session(setup, tuple(readings.values()), str(path), folder=folder)
