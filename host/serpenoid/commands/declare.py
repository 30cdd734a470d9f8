"""How commands declare their options, and refuse those that would do nothing."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import click

from ..base.checks import check_number

Option = Callable[[Any], Any]
Given = dict[str, Any]  # values of options, or an answer


def option(*names_and_help: str, choice: Iterable[str] = (), **how: Any) -> Option:
    """Return an option of a command; the last text is its help.

    choice: the words that it takes, if only some do. how: as for `click.option`; a default is shown
    unless it is 0 or empty.
    """
    *names, words = names_and_help
    if choice:
        how["type"] = click.Choice(list(choice))
    how.setdefault("show_default", bool(how.get("default")))
    return click.option(*names, help=words, **how)


def number(*names_and_help: str, **how: Any) -> Option:
    """Return an option that takes a number."""
    return option(*names_and_help, type=float, **how)


class Range(click.FloatRange):
    """A number within limits; NaN is within none, though no comparison says so."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail("nan is not a number", param, ctx)
        return number


def angle(
    *names_and_help: str, low: float = 0.0, high: float, open_low: bool = False, **how: Any
) -> Option:
    """Return an option that takes degrees, and gives radians to the field of its name.

    low, high: degrees; low itself is refused if open_low. A high of inf may be typed: no limit.
    """
    first, *names, words = names_and_help
    field = names or [first.strip("-").replace("-", "_").replace("_deg", "_rad")]

    def callback(_ctx: click.Context, _option: click.Parameter, degrees: float | None) -> Any:
        if degrees is None or degrees == high == math.inf:
            return degrees
        return radians(first, degrees, low, high, open_low)

    return number(first, *field, words, callback=callback, **how)


def radians(name: str, degrees: float, low: float, high: float, open_low: bool = False) -> float:
    """Return an angle in radians; what is out of range is told in degrees."""
    return math.radians(check_number(name, degrees, low, high, open_low=open_low))


def flag(*names_and_help: str, **how: Any) -> Option:
    """Return an option that stands alone."""
    return option(*names_and_help, is_flag=True, **how)


def refuse_typed(words: str, *names: str) -> None:
    """Raise UsageError for an option of this command that was typed, and would do nothing.

    words: of the error, with {} for the option. names: of the options' values.
    """
    context = click.get_current_context()
    typed = click.core.ParameterSource.COMMANDLINE
    for parameter in context.command.params:
        name = parameter.name or ""
        given = name in names and context.get_parameter_source(name) is typed
        if given and context.params[name] is not False:
            raise click.UsageError(words.format(parameter.opts[0]))


class Options:
    """Options that go together, stored under the names of the fields that they fill.

    It adds them to a command in the order given, and takes their values out of the command's.
    """

    def __init__(self, *options: Option) -> None:
        self._options = options

    def __call__(self, command: Callable[..., Any]) -> Callable[..., Any]:
        """Add the options to a command."""
        for one in reversed(self._options):
            command = one(command)
        return command

    @property
    def names(self) -> list[str]:
        """Return the fields."""
        return [parameter.name or "" for parameter in click.command(self(lambda: None)).params]

    def take(self, given: Given) -> Given:
        """Take the values of these options out of `given`; return those that were given."""
        taken = {name: given.pop(name) for name in self.names}
        return {name: value for name, value in taken.items() if value is not None}


_SESSION = ("session.toml", "readings.csv", "events.csv", "fit.json")
FIGURES = (".png", ".pdf", ".svg")


class PathType(click.Path):
    """A file or a folder; an empty name is none, where Python takes it for the current folder."""

    def __init__(self, **limits: bool) -> None:
        super().__init__(**limits, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        _refuse(None if str(value) else NO_NAME)
        return super().convert(value, param, ctx)


NO_NAME = "the name is empty; '.' is the current folder"
FOLDER = PathType(file_okay=False)
EXISTING = PathType(exists=True, dir_okay=False)


def out_file(*suffixes: str) -> Callable[[str | Path], Path]:
    """Return the type of a file to be written: its folder is there, its suffix one of those."""

    def file(value: str | Path) -> Path:
        path = Path(value)
        _refuse(_wrong(path, suffixes) if str(value) else NO_NAME)
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
    """Return the session's own file that writing there would destroy."""
    in_session = (path.parent / "session.toml").exists()
    return path if in_session and path.name in _SESSION and path.exists() else None


def directory(value: str | Path) -> Path:
    """Return a folder to be filled: it is there and may be written to, or can be made."""
    _refuse(None if str(value) else NO_NAME)
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
