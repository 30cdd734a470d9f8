"""A bar for long work where a terminal shows it; elsewhere not even its library is loaded."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# What makes rich take a file or a pipe for a terminal.
_FORCED = ("FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE")


def _nothing(done: float) -> None:
    """Take what was done, and show nothing."""


def _seen() -> bool:
    """Return whether standard error is a terminal, or is to be taken for one."""
    return sys.stderr.isatty() or any(os.environ.get(name) for name in _FORCED)


@contextmanager
def working(what: str) -> Iterator[None]:
    """Show on standard error that work goes on whose end cannot be told."""
    if not _seen():
        yield
        return
    from .screen import screen

    with screen(stderr=True).status(what):
        yield


@contextmanager
def progress(total: float, what: str, so_far: bool = False) -> Iterator[Callable[[float], None]]:
    """Show a bar on standard error; gives a function that takes what was just done.

    so_far: it takes all that is done by then.
    """
    if not _seen():
        yield _nothing
        return
    from rich import progress as bars

    from .screen import screen

    errors = screen(stderr=True)
    columns = (
        bars.TextColumn("{task.description}"),
        bars.BarColumn(),
        bars.MofNCompleteColumn(),
        bars.TimeRemainingColumn(),
    )
    with bars.Progress(
        *columns, console=errors, transient=True, disable=not errors.is_terminal
    ) as bar:
        task = bar.add_task(what, total=total)
        if so_far:
            yield lambda done: bar.update(task, completed=done)
        else:
            yield lambda done: bar.advance(task, done)
