"""The one way to a terminal: what comes from files, boards and users is text, never a command."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

from ..model.files import visible

if TYPE_CHECKING:
    from rich.console import Console


def say(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print a text to standard output, or to standard error, with its control characters shown."""
    click.echo(visible(str(text)), err=err, nl=nl)


def at_terminal() -> bool:
    """Tell whether a person sees standard output; a picture is no use to a program."""
    return sys.stdout is not None and sys.stdout.isatty()  # it may be closed


def screen(**options: Any) -> Console:
    """Return a rich console that shows text as it is: no markup, no emoji, no control codes."""
    from rich.console import Console
    from rich.segment import Segment

    class Screen(Console):
        def render(self, renderable: Any, options: Any = None) -> Iterable[Segment]:
            for part in super().render(renderable, options):
                safe = part if part.control else Segment(visible(part.text), part.style)
                yield safe

    return Screen(markup=False, emoji=False, **options)
