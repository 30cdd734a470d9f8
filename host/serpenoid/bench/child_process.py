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


def _serve(pipe: Connection) -> None:
    """Answer requests (limit, function, arguments) with (value, note) until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started us
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"  # read when NumPy is loaded: not yet
    while True:
        try:
            limit_s, work, arguments = pipe.recv()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_PROF, limit_s)
        try:
            answer = work(*arguments), ""
        except Exception as failure:
            answer = None, f"{type(failure).__name__}: {failure}"
        signal.setitimer(signal.ITIMER_PROF, 0)
        pipe.send(answer)


class Limited:
    """Hold one child process that works for us; it is replaced after it overran or crashed.

    The child uses one core: the libraries of linear algebra start no threads there.
    """

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, end = context.Pipe()
        self._child = context.Process(target=_serve, args=(end,), daemon=True)
        self._child.start()
        end.close()

    def __enter__(self) -> Limited:
        return self

    def __exit__(self, *_: object) -> None:
        self._child.kill()  # without effect on a child that has ended
        self._child.join()
        self._pipe.close()

    def __call__(
        self, limit_s: float, work: Callable[..., Any], *arguments: object
    ) -> tuple[Any, str]:
        """Return work(*arguments) and "", or None and a note.

        A note is the name of an exception and its text, or begins with HANG or CRASH. limit_s: of
        processor time. work: a function of a module's top level.
        """
        self._pipe.send((limit_s, work, arguments))
        try:
            # For each second on the processor 30 are allowed on the wall.
            if self._pipe.poll(30 * limit_s):
                return self._pipe.recv()
        except (EOFError, ConnectionError):
            self._child.join(1.0)
        code = self._child.exitcode
        self.__exit__()
        self.__init__()
        if code in (None, -signal.SIGPROF):
            return None, f"HANG: stopped after {limit_s:g} s"
        return None, f"CRASH: the process ended with status {code}"
