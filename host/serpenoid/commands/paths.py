"""Paths to write to, checked when the command line is read, before any work."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import click

_SESSION = ("session.toml", "readings.csv", "events.csv", "fit.json")
FIGURES = (".png", ".pdf", ".svg")


FOLDER = click.Path(file_okay=False, path_type=Path)
EXISTING = click.Path(exists=True, dir_okay=False, path_type=Path)


def out_file(*suffixes: str) -> Callable[[str | Path], Path]:
    """Return the type of a file to be written: its folder is there, its suffix one of those."""

    def file(value: str | Path) -> Path:
        path = Path(value)
        _refuse(_wrong(path, suffixes))
        return path

    return file


def _refuse(reason: str | None) -> None:
    if reason:
        raise click.BadParameter(reason)


def _wrong(path: Path, suffixes: tuple[str, ...]) -> str | None:
    if suffixes and path.suffix.lower() not in suffixes:
        return f"{str(path)!r} must end in {' or '.join(suffixes)}"
    if path.is_dir():
        return f"{str(path)!r} is a folder; name a file in it"
    if (own := _of_a_session(path)) is not None:
        return f"{str(own)!r} holds a session's readings or set-up; take another name or folder"
    if path.exists():
        return None if os.access(path, os.W_OK) else f"{str(path)!r} may not be written to"
    return _no_place(path.parent)


def _of_a_session(path: Path) -> Path | None:
    """Return the session's own file that writing there, or data beside it, would destroy."""
    if not (path.parent / "session.toml").exists():
        return None
    beside = path.with_suffix(".csv") if path.suffix.lower() in FIGURES else path
    return next((own for own in (path, beside) if own.name in _SESSION and own.exists()), None)


def directory(value: str | Path) -> Path:
    """Return a folder to be filled: it is there and may be written to, or can be made."""
    path = there = Path(value)
    while not there.exists():
        there = there.parent
    _refuse(_no_place(there))
    return path


def _no_place(folder: Path) -> str | None:
    """Say why no file can be made in a folder, if so."""
    if not folder.exists():
        return f"the folder {str(folder)!r} is not there; make it first"
    if not folder.is_dir():
        return f"{str(folder)!r} is a file, not a folder"
    return None if os.access(folder, os.W_OK) else f"{str(folder)!r} may not be written to"
