"""Calls that take long: in several threads, which end where nobody waits any more."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from typing import Any, TypeVar

from .checks import check_whole

Progress = Callable[[int], object]
Item = TypeVar("Item")
Value = TypeVar("Value")
_stops: ContextVar[tuple[threading.Event, ...]] = ContextVar("_stops", default=())


def stoppable(work: Callable[..., Value], stop: threading.Event) -> Callable[..., Value]:
    """Return the work for another thread, in which `keep_running` raises once `stop` is set."""
    stops = (*_stops.get(), stop)

    def run(*items: Any) -> Value:
        _stops.set(stops)
        keep_running()
        return work(*items)

    return run


def keep_running() -> None:
    """Raise KeyboardInterrupt in a thread whose result nobody waits for any more."""
    if any(stop.is_set() for stop in _stops.get()):
        raise KeyboardInterrupt


def threads_to_use(threads: int | None = None) -> int:
    """Return the number of threads: as many as there are processors unless given."""
    if threads is None:
        if hasattr(os, "sched_getaffinity"):
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1
    return check_whole("threads", threads, 1, 1024)


def in_threads(
    work: Callable[[Item], Value],
    items: Iterable[Item],
    progress: Progress | None = None,
    threads: int | None = None,
) -> list[Value]:
    """Return what each item gives. progress: called with 1 after each; may raise to stop.

    An exception, Ctrl-C too, ends the work in hand where that calls `keep_running`.
    """
    from concurrent.futures import ThreadPoolExecutor  # slow to import

    values, stop = [], threading.Event()
    with ThreadPoolExecutor(threads_to_use(threads)) as pool:
        try:
            for value in pool.map(stoppable(work, stop), items):
                values.append(value)
                if progress is not None:
                    progress(1)
        except BaseException:
            stop.set()
            raise
    return values
