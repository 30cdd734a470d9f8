"""Run work in a child process under a time limit: a hang or a crash becomes an answer.

The limit is of processor time, so that other load on the machine fells nobody: a timer whose signal
ends the child, compiled code or not. A clock on the wall stands behind it, for work that sleeps.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any


class Overran(Exception):
    """The work was stopped at its time limit."""


class Failed(Exception):
    """The work raised; the text begins with the name of what it raised."""


PATIENCE = 30  # seconds on the wall for each one allowed on the processor
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class Crashed(Exception):
    """The process that did the work died."""


def _serve(pipe: Connection) -> None:
    """Answer requests (function, arguments) with (failed, value) until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started us
    os.environ.update(dict.fromkeys(_THREADS, "1"))  # read when NumPy is loaded: not yet
    while True:
        try:
            limit_s, work, arguments = pipe.recv()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_PROF, limit_s)
        try:
            answer = (False, work(*arguments))
        except Exception as failure:
            answer = (True, f"{type(failure).__name__}: {failure}")
        signal.setitimer(signal.ITIMER_PROF, 0)
        pipe.send(answer)


class Limited:
    """Hold one child process that works for us; it is replaced after it overran or crashed.

    The child uses one core: the libraries of linear algebra start no threads there.
    """

    def __init__(self) -> None:
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._child = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._child.start()
        theirs.close()

    def __enter__(self) -> Limited:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()

    def _stop(self) -> None:
        self._child.kill()  # without effect on a child that has ended
        self._child.join()
        self._pipe.close()

    def __call__(self, limit_s: float, work: Callable[..., Any], *arguments: object) -> Any:
        """Return work(*arguments); raise Failed, Overran or Crashed.

        limit_s: of processor time. work: a function of a module's top level.
        """
        self._pipe.send((limit_s, work, arguments))
        try:
            if not self._pipe.poll(PATIENCE * limit_s):
                raise Overran(f"stopped after {PATIENCE * limit_s:g} s on the wall")
            failed, value = self._pipe.recv()
        except (EOFError, ConnectionError):
            code = self._replace()
            if code == -signal.SIGPROF:
                raise Overran(f"stopped after {limit_s:g} s") from None
            raise Crashed(f"the process ended with status {code}") from None
        except (Overran, KeyboardInterrupt):
            self._replace()
            raise
        if failed:
            raise Failed(value)
        return value

    def _replace(self) -> int | None:
        """Start another child; return how the last one ended: its status or minus a signal."""
        self._child.join(1.0)
        self._stop()
        code = self._child.exitcode
        self._start()
        return code
