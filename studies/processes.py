"""A pool of processes for studies."""

from __future__ import annotations

import multiprocessing
import signal
from concurrent.futures import ProcessPoolExecutor


def all_cores() -> ProcessPoolExecutor:
    """Return a pool of processes, one a core, that Ctrl-C ends without a word once they work."""
    spawn, silently = multiprocessing.get_context("spawn"), (signal.SIGINT, signal.SIG_DFL)
    return ProcessPoolExecutor(mp_context=spawn, initializer=signal.signal, initargs=silently)
