"""How commands declare their options, and refuse those that would do nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import click

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


def stacked(*options: Option) -> Option:
    """Return one decorator that adds options to a command in the order given."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        for one in reversed(options):
            command = one(command)
        return command

    return add
