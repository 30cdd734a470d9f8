"""The one way to a terminal: what comes from files, boards and users is text, never a command.

A bar shows long work where somebody looks; elsewhere not even its library is loaded.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from ..base.files import visible

if TYPE_CHECKING:
    from rich.console import Console


def say(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print a text to standard output, or to standard error, with its control characters shown."""
    click.echo(visible(str(text)), err=err, nl=nl)


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


# What makes rich take a file or a pipe for a terminal.
_FORCED = ("FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE")


def _watched() -> bool:
    """Return whether standard error is a terminal, or is to be taken for one."""
    return sys.stderr.isatty() or any(os.environ.get(name) for name in _FORCED)


@contextmanager
def working(what: str) -> Iterator[Callable[[float], object]]:
    """Show on standard error that work goes on; gives a function that takes the share done of it.

    The share, 0 to 1, is shown where a long part of the work knows it.
    """
    if not _watched():
        yield lambda share: None
        return
    with screen(stderr=True).status(what) as status:
        yield lambda share: status.update(f"{what}, {100 * share:.0f} %")


@contextmanager
def progress(total: float, what: str, so_far: bool = False) -> Iterator[Callable[[float], None]]:
    """Show a bar on standard error; gives a function that takes what was just done.

    so_far: it takes all that is done by then.
    """
    if not _watched():
        yield lambda done: None
        return
    from rich import progress as bars

    errors = screen(stderr=True)
    with bars.Progress(console=errors, transient=True, disable=not errors.is_terminal) as bar:
        task = bar.add_task(what, total=total)
        if so_far:
            yield lambda done: bar.update(task, completed=done)
        else:
            yield lambda done: bar.advance(task, done)
