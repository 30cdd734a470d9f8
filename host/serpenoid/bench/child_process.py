"""Run work in a child process under a time limit: a hang or a crash becomes an answer.

The limit is of processor time, so that other load on the machine fells nobody: a timer whose signal
ends the child, compiled code or not. A clock on the wall stands behind it, for work that sleeps.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any


class Overran(Exception):
    """The work was stopped at its time limit."""


class Failed(Exception):
    """The work raised; the text begins with the name of what it raised."""


PATIENCE = 30  # seconds on the wall for each one allowed on the processor


class Crashed(Exception):
    """The process that did the work died."""


def _serve(pipe: Connection) -> None:
    """Answer requests (function, arguments) with (failed, value) until the pipe closes."""
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


@contextmanager
def _one_thread() -> Iterator[None]:
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """Start processes that do not hear Ctrl-C, which reaches all of a terminal's, with a traceback.

    Only the main thread may say so; what others start hears it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def all_cores() -> Iterator[ProcessPoolExecutor]:
    """Give a pool of processes, one a core, that Ctrl-C ends without a word once they work."""
    cores, spawn = os.cpu_count() or 1, multiprocessing.get_context("spawn")
    silently = (signal.SIGINT, signal.SIG_DFL)
    with ProcessPoolExecutor(
        cores, mp_context=spawn, initializer=signal.signal, initargs=silently
    ) as pool:
        with _deaf_to_ctrl_c():
            for _ in range(cores):
                pool.submit(int)
        yield pool


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
        with _one_thread(), _deaf_to_ctrl_c():
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
