"""The conversation with a board: one reader, one command at a time, a ping when nobody speaks.

Two threads serve a real wire. One reads, so that no line is lost while the program computes or
sleeps. The other pings, so that the board's silence timer stays fed meanwhile - but only as long
as the program itself has called in within `unattended_s`: a program that hangs or was forgotten
must not keep the robot moving for ever, so then the robot is stopped, and the next call says so.
If the whole process hangs, nothing pings and the board's own timer acts. On a link in lockstep
time passes only in calls: there are no threads, and waiting is reading.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace

from ..errors import DamagedLine, RobotClosed, RobotError, RobotLost, RobotReset, RobotUnattended
from .clock import BoardClock
from .link import Link
from .protocol import Data, Hello, Telemetry, Verdict, parse, seal
from .record import Recorder

RETRY_S = 0.1
GREETING_S = 0.5  # after the session opened, a greeting may still answer an earlier asking
PATIENCE_S = 2.0
PING_S = 0.4
LONGEST_LINE = 4096
MOST_UNREAD = 15_000  # frames: five minutes
STOP = b"\n!\n"


@dataclass(frozen=True)
class Losses:
    """What did not arrive whole: damaged lines, frames that never came or came twice.

    unread_frames: dropped here because the program iterated too slowly. resent: commands that
    were sent again for want of a verdict.
    """

    damaged_lines: int = 0
    missed_frames: int = 0
    repeated_frames: int = 0
    unread_frames: int = 0
    resent: int = 0


@dataclass
class _Pending:
    """The command that waits for its verdict, and what came for it."""

    number: int
    data: list[Data] = field(default_factory=list)
    verdict: Verdict | None = None
    damaged: bool = False  # it came damaged to the board: send it again
    incomplete: bool = False  # a line from the board was damaged meanwhile


@dataclass(frozen=True)
class Answer:
    """A verdict with the data lines before it; complete unless some may be missing."""

    verdict: Verdict
    data: list[Data]
    complete: bool


class Dialogue:
    """Talk to one board over one link. Every call may raise the error that ended the run."""

    def __init__(self, link: Link, recorder: Recorder | None, unattended_s: float):
        self.link = link
        self.hello: Hello | None = None
        self.clock = BoardClock()
        self.losses = Losses()
        self.latest: Telemetry | None = None
        self.every = 1  # frames from one telemetry line to the next, 0 for none
        self.foreign: bytes = b""  # the start of what came and made no sense
        self.heard = False
        self._recorder = recorder
        self._unattended_s = unattended_s
        self._attended_s = self._spoken_s = link.now_s()
        self._number = 0
        self._session = False
        self._late_greeting_s = 0.0
        self._pending: _Pending | None = None
        self._unread: deque[Telemetry] = deque(maxlen=MOST_UNREAD)
        self._rest = b""
        self._failure: RobotError | None = None
        self._notice: RobotError | None = None
        self._leaving = False
        self._closing = threading.Event()
        self._changed = threading.Condition()  # guards all that the reader writes
        self._talking = threading.RLock()  # one command at a time
        self._threads: list[threading.Thread] = []

    def start(self) -> None:
        """Begin to read."""
        if not self.link.lockstep:
            self._thread("serpenoid reader", self._read_on)

    def open_session(self, patience_s: float) -> bool:
        """Ask for the greeting under number 0; return whether it came and was obeyed."""
        with self._talking:
            self._number = 0
            answer = self._exchange("hello", patience_s)
            if answer is None or not answer.verdict.accepted or self.hello is None:
                return False
            with self._changed:
                self._session, self.losses, self._unread = True, Losses(), deque(maxlen=MOST_UNREAD)
                self.clock, self.latest = BoardClock(), None
                self._late_greeting_s = self.link.now_s() + GREETING_S
        if not self.link.lockstep:
            self._thread("serpenoid pinger", self._keep_alive)
        return True

    def command(self, text: str) -> Answer:
        """Send a command under the next number; return its answer or raise RobotLost."""
        self._attend()
        return self._command(text, PATIENCE_S)

    def halt(self) -> None:
        """Stop the robot at once, whatever else is under way; the verdict is not waited for."""
        self.write(STOP)

    def stop(self) -> Answer:
        """Stop the robot at once and return once the board has confirmed it."""
        self.halt()
        return self._command("stop", PATIENCE_S)

    def wait(self, done: Callable[[], bool], until_s: float) -> bool:
        """Wait until done() or the host's time until_s; return done(). Raises what ended the run.

        done() is called with the reader held off.
        """
        with self._changed:
            while not done():
                self._check()
                left_s = until_s - self.link.now_s()
                if left_s <= 0:
                    return False
                if self.link.lockstep:
                    self._step(left_s)
                else:
                    self._changed.wait(left_s)
        return True

    def forget_frames(self) -> None:
        """Drop the frames that nobody has asked for."""
        with self._changed:
            self._unread.clear()

    def next_frame(self, until_s: float) -> Telemetry | None:
        """Return the next frame, or None at the host's time until_s; keeps the board awake."""
        while True:
            self._attend()
            if self.wait(lambda: bool(self._unread), min(until_s, self.link.now_s() + PING_S)):
                with self._changed:
                    frame = self._unread.popleft()
                self._ping_if_quiet(in_lockstep=True)
                return frame
            if self.link.now_s() >= until_s:
                return None
            self._ping_if_quiet(in_lockstep=True)

    def write(self, data: bytes) -> None:
        """Send bytes as they are, and record them."""
        self.link.write(data)
        for line in data.split(b"\n"):
            if line:
                self._record(self.link.now_s(), ">", line)

    def leave(self) -> bool:
        """Stop the robot and close the session; return whether the board confirmed the stop."""
        self._leaving = True
        stopped = not self._session  # before a session nothing was set in motion from here
        with suppress(RobotError):
            self.halt()
            if self._session:
                stopped = self._command("stop", PATIENCE_S / 2).verdict.accepted
                self._command("bye", PATIENCE_S / 4)
        self._closing.set()
        for thread in self._threads:
            thread.join(PATIENCE_S)
        return stopped

    @property
    def failure(self) -> RobotError | None:
        """Return what ended the run, if anything did."""
        return self._failure

    def unseen(self) -> RobotError | None:
        """Return the error that no call has raised yet, if any."""
        return self._failure or self._notice

    def _command(self, text: str, patience_s: float) -> Answer:
        with self._talking:
            self._check()
            self._number = (self._number + 1) & 0xFFFF
            answer = self._exchange(text, patience_s)
        if answer is None:
            raise self._fail(
                RobotLost(
                    f"no verdict for {text!r} within {patience_s:g} s, though {self.link.name} is "
                    "open: the board hangs or the wire is bad; check its power and cable"
                )
            )
        return answer

    def _exchange(self, text: str, patience_s: float) -> Answer | None:
        pending = _Pending(self._number)
        line, end_s = seal(text, self._number), self.link.now_s() + patience_s
        with self._changed:
            self._pending = pending
        while True:
            pending.damaged = False
            self.write(line)
            self._spoken_s = self.link.now_s()
            retry_s = min(self._spoken_s + RETRY_S, end_s)
            self.wait(lambda: pending.verdict is not None or pending.damaged, retry_s)
            if pending.damaged:  # not at the pace of a board that answers everything so
                self.wait(lambda: pending.verdict is not None, self._spoken_s + RETRY_S / 5)
            if pending.verdict:
                complete = not (pending.incomplete or pending.verdict.again)
                return Answer(pending.verdict, pending.data, complete)
            if self.link.now_s() >= end_s:
                return None
            self._lose(resent=1)

    def _attend(self) -> None:
        self._attended_s = self.link.now_s()
        with self._changed:
            notice, self._notice = self._notice, None
        if notice:
            raise notice

    def _check(self) -> None:
        lost = isinstance(self._failure, RobotLost)
        if self._failure and (lost or not self._leaving):
            raise self._failure
        if self._closing.is_set():
            raise RobotClosed("the robot is closed; talk to it inside `with Robot(port) as robot:`")

    def _fail(self, error: RobotError) -> RobotError:
        """End the run with its first error: stop the robot if the wire still carries that."""
        with self._changed:
            first, self._failure = self._failure, self._failure or error
            self._changed.notify_all()
        if not first:
            with suppress(RobotError):
                self.link.write(STOP)
        return first or error

    def _lose(self, **counts: int) -> None:
        with self._changed:
            sums = {name: getattr(self.losses, name) + n for name, n in counts.items()}
            self.losses = replace(self.losses, **sums)

    def _record(self, host_s: float, direction: str, line: bytes) -> None:
        if not self._recorder:
            return
        try:
            self._recorder.line(host_s, direction, line)
        except RobotError as error:
            self._recorder = None
            raise self._fail(error) from error

    def _thread(self, name: str, work: Callable[[], None]) -> None:
        self._threads.append(threading.Thread(target=work, name=name, daemon=True))
        self._threads[-1].start()

    def _read_on(self) -> None:
        while not self._closing.is_set() and not isinstance(self._failure, RobotLost):
            self._step(0.05)

    def _keep_alive(self) -> None:
        while not self._closing.wait(PING_S / 4) and not self._failure:
            with suppress(RobotError):  # kept in _failure, for the program's next call
                if self.link.now_s() - self._attended_s > self._unattended_s:
                    self._abandon()
                self._ping_if_quiet()

    def _ping_if_quiet(self, in_lockstep: bool = False) -> None:
        if in_lockstep and not self.link.lockstep:
            return
        if self.link.now_s() - self._spoken_s > PING_S:
            self._command("ping", PATIENCE_S)

    def _abandon(self) -> None:
        self._notice = RobotUnattended(
            f"the program did not call for {self._unattended_s:g} s, so the robot was stopped; "
            "iterate frames() meanwhile, or give Robot a longer unattended_s"
        )
        self._attended_s = self.link.now_s()
        self.halt()

    def _step(self, timeout_s: float) -> None:
        """Read once and deal with every line that is complete."""
        try:
            *lines, self._rest = (self._rest + self.link.read(timeout_s)).split(b"\n")
        except RobotError as error:
            self._fail(error)
            return
        if len(self._rest) > LONGEST_LINE:
            lines, self._rest = [*lines, self._rest], b""
        for line in lines:
            try:
                self._take(line, self.link.now_s())
            except RobotError as error:
                self._fail(error)

    def _take(self, line: bytes, host_s: float) -> None:
        if not line.strip():
            return
        self._record(host_s, "<", line)
        with self._changed:
            try:
                message = parse(line)
            except DamagedLine:
                self._take_damaged(line)
            else:
                self.heard = True
                self._take_message(message, host_s)
            self._changed.notify_all()

    def _take_damaged(self, line: bytes) -> None:
        self._lose(damaged_lines=1)
        self.foreign = line if b"protocol=" in line else self.foreign or line
        if self._pending:
            self._pending.incomplete = True

    def _take_message(self, message: Telemetry | Hello | Verdict | Data, host_s: float) -> None:
        if isinstance(message, Telemetry):
            self._take_frame(message, host_s)
        elif isinstance(message, Hello):
            self._take_hello(message)
        elif isinstance(message, Verdict):
            self._take_verdict(message)
        elif message.word == "state":
            self._take_state(message.text)
        elif self._pending:
            self._pending.data.append(message)

    def _take_hello(self, hello: Hello) -> None:
        if not self._session:
            self.hello = hello
        elif hello != self.hello or self.link.now_s() > self._late_greeting_s:
            before = self.hello.boot if self.hello else "none"
            raise self._reset(
                f"the board started again (boot {before}, now {hello.boot}; cause: {hello.reset})"
            )

    def _take_verdict(self, verdict: Verdict) -> None:
        pending = self._pending
        if not pending or pending.verdict:
            return
        if verdict.number == pending.number:
            pending.verdict = verdict
        elif verdict.mark == "?":
            pending.damaged = True

    def _take_state(self, text: str) -> None:
        if text.endswith("why=silence"):
            self._notice = RobotUnattended(
                "the board heard nothing from this program for its silence time and went to its "
                "safe pose; was the program or the computer asleep?"
            )

    def _take_frame(self, frame: Telemetry, host_s: float) -> None:
        last = self.latest
        if last and self._session:
            gap = (frame.frame - last.frame) & 0xFFFFFFFF
            if gap >= 1 << 31:
                raise self._reset(f"its frames went back from {last.frame} to {frame.frame}")
            if not gap:
                self._lose(repeated_frames=1)
                return
            self._count_missed(gap)
        self.latest = frame
        self.clock.add(host_s, frame.frame, frame.board_us)
        if len(self._unread) == MOST_UNREAD:
            self._lose(unread_frames=1)
        self._unread.append(frame)

    def _count_missed(self, gap: int) -> None:
        if self.every and gap > self.every:
            self._lose(missed_frames=gap // self.every - 1)

    @staticmethod
    def _reset(what: str) -> RobotReset:
        return RobotReset(
            f"{what}: it forgot its motion and stands idle; look for a loose cable, a brown-out "
            "or another program opening the port, then start again"
        )
