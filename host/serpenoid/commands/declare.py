"""How commands declare their options: types, `--set NAME=VALUE`, and help in two parts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from inspect import signature
from itertools import chain
from pathlib import Path
from typing import Any

import click

from ..base.checks import Limits, check_number, range_in_words
from ..base.errors import BadInput
from ..base.toml_table import check_names
from ..show.screen import say

Option = Callable[[Any], Any]
Values = dict[str, Any]  # values by name: of options, settings, or a result


class ResearchOption(click.Option):
    """An option that a builder does not need."""


OPTIONS: dict[str, list[click.Parameter]] = {}  # shared options, by the parameter that they fill


class Command(click.Command):
    """A command whose function gets its values from options.

    A parameter that none of the command's own options fills has its options in OPTIONS. The help
    lists the options for researchers apart.
    """

    def __init__(
        self, *args: Any, callback: Callable[..., Any], params: list[click.Parameter], **how: Any
    ) -> None:
        names = {param.name for param in params}
        rows = (
            OPTIONS.get(name, []) for name in signature(callback).parameters if name not in names
        )
        answering = "verbose", "as_json"  # parameters whose options stand last in the help
        params = sorted([*chain(*rows), *params], key=lambda param: param.name in answering)
        super().__init__(*args, callback=callback, params=params, **how)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options of builders, then those of researchers."""
        options = [param for param in self.get_params(ctx) if isinstance(param, click.Option)]
        for title, for_research in (("Options", False), ("For researchers", True)):
            shown = [p for p in options if isinstance(p, ResearchOption) == for_research]
            records = [record for p in shown if (record := p.get_help_record(ctx)) is not None]
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


command = partial(click.command, cls=Command)


def option(
    *names_and_help: str, choice: Iterable[str] = (), research: bool = False, **how: Any
) -> Option:
    """Return an option of a command; the last text is its help.

    choice: the words that it may take; empty for any. research: help lists it for researchers. how:
    arguments of `click.option`; a default is shown unless it is 0 or empty.
    """
    *names, words = names_and_help
    if choice:
        how["type"] = click.Choice(list(choice))
    how.setdefault("show_default", bool(how.get("default")))
    return click.option(*names, help=words, cls=ResearchOption if research else None, **how)


flag = partial(option, is_flag=True)
number = partial(option, type=float)


def row(parameter: str, *options: Option) -> None:
    """Add the options to OPTIONS that fill a parameter of this name in every command."""
    OPTIONS[parameter] = list(chain(*(add(lambda: None).__click_params__ for add in options)))


def parsed_number(name: str, text: str) -> float:
    """Return a typed number, a whole one as an int. Raises BadInput for one with a unit."""
    try:
        number = float(text)
    except ValueError:
        raise BadInput(
            f"{name} is {text!r}; type a number without its unit and with a decimal point, "
            "such as 0.5"
        ) from None
    return int(number) if number.is_integer() else number


def plain_text(_name: str, text: str) -> str:
    """Return a typed text as it is."""
    return text


@dataclass(frozen=True)
class Setting:
    """One name that `--set NAME=VALUE` takes.

    words: its meaning. limits: of its number. usual: its default, in words. read: function of the
    name and the typed text that returns the value.
    """

    name: str
    words: str
    unit: str = ""
    limits: Limits | None = None
    usual: str = ""
    read: Callable[[str, str], Any] = parsed_number

    def value(self, text: str) -> Any:
        """Return the value of a typed text. Raises BadInput, which names the setting."""
        value = self.read(self.name, text)
        if self.limits and isinstance(value, (int, float)):
            check_number(self.name, value, *self.limits)
        return value

    @property
    def help(self) -> tuple[str, str]:
        """Return the name, and meaning, unit, limits and default in words."""
        limits = (
            range_in_words(*self.limits).removeprefix("a finite number, ") if self.limits else ""
        )
        usual = f"default: {self.usual}" if self.usual else ""
        return self.name, "; ".join(filter(None, (self.words, self.unit, limits, usual)))


SETTINGS: dict[str, tuple[Setting, ...]] = {}  # what `--set` takes, by the name of a group


class SettingType(click.ParamType):
    """Type of NAME=VALUE for the settings of some groups; `help` lists them and ends the run."""

    name = "setting"

    def __init__(self, *groups: str) -> None:
        table = chain(*(SETTINGS[group] for group in groups))
        self.known = {setting.name: setting for setting in table}

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


def settings(*groups: str) -> Option:
    """Return the option `--set` for groups of SETTINGS; its value is a dictionary of settings."""
    return option(
        "--set",
        "settings",
        "Set a rarer number; may be repeated. `--set help` lists names, units, limits, defaults.",
        type=SettingType(*groups),
        metavar="NAME=VALUE",
        multiple=True,
        callback=lambda _context, _option, pairs: dict(pairs),
        is_eager=True,
    )


def group_settings(settings: Values, *groups: str) -> Values:
    """Return the given settings that belong to some groups of SETTINGS."""
    names = SettingType(*groups).known
    return {name: value for name, value in settings.items() if name in names}


def refuse_unused(settings: Values, why: str, *names: str) -> None:
    """Raise BadInput for settings that would change nothing, and say why."""
    if unused := " and ".join(name for name in names if name in settings):
        raise BadInput(f"--set {unused} would change nothing: {why}")


FOLDER = click.Path(file_okay=False, path_type=Path)
EXISTING = click.Path(exists=True, dir_okay=False, path_type=Path)


class OutFile(click.Path):
    """A file to be written, in an existing folder, but not one of a session's own files."""

    name = "file"

    def __init__(self, *suffixes: str) -> None:
        super().__init__(dir_okay=False, writable=True, path_type=Path)
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path. Raises click.BadParameter before any work."""
        path = Path(str(super().convert(value, param, ctx)))
        folder = path.parent
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            self.fail(f"{value!r} must end in {' or '.join(self.suffixes)}", param, ctx)
        if not (folder.is_dir() and os.access(folder, os.W_OK)):
            self.fail(f"{str(folder)!r} is no folder that may be written to", param, ctx)
        files = "session.toml", "readings.csv", "events.csv", "fit.json"
        if path.name in files and (folder / "session.toml").exists():
            self.fail(f"{value!r} is a session's own; take another name or folder", param, ctx)
        return path


def directory(value: str | Path) -> Path:
    """Return a folder to be filled, which is made if it is not there. Raises OSError."""
    path = Path(value)
    path.mkdir(parents=True, exist_ok=True)
    return path
