"""Stop a robot first when Ctrl-C, Ctrl-Z or a signal ends or suspends the program."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, FunctionType

from ..base import system


class SignalGuard:
    """Call `stop` at once on a signal, then the handler that the signal had before.

    SIGTERM, SIGHUP and SIGQUIT, which would kill, raise SystemExit instead, so that `with` blocks
    end in order. Ctrl-Z (SIGTSTP) suspends the program, and `resumed` is called when it continues.
    Ignored signals stay ignored. Outside the main thread, where Python allows no handlers, the
    guard does nothing.

    While `held` is set, signals are kept until restore(), so that a second Ctrl-C cannot interrupt
    the stopping. leaving: functions that set `held`; their start counts as held already.
    """

    def __init__(
        self,
        stop: Callable[[], None],
        leaving: tuple[FunctionType, ...] = (),
        resumed: Callable[[], None] = lambda: None,
    ):
        self._stop, self._resumed = stop, resumed
        self._leaving = {function.__code__ for function in leaving}
        self._handlers: dict[int, Callable[[int, FrameType | None], object] | int | None] = {}
        self._kept: int | None = None
        self.held = False

    def install(self) -> None:
        """Install the handlers."""
        if threading.current_thread() is not threading.main_thread():
            return
        for number in (signal.SIGINT, *system.ENDING, *system.SUSPENDING):
            handler = signal.getsignal(number)
            if handler in (signal.SIG_IGN, None):  # Python cannot restore a None.
                continue
            self._handlers[number] = handler
            signal.signal(number, self._on_signal)

    def restore(self, *, forget: bool = False) -> None:
        """Restore the earlier handlers and raise the kept signal; forget: drop it."""
        try:
            for number, handler in reversed(self._handlers.items()):  # SIGINT is held to the end.
                signal.signal(number, handler)
        finally:  # If a handler raised, signals not yet restored are no longer kept.
            self.held = False
        number, self._kept = self._kept, None
        if number is not None and not forget:
            signal.raise_signal(number)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._stop()
        if self.held or (frame is not None and frame.f_code in self._leaving):
            self._kept = number
            return
        handler = self._handlers.get(number)
        if callable(handler):
            handler(number, frame)
        elif number in system.SUSPENDING:
            signal.raise_signal(signal.SIGSTOP)  # A SIGTSTP has no effect without a parent shell.
            self._resumed()
        else:
            raise SystemExit(128 + number)
