"""A conversation typed by a person: every line shown and checked, `!` stops at once."""

from __future__ import annotations

import math
import queue
import sys
import threading
from collections.abc import Callable
from contextlib import suppress

from ...model.errors import (
    BadInput,
    DamagedLine,
    RobotError,
    RobotHeld,
    RobotReset,
    RobotUnattended,
    StateUnasked,
)
from ...model.files import visible
from ..signals import SignalGuard
from ..wire.dialogue import Dialogue
from ..wire.greeting import greet
from ..wire.link import Link, open_link
from ..wire.protocol import Telemetry, Verdict, parse, unseal
from .keys import Keyboard, keyboard

HEAR_S = 0.02
GREETING_S = 5.0
MOST_TYPED = 200  # characters; the board reads fewer
HELP = "type `help` and Enter; ! stops the robot at once; Ctrl-C or Ctrl-D stops it and leaves"


class Monitor:
    """One person and one board: lines typed become numbered commands, lines heard become text.

    The conversation is a Dialogue: lines are checked both ways, sent again for want of a verdict,
    and pings keep a gait going while the person reads. Commands wait for one another in a thread
    of their own, so that a key is heard at any time, even while the board has not greeted yet.
    show takes a line; every: show so many telemetry lines as one. redraw shows what is typed.
    """

    def __init__(
        self,
        link: Link,
        show: Callable[[str], None],
        every: int,
        keys: Keyboard | None = None,
        redraw: Callable[[str], None] = lambda _: None,
    ):
        self._link, self._show, self._every = link, show, every
        self._keys, self._redraw = keys, redraw
        self._talk = self._new_dialogue()
        self._queue: queue.Queue[str | None] = queue.Queue()  # "": only greet; None: no more
        self._worker = threading.Thread(target=self._work_on, daemon=True)
        self._failure: BaseException | None = None
        self._frames = 0
        self.typed = ""

    def open(self) -> None:
        """Wait for the board's greeting and open a session; raise NoAnswer, ProtocolMismatch.

        Keys are heard meanwhile: a stop does not wait for the greeting.
        """
        self._begin()
        if not self._link.lockstep:
            self._worker.start()
        while not self._talk.inbox.in_session:
            self.step()
            self._hear()

    def go(self) -> None:
        """Talk until the input ends. Raises what ended the conversation."""
        while self._hear():
            self.step()
        if self.typed:
            self._show(f"not sent, for want of a line end: {self.typed}")
        while self._queue.unfinished_tasks:  # one may still wait for its verdict
            self.step()

    def press(self, key: str) -> bool:
        """Take one key; return False at the end of the input."""
        if key == "!":
            self.halt()
        elif key == "enter":
            if self.typed.strip():
                self._talk.release()
                self._queue.put(self.typed.strip())
            self.typed = ""
        elif key == "backspace":
            self.typed = self.typed[:-1]
        elif len(key) == 1 and key.isprintable() and len(self.typed) < MOST_TYPED:
            self.typed += key
        return key != "end"

    def step(self) -> None:
        """Let a moment pass; raise what ended the conversation, but a reset: then begin anew."""
        try:
            if self._link.lockstep and not self._queue.empty():
                self._work(self._queue.get() or "")
            if self._failure:
                raise self._failure
            self._talk.pass_time(HEAR_S)
        except RobotReset as error:
            self._show(str(error))
            self._talk.fall_silent()
            self._talk, self._failure = self._new_dialogue(), None
            self._begin()

    def halt(self) -> None:
        """Stop the robot at once and forget what was still to be sent."""
        self._talk.halt(stay=True)
        with suppress(queue.Empty):
            while True:
                text = self._queue.get_nowait()
                self._queue.task_done()
                if text:
                    self._show(f"not sent, for the stop came before it: {text}")
        if not self._talk.inbox.in_session:  # the greeting is waited for all the same
            self._queue.put("")

    def leave(self) -> None:
        """Stop the robot, close the session and the port; raise if the stop is not sure."""
        result = self._talk.leave()
        self._link.close()
        self._queue.put(None)
        if self._worker.is_alive():
            self._worker.join(GREETING_S)
        told = None if result.unseen is self._failure else result.unseen
        if problem := told or result.unstopped:
            raise problem

    def _hear(self) -> bool:
        """Take the next key, if one comes in time; return False at the end of the input."""
        if self._keys and not self.press(self._keys(0.0 if self._link.lockstep else HEAR_S)):
            self._keys = None
        self._redraw(self.typed)
        return self._keys is not None

    def _begin(self) -> None:
        self._talk.start()
        self._queue.put("")

    def _new_dialogue(self) -> Dialogue:
        return Dialogue(self._link, None, math.inf, self._heard)

    def _work_on(self) -> None:
        while (text := self._queue.get()) is not None:
            self._work(text)

    def _work(self, text: str) -> None:
        """Open a session if there is none, then send a command, if there is one."""
        try:
            if not self._talk.inbox.in_session:
                greet(self._talk, GREETING_S)
            if text:
                self._send(text)
        except (RobotError, OSError) as error:  # the latter from a screen that is gone
            self._failure = error
        finally:
            self._queue.task_done()

    def _send(self, text: str) -> None:
        """Send one command; show, rather than raise, what does not end the conversation."""
        while True:
            try:
                self._talk.ask(text)
            except (BadInput, RobotHeld) as error:
                self._show(str(error))
            except (RobotUnattended, StateUnasked) as error:
                self._show(str(error))
                continue
            return

    def _heard(self, line: bytes) -> None:
        """Show a line from the board, but frames that are thinned out and verdicts on pings."""
        try:
            message, text = parse(line), unseal(line)
        except DamagedLine as error:
            self._say(f"damaged: {error}")
            return
        if isinstance(message, Telemetry):
            self._frames += 1
            if self._frames % self._every:
                return
        asked = self._talk.inbox.pending
        answered = asked and isinstance(message, Verdict) and message.number == asked.number
        if not (answered and asked and asked.text == "ping"):
            self._say(text)

    def _say(self, text: str) -> None:
        """Show a line in the reader's thread, which must outlive a screen that is gone."""
        try:
            self._show(text)
        except OSError as error:
            self._failure = self._failure or error


