"""Ctrl-C, Ctrl-Z and signals that end a program: a robot in use is stopped before all else."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, FunctionType

from ..base import system

_WATCHED = (signal.SIGINT, *system.ENDING, *system.SUSPENDING)


class SignalGuard:
    """Call `stop` at once on a signal, then let it do what it did before.

    SIGTERM, SIGHUP and SIGQUIT, which would kill, raise SystemExit instead, so that `with` blocks
    are left in order. Ctrl-Z (SIGTSTP) suspends; `resumed` is called when that is over. A signal
    that is ignored stays ignored. While `held` is set, and at the start of the functions
    `leaving`, which set it, signals are kept for restore(): an impatient second Ctrl-C cannot cut
    the stopping short. Outside the main thread Python allows no handlers, and this does nothing.
    """

    def __init__(
        self,
        stop: Callable[[], None],
        leaving: tuple[FunctionType, ...] = (),
        resumed: Callable[[], None] = lambda: None,
    ):
        self._stop, self._resumed = stop, resumed
        self._leaving = {function.__code__ for function in leaving}
        self._before: dict[int, Callable[[int, FrameType | None], object] | int | None] = {}
        self._kept: int | None = None
        self.held = False

    def install(self) -> None:
        """Take over the signals."""
        if threading.current_thread() is not threading.main_thread():
            return
        for number in _WATCHED:
            handler = signal.getsignal(number)
            if handler in (signal.SIG_IGN, None):  # None: not Python's to give back
                continue
            self._before[number] = handler
            signal.signal(number, self._on_signal)

    def restore(self, *, forget: bool = False) -> None:
        """Restore the handlers, and send the signal that was kept unless it is to be dropped."""
        try:
            for number, handler in reversed(self._before.items()):  # SIGINT last: it is kept so far
                signal.signal(number, handler)
        finally:  # where the handler of another signal raised, those that are left act at once
            self.held = False
        number, self._kept = self._kept, None
        if number is not None and not forget:
            signal.raise_signal(number)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._stop()
        if self.held or (frame is not None and frame.f_code in self._leaving):
            self._kept = number
            return
        handler = self._before.get(number)
        if callable(handler):
            handler(number, frame)
        elif number in system.SUSPENDING:
            signal.raise_signal(signal.SIGSTOP)  # SIGTSTP does nothing without a shell above
            self._resumed()
        else:
            raise SystemExit(128 + number)
