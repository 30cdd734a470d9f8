"""Paths to write to, checked when the command line is read, before any work."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

_SESSION = ("session.toml", "readings.csv", "events.csv", "fit.json")
FIGURES = (".png", ".pdf", ".svg")


class OutFile(click.ParamType):
    """A file to be written: its folder is there, its suffix is one of those given."""

    name = "file"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path, or fail with the reason why nothing could be written there."""
        path = Path(value)
        if reason := self._wrong(path):
            self.fail(reason, param, ctx)
        return path

    def _wrong(self, path: Path) -> str | None:
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            return f"{str(path)!r} must end in {' or '.join(self.suffixes)}"
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


class OutFolder(click.ParamType):
    """A folder to be filled: it is there and may be written to, or can be made."""

    name = "directory"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path, or fail with the reason why nothing could be written there."""
        path = Path(value)
        there = path
        while not there.exists():
            there = there.parent
        if reason := _no_place(there):
            self.fail(reason, param, ctx)
        return path


def _no_place(folder: Path) -> str | None:
    """Say why no file can be made in a folder, if so."""
    if not folder.exists():
        return f"the folder {str(folder)!r} is not there; make it first"
    if not folder.is_dir():
        return f"{str(folder)!r} is a file, not a folder"
    return None if os.access(folder, os.W_OK) else f"{str(folder)!r} may not be written to"
