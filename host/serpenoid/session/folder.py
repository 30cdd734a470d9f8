"""The calibration session on disk, read strictly: session.toml says how, readings.csv what.

A folder's files speak degrees, as people type them; the session that is made of them speaks SI.
Readings of every kind and events are rows of two tables (session_rows).
"""

from __future__ import annotations

from pathlib import Path

from ..base.errors import BadInput
from ..base.toml_table import Table
from .rows import read_rows
from .session import Session, Setup
from .settings import FORMAT, setup_in


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
    return read_rows(setup_in(_load_toml(folder)), folder)


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
    if top.whole("format") < FORMAT:
        raise BadInput(
            f"{top.where('format')}: format is {top.whole('format')}, which held stations alone, "
            f"and is not read; calibration_data/README.md says what format {FORMAT} has"
        )
    return top
