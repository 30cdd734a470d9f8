"""The one way to a terminal: what comes from files, boards and users is text, never a command.

Long work is shown to who watches a terminal; elsewhere not even the library for it is loaded.
"""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
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


REPORT_S = 5.0  # Time between two lines on long work where nobody watches.


@contextmanager
def working(what: str) -> Iterator[Callable[[float], object]]:
    """Show on standard error that work goes on; gives a function that takes the share done of it.

    Where standard error is no terminal, a line tells the share, or the time, every five seconds.
    """
    if sys.stderr.isatty():
        with screen(stderr=True).status(what) as status:
            yield lambda share: status.update(f"{what}, {100 * share:.0f} %")
        return
    began_s, shares, ended = time.monotonic(), deque([0.0], 1), threading.Event()

    def report() -> None:
        while not ended.wait(REPORT_S):
            done = (
                f"{100 * shares[-1]:.0f} %" if shares[-1] else f"{time.monotonic() - began_s:.0f} s"
            )
            say(f"{what}, {done}", err=True)

    threading.Thread(target=report, daemon=True).start()
    try:
        yield shares.append
    finally:
        ended.set()
