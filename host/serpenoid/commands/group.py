"""What the command line says: help that is not cut, and errors in one line."""

from __future__ import annotations

import difflib
import itertools
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from ..base.errors import shortened
from .declare import Command

Sections = Mapping[str, Sequence[click.Command]]


class Commands(click.Group):
    """A group whose help tells the first sentence of every command, section by section.

    sections: its commands, unless they are added one by one. usual: the command that is meant where
    a file, a folder or an option stands first.
    """

    command_class = Command

    def __init__(
        self, *args: Any, sections: Sections | None = None, usual: str = "", **kwargs: Any
    ) -> None:
        super().__init__(*args, **kwargs)
        self.sections, self.usual = sections or {}, usual
        for command in itertools.chain(*self.sections.values()):
            self.add_command(command)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the usual command in; print the plain help where nothing is given.

        Of the latter versions of click differ.
        """
        if self.usual and args and args[0] not in (*self.commands, "-h", "--help"):
            matches = difflib.get_close_matches(args[0], self.commands, n=1)
            if matches and not Path(args[0]).suffix and not Path(args[0]).exists():
                raise click.UsageError(f"nothing is called {args[0]!r}; {matches[0]!r}?", ctx)
            args = [self.usual, *args]
        return super().parse_args(ctx, args or ["--help"])

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands, each with its first sentence."""
        ungrouped = {"Commands": [self.commands[name] for name in self.list_commands(ctx)]}
        for title, commands in (self.sections or ungrouped).items():
            with formatter.section(title):
                formatter.write_dl(
                    [(command.name or "", command.get_short_help_str(200)) for command in commands]
                )


def of_arguments(error: click.ClickException) -> str:
    """Return what click has against the arguments, as one line."""
    text = shortened(" ".join(error.format_message().split()))
    text = text.removeprefix("Invalid value for ").rstrip(".")
    ctx = getattr(error, "ctx", None)
    return f"{text}; see `{ctx.command_path} --help`" if ctx else text


def of_system(error: OSError) -> str:
    """Return what the system has against a file, as one line."""
    if isinstance(error, shutil.Error) and isinstance(error.args[0], list):
        return str(error.args[0][0][2])  # The first file of a tree that failed
    if error.strerror is None:
        return str(error)
    name = error.filename if isinstance(error.filename, (str, bytes)) else ""
    return ": ".join(filter(None, (shortened(os.fsdecode(name)), error.strerror.lower())))