def converse(port: str | None, every: int) -> None:
    """Open a port and let a person talk until the input ends or Ctrl-C; the robot is stopped.

    Raises PortMissing, PortBusy, NoAnswer, ProtocolMismatch, RobotLost, StopUnconfirmed.
    """
    screen = _Screen()
    with keyboard() as keys:
        _converse(Monitor(open_link(port), screen.show, every, keys, screen.tell), screen)


def _converse(talk: Monitor, screen: _Screen) -> None:
    def stop() -> None:
        with suppress(RobotError):
            talk.halt()

    def leave() -> None:
        guard.held = True
        talk.leave()

    guard = SignalGuard(stop, (leave,))
    try:
        guard.install()
        with suppress(KeyboardInterrupt):
            screen.greet()
            talk.open()
            talk.go()
    except BaseException:
        with suppress(RobotError, OSError):  # the first is the one to tell
            leave()
        raise
    else:
        leave()
    finally:
        guard.restore()


class _Screen:
    """Lines of the board above the one that is being typed; plain lines off a terminal."""

    CLEAR = "\r\x1b[K"

    def __init__(self) -> None:
        self._live = sys.stdout is not None and sys.stdout.isatty()  # it may be closed
        self._below = ""
        self._lock = threading.RLock()

    def greet(self) -> None:
        """Say, on a terminal only, what the keys do."""
        if self._live:
            self.show(HELP)

    def show(self, line: str) -> None:
        """Print a line for good."""
        clear = self.CLEAR if self._live else ""
        with self._lock:
            print(f"{clear}{visible(line)}\n{self._below}", end="", flush=True)

    def tell(self, typed: str) -> None:
        """Show, on a terminal only, what is being typed."""
        if self._live and typed != self._below:
            with self._lock:
                self._below = typed
                print(self.CLEAR + typed, end="", flush=True)
