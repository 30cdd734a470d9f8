"""How commands declare their options, and refuse those that would do nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import click

from ..model.checks import check_number

Option = Callable[[Any], Any]


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

    def take(self, given: dict[str, Any]) -> dict[str, Any]:
        """Take the values of these options out of `given`; return those that were given."""
        taken = {name: given.pop(name) for name in self.names}
        return {name: value for name, value in taken.items() if value is not None}
