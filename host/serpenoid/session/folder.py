"""The calibration session on disk, read strictly: session.toml says how, readings.csv what.

A folder's files speak degrees, as people type them; the session that is made of them speaks SI.
Readings of every kind and events are rows of two tables (session_rows).
"""

from __future__ import annotations

from pathlib import Path

from ..base.errors import BadInput
from ..base.toml_table import Table
from .rows import read_events, session_of
from .session import Session
from .settings import FORMAT, Setup, amended


def load_session(folder: str | Path) -> Session:
    """Read a session's folder.

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
    >>> len(session.kept_stations)
    11
    """
    session = read_session(folder)
    if not (session.kept_stations or session.on_floor or session.kept_crawls):
        raise BadInput(
            f"{session.where}: no reading to use among {len(session.readings)}; take some"
        )
    return session


def read_session(folder: str | Path) -> Session:
    """Read a session's folder as load_session does, one that has no readings yet, too."""
    folder, notes = Path(folder), list[str]()
    top = Table.load(check_session(folder))
    top.check_format(
        FORMAT,
        "which held stations alone, and is not read; calibration_data/README.md says what format "
        f"{FORMAT} has",
    )
    events = read_events(folder, notes)
    details = [event.detail for event in events if event.event == "amend"]
    setup = Setup.read(amended(top, details, folder / "events.csv"))
    return session_of(setup, events, folder, notes)


def check_session(folder: Path) -> Path:
    """Return the path of a session's settings; raises BadInput where there is no session."""
    path = folder / "session.toml"
    if not path.exists():
        raise BadInput(
            f"{folder}: no session here (no session.toml); `serpenoid calibrate new {folder}` "
            "begins one"
        )
    return path
