"""A conversation typed by a person: every line shown and checked, `!` stops at once."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable
from contextlib import suppress

from ...model.errors import BadInput, DamagedLine, RobotError
from ..signals import SignalGuard
from ..wire.dialogue import PING_S, STOP
from ..wire.link import Link, open_link
from ..wire.protocol import Hello, Telemetry, Verdict, parse, seal, unseal
from .keys import Keyboard, keyboard

HEAR_S = 0.02
BOOT_S = 3.0  # in which a board that opening has reset may still be deaf
VERDICT_S = 1.0
LAST_WORDS_S = 0.3
GREETING = "hello"
HELP = "type `help` and Enter; ! stops the robot at once; Ctrl-C or Ctrl-D stops it and leaves"


class Monitor:
    """One person and one board: lines typed become numbered commands, lines heard become text.

    A session is opened, so that every line is checked both ways, and a ping goes out whenever
    nothing else does, so that a gait runs while the person reads. One command at a time: what is
    typed meanwhile waits for the verdict, or for a second. show takes a line; every: show so
    many telemetry lines as one.
    """

    def __init__(self, link: Link, show: Callable[[str], None], every: int):
        self._link, self._show, self._every = link, show, every
        self._number = -1
        self._pings: set[int] = set()
        self._queue: deque[str] = deque([GREETING])
        self._awaited: int | None = None
        self._sent_s = link.now_s()
        self._deaf_until_s = self._sent_s + BOOT_S
        self._rest = b""
        self._frames = 0
        self._boot: int | None = None
        self.typed = ""

    def go(self, keys: Keyboard, redraw: Callable[[str], None]) -> None:
        """Talk until the input ends; redraw shows what is being typed. Raises RobotLost."""
        while self.press(keys(0.0)):
            redraw(self.typed)
            self.step()
        if self.typed:
            self._show(f"not sent, for want of a line end: {self.typed}")
        while self._queue or self._awaited not in {None, *self._pings}:
            self.step()

    def press(self, key: str) -> bool:
        """Take one key; return False at the end of the input."""
        if key == "!":
            waiting = [text for text in self._queue if text != GREETING]
            self.halt()
            for text in waiting:
                self._show(f"not sent, for the stop came before it: {text}")
        elif key == "enter":
            if self.typed.strip():
                self._queue.append(self.typed.strip())
            self.typed = ""
        elif key == "backspace":
            self.typed = self.typed[:-1]
        elif len(key) == 1 and key.isprintable():
            self.typed += key
        return key != "end"

    def step(self) -> None:
        """Send what may be sent, then listen for a moment."""
        now_s = self._link.now_s()
        if now_s < self._deaf_until_s:
            return self._hear(HEAR_S)
        if self._awaited is not None and now_s - self._sent_s > VERDICT_S:
            self._show(f"no verdict on #{self._awaited} within {VERDICT_S:g} s")
            self._awaited = None
        if self._awaited is None and self._queue:
            self._send(self._queue.popleft())
        elif self._awaited is None and now_s - self._sent_s > PING_S:
            self._send("ping")
            self._pings.add(self._number)
        return self._hear(HEAR_S)

    def halt(self) -> None:
        """Stop the robot at once and forget what was still to be sent, but for the greeting."""
        self._link.write(STOP)
        self._queue = deque(text for text in self._queue if text == GREETING)

    def leave(self) -> None:
        """Stop the robot, close the session, and hear the board out."""
        self.halt()
        for last in ("stop", "bye"):
            self._send(last)
            end_s = self._link.now_s() + LAST_WORDS_S
            while self._link.now_s() < end_s and self._awaited is not None:
                self._hear(HEAR_S)

    def _send(self, text: str) -> None:
        number = (self._number + 1) & 0xFFFF
        try:
            line = seal(text, number)
        except BadInput as error:
            self._show(str(error))
            return
        self._number = self._awaited = number
        self._sent_s = self._link.now_s()
        self._link.write(line)

    def _hear(self, timeout_s: float) -> None:
        *lines, self._rest = (self._rest + self._link.read(timeout_s)).split(b"\n")
        for line in lines:
            if line.strip():
                self._take(line)

    def _take(self, line: bytes) -> None:
        try:
            message, text = parse(line), unseal(line)
        except DamagedLine as error:
            self._show(f"damaged: {error}")
            return
        self._deaf_until_s = 0.0
        if isinstance(message, Hello):
            self._greeted(message)
        if isinstance(message, Telemetry):
            self._frames += 1
            if self._frames % self._every:
                return
        if isinstance(message, Verdict):
            if message.number == self._awaited or message.mark == "?":
                self._awaited = None
            if message.number in self._pings:
                self._pings.discard(message.number)
                return
        self._show(text)

    def _greeted(self, hello: Hello) -> None:
        """Open a new session if the greeting is that of a new start."""
        if self._boot not in (None, hello.boot):
            self._queue.appendleft(GREETING)
            self._show("the board started again: it forgot its motion and stands idle")
        self._boot = hello.boot


def converse(port: str | None, every: int) -> None:
    """Open a port and let a person talk until the input ends or Ctrl-C; the robot is stopped.

    Raises PortMissing, PortBusy, RobotLost.
    """
    screen = _Screen()
    link = open_link(port)
    talk = Monitor(link, screen.show, every)

    def stop() -> None:
        with suppress(RobotError):
            talk.halt()

    guard = SignalGuard(stop)
    guard.install()
    try:
        screen.greet()
        with suppress(KeyboardInterrupt), keyboard() as keys:
            talk.go(keys, screen.tell)
    finally:
        guard.held = True
        with suppress(RobotError):
            talk.leave()
        link.close()
        guard.restore()


class _Screen:
    """Lines of the board above the one that is being typed; plain lines off a terminal."""

    CLEAR = "\r\x1b[K"

    def __init__(self) -> None:
        self._live = sys.stdout.isatty()
        self._below = ""

    def greet(self) -> None:
        """Say, on a terminal only, what the keys do."""
        if self._live:
            self.show(HELP)

    def show(self, line: str) -> None:
        """Print a line for good."""
        below = self._below if self._live else ""
        clear = self.CLEAR if self._live else ""
        print(f"{clear}{line}\n{below}", end="", flush=True)

    def tell(self, typed: str) -> None:
        """Show, on a terminal only, what is being typed."""
        if self._live and typed != self._below:
            self._below = typed
            print(self.CLEAR + typed, end="", flush=True)
