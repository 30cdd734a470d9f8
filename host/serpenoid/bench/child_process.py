"""Run functions in a child process under a time limit, so that hangs and crashes become results.

The limit is of processor time, so that it does not depend on other load on the machine. A timer's
signal ends the child, in compiled code too. A limit of elapsed time ends work that sleeps.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any


def _serve(pipe: Connection) -> None:
    """Answer requests (limit, function, arguments) with (value, note) until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"  # NumPy, not loaded yet, reads it.
    warnings.simplefilter("ignore")  # Extreme scenes are extreme on purpose.
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
    """One child process that runs functions; it is replaced after an overrun or a crash.

    The child uses one core: libraries of linear algebra start no threads in it.
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
        self._child.kill()  # It has no effect on a child that has ended.
        self._child.join()
        self._pipe.close()

    def __call__(
        self, limit_s: float, work: Callable[..., Any], *arguments: object
    ) -> tuple[Any, str]:
        """Return work(*arguments) and "", or None and a note on the failure.

        The note is an exception's name and text, or begins with HANG or CRASH. limit_s: limit of
        processor time. work: a function at the top level of a module.
        """
        self._pipe.send((limit_s, work, arguments))
        try:
            # The elapsed time may be 30 times the processor time.
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
