"""A bar for long work where a terminal shows it; elsewhere not even its library is loaded."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# What makes rich take a file or a pipe for a terminal.
_FORCED = ("FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE")


def _nothing(done: int) -> None:
    """Take the number just done, and show nothing."""


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
def progress(total: int, what: str) -> Iterator[Callable[[int], None]]:
    """Show a bar on standard error; gives a function that takes the number just done."""
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
        yield lambda done: bar.advance(task, done)
