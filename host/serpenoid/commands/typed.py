"""Errors in the words of whoever typed them: options instead of the fields that they fill."""

from __future__ import annotations

import re
from typing import Any

import click

from ..model.errors import SerpenoidError

_FIELDS = {"link_mass_kg": "--mass-kg", "link_length_m": "--length-m",
           "link_inertia_kg_m2": "--inertia-kg-m2"}  # fmt: skip


def as_typed(text: str, options: dict[str, str]) -> str:
    """Return a message with the names of fields replaced by their options.

    A name of several words is meant wherever it stands, one of one word (links, ct) only where the
    message begins with `ct is`.
    """
    for field, option in options.items():
        if "_" in field:
            text = re.sub(rf"(?<![\w.-]){field}(?!\w)", option, text)
        else:
            text = re.sub(rf"^{field} is ", f"{option} is ", text)
    return text


def options_of(command: click.Command) -> dict[str, str]:
    """Return the options of a command by the fields that they fill."""
    names = {p.name: p.opts[0] for p in command.params if isinstance(p, click.Option) and p.name}
    typed = set(names.values())
    return names | {field: option for field, option in _FIELDS.items() if option in typed}


class TypedCommand(click.Command):
    """A command whose errors name what was typed."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; an error of the package comes out in the words of its options."""
        try:
            return super().invoke(ctx)
        except SerpenoidError as error:
            if error.args and isinstance(error.args[0], str):
                error.args = (as_typed(error.args[0], options_of(self)), *error.args[1:])
            raise
