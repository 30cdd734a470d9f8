"""How commands declare their options: types, `--set NAME=VALUE`, and help in two parts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..base.checks import Limits, check_choice, check_number, check_whole, range_in_words
from ..base.errors import BadInput
from ..base.toml_table import check_names
from ..show.screen import say

Option = Callable[[Any], Any]
Given = dict[str, Any]  # values of options or settings by name, or an answer


class ResearchOption(click.Option):
    """An option that a builder does not need."""


class Command(click.Command):
    """A command whose help lists the options for researchers apart."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options of builders, then those of researchers."""
        for title, for_research in (("Options", False), ("For researchers", True)):
            parameters = self.get_params(ctx)
            shown = [p for p in parameters if isinstance(p, ResearchOption) == for_research]
            records = [record for p in shown if (record := p.get_help_record(ctx)) is not None]
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


def option(
    *names_and_help: str, choice: Iterable[str] = (), research: bool = False, **how: Any
) -> Option:
    """Return an option of a command; the last text is its help.

    choice: the words that it takes, if only some do. research: help lists it for researchers. how:
    as for `click.option`; a default is shown unless it is 0 or empty.
    """
    *names, words = names_and_help
    if choice:
        how["type"] = click.Choice(list(choice))
    how.setdefault("show_default", bool(how.get("default")))
    return click.option(*names, help=words, cls=ResearchOption if research else None, **how)


def flag(*names_and_help: str, **how: Any) -> Option:
    """Return an option that stands alone."""
    return option(*names_and_help, is_flag=True, **how)


def together(*options: Option) -> Option:
    """Return options that several commands have, in this order, as one."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        for one in reversed(options):
            command = one(command)
        return command

    return add


def parsed_number(name: str, text: str) -> float:
    """Return a typed number. Raises BadInput for a text that is none, such as one with a unit."""
    try:
        return float(text)
    except ValueError:
        raise BadInput(
            f"{name} is {text!r}; type a number without its unit and with a decimal point, "
            "such as 0.5"
        ) from None


class Number(click.ParamType):
    """A number, typed without a unit; of limits only where no function of Python checks them."""

    name = "number"

    def __init__(self, *limits: float, open_low: bool = False) -> None:
        self.limits = Limits(*limits, open_low=open_low) if limits else None

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number. Raises BadInput in the option's name."""
        name = param.opts[0] if param else "the number"
        number = parsed_number(name, value)
        return number if self.limits is None else _within(name, number, self.limits)


def _within(name: str, number: float, limits: Limits) -> float:
    low, high, open_low = limits
    return check_number(name, number, low, high, open_low=open_low)


def number(*names_and_help: str, **how: Any) -> Option:
    """Return an option that takes a number."""
    return option(*names_and_help, **{"type": Number(), **how})


@dataclass(frozen=True)
class Setting:
    """One name that `--set NAME=VALUE` takes.

    limits: a number's range, or the words that it may be. usual: its default, in words.
    is_whole: it is a whole number. read: makes its value of the name and the typed text, in place
    of a number.
    """

    name: str
    words: str
    unit: str = ""
    limits: Limits | tuple[str, ...] | None = None
    usual: str = ""
    is_whole: bool = False
    read: Callable[[str, str], Any] | None = None

    def value(self, text: str) -> Any:
        """Return the value of a typed text. Raises BadInput in the setting's name."""
        if self.read is not None:
            return self.read(self.name, text)
        if self.limits is not None and not isinstance(self.limits, Limits):
            return check_choice(self.name, text, self.limits)
        number = parsed_number(self.name, text)
        if not self.is_whole:
            return number if self.limits is None else _within(self.name, number, self.limits)
        low, high = (self.limits or Limits(0.0))[:2]
        rounded = int(number) if number.is_integer() else number
        return check_whole(
            self.name, rounded, int(low), None if high == float("inf") else int(high)
        )

    @property
    def help(self) -> tuple[str, str]:
        """Return the name, and meaning, unit, limits and default in words."""
        limits = ""
        if isinstance(self.limits, Limits):
            limits = range_in_words(*self.limits).removeprefix("a finite number, ")
        elif self.limits:
            limits = ", ".join(self.limits)
        usual = f"default: {self.usual}" if self.usual else ""
        return self.name, "; ".join(filter(None, (self.words, self.unit, limits, usual)))


class SettingType(click.ParamType):
    """NAME=VALUE of one of the settings `known`; `help` lists them and ends the command."""

    name = "setting"

    def __init__(self, *known: Setting) -> None:
        self.known = {setting.name: setting for setting in known}

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return name and value. Raises BadInput for what is unknown or out of limits."""
        if value == "help" and ctx is not None:
            formatter = click.HelpFormatter(max_width=100)
            formatter.write_dl([setting.help for setting in self.known.values()])
            say(formatter.getvalue(), nl=False)
            ctx.exit()
        name, equals, text = value.partition("=")
        if not equals:
            raise BadInput(f"--set {value!r} is not of the form NAME=VALUE; see --set help")
        check_names([name], (), "--set", "name", tuple(self.known))
        return name, self.known[name].value(text)


def settings(*known: Setting) -> Option:
    """Return the option `--set`, whose value has what was given by name."""
    return option(
        "--set",
        "settings",
        "A rarer number, one for each --set; `--set help` lists names, units, defaults and limits.",
        type=SettingType(*known),
        metavar="NAME=VALUE",
        multiple=True,
        callback=lambda _context, _option, pairs: dict(pairs),
        is_eager=True,
    )


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
