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
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

from ...base.errors import (
    FramesMissing,
    RobotClosed,
    RobotError,
    RobotLost,
    RobotUnattended,
    StopUnconfirmed,
)
from .inbox import Inbox
from .link import Link
from .protocol import LONGEST_LINE, Data, Telemetry, Verdict, refused, seal

STOP = b"\n!\n"


@dataclass(frozen=True)
class WireTimes:
    """Times of the conversation, in seconds.

    retry_s: without a verdict, after which a command is sent again. patience_s: without a verdict,
    after which the board is lost; min_patience_s: less is a rounding error. ping_s: between two
    pings. quiet_s: without a frame, beside two more frames, after which telemetry has ended.
    """

    retry_s: float = 0.1
    patience_s: float = 2.0
    min_patience_s: float = 1e-6
    ping_s: float = 0.4
    quiet_s: float = 1.0


TIMES = WireTimes()


def is_motion(text: str) -> bool:
    """Tell whether a command sets the robot in motion."""
    return text.split(maxsplit=1)[0] in ("gait", "pose")


class Answer(NamedTuple):
    """A verdict with the data lines before it, less those that were lost on the way."""

    verdict: Verdict
    data: list[Data]


class Dialogue:
    """Talk to one board over one link. Every call may raise the error that ended the run.

    record: keeps the lines of the run, as `Recorder.line` does.
    """

    def __init__(
        self,
        link: Link,
        record: Callable[[float, str, bytes], None] | None,
        unattended_s: float,
        listen: Callable[[bytes], None] = lambda _: None,
    ):
        self.link = link
        self.inbox = Inbox()
        self._record_line = record
        self._listen = listen  # is told each line, in the reader's thread
        self._unattended_s = unattended_s
        self._attended_s = link.now_s()
        self._spoken_s = self._attended_s
        self._ping_s = TIMES.ping_s
        self._number = 0
        self._rest = b""
        self.failure: RobotError | None = None  # what ended the run
        self._failure_told = False
        self._leaving = False
        self._closing = threading.Event()
        self._changed = threading.Condition()  # guards the inbox
        self._talking = threading.RLock()  # one command at a time
        self._halts = 0
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
            if answer is None or not answer.verdict.accepted or self.inbox.hello is None:
                return False
            with self._changed:
                self.inbox.open_session(self.link.now_s())
        if not self.link.lockstep:
            self._thread("serpenoid pinger", self._keep_alive)
        return True

    def ask(self, text: str) -> Answer:
        """Send a command under the next number; return its answer or raise RobotLost."""
        self._attend()
        return self._ask_within(text, TIMES.patience_s)

    def halt(self) -> None:
        """Stop the robot at once, whatever else is under way; the verdict is not waited for."""
        with self._changed:
            self._halts += 1
            self.inbox.states.halting()
        self._write(STOP)

    def stop(self) -> Answer:
        """Halt, from any thread, and return once the board has confirmed it and rests.

        Raises StopUnconfirmed if it goes on moving.
        """
        if not self._closing.is_set():  # what is closed is not lost
            self.halt()
        answer = self._ask_within("stop", TIMES.patience_s)
        if answer.verdict.accepted:
            self._await_rest()
        return answer

    def _await_rest(self) -> None:
        """Wait until a `state:` line, a frame or a status says that the board rests."""
        states, until_s = self.inbox.states, self.link.now_s() + TIMES.patience_s
        while not self.wait(lambda: states.rested, self.link.now_s() + TIMES.retry_s):
            if self.link.now_s() >= until_s:
                raise StopUnconfirmed(
                    f"the board said ok to it, but its state is {states.last!r} "
                    f"{TIMES.patience_s:g} s later; if the robot moves, cut its power"
                )
            self._ask_within("status", TIMES.patience_s)

    def feed(self, silence_s: float) -> None:
        """Ping often enough for a board whose silence time is this; 0 is none."""
        # Four pings in the silence time: the board does not go safe over one that is late.
        self._ping_s = min(TIMES.ping_s, silence_s / 4 or TIMES.ping_s)

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
            self.inbox.unread.clear()

    def next_frame(self, until_s: float) -> Telemetry | None:
        """Return the next frame, or None at the host's time until_s; keeps the board awake.

        The time and the board come before frames that wait: a program that is slower than the
        frames ends in time, and is told of a reset at once.
        """
        unread = self.inbox.unread
        while True:
            self._attend()
            if self.link.lockstep:
                self._ping_if_quiet()
            now_s = self.link.now_s()
            with self._changed:  # kept between the look and the taking
                self._check()
                if now_s >= until_s:
                    self.inbox.drop_unread()
                elif self.wait(lambda: bool(unread), min(until_s, now_s + self._ping_s)):
                    return unread.popleft()
            self._check_telemetry()
            if now_s >= until_s:
                self._await_overdue()
                return None

    def _await_overdue(self) -> None:
        """Wait at the end for a frame that is overdue: it comes, or FramesMissing is raised."""
        while self.inbox.quiet_s > 2 * self.inbox.telemetry_s > 0:
            self._check_telemetry()
            self.pass_time(self._ping_s, lambda: not self.inbox.quiet_s)

    def _check_telemetry(self) -> None:
        """Raise FramesMissing if frames should come and do not, in time spent listening."""
        quiet_s, tell_s = self.inbox.quiet_s, self.inbox.telemetry_s
        if tell_s and quiet_s > TIMES.quiet_s + 2 * tell_s:
            raise FramesMissing(
                f"no telemetry for {quiet_s:.1f} s, though the board should tell every "
                f"{tell_s:g} s: is it this firmware, does it hang, is the cable sound? "
                "`serpenoid doctor` tells"
            )

    def leave(self) -> list[RobotError]:
        """Stop the robot and close the session; what fails after the stop no longer matters.

        Returns why the stop is uncertain, if it is, and an error that no call has raised.
        """
        self._leaving = True
        failure = self.failure
        unseen = self.inbox.notice if self._failure_told else failure or self.inbox.notice
        unstopped = self._stop_surely()
        if not (unseen or failure or unstopped):  # what came amid the stop, such as a reset
            unseen = self.failure or self.inbox.notice
        with suppress(RobotError):
            if self.inbox.in_session:
                self._ask_within("bye", TIMES.patience_s / 4)
        self.fall_silent()
        return list(filter(None, (unstopped, unseen)))

    def fall_silent(self) -> None:
        """Stop reading and pinging, without a message: the wire may be used anew."""
        self._closing.set()
        for thread in self._threads:
            thread.join(TIMES.patience_s)

    def pass_time(self, most_s: float, done: Callable[[], bool] = lambda: False) -> None:
        """Let time pass until done(), keeping the board awake; raise what ended the run."""
        if self.link.lockstep:
            self._ping_if_quiet()
        self.wait(done, self.link.now_s() + most_s)

    def _stop_surely(self) -> StopUnconfirmed | None:
        """Stop the robot; return why it may be moving still, None if this is sure."""
        try:
            if not self.inbox.in_session:  # nothing was set in motion by this program
                self.halt()
                return None
            verdict = self.stop().verdict
            if verdict.accepted:
                return None
            refusal = refused("stop", verdict.error, verdict.detail)
            why = f"{refusal}; if the robot moves, cut its power"
        except RobotError as error:
            why = str(error)
        return StopUnconfirmed(f"the robot's stop was not confirmed: {why}")

    def _write(self, data: bytes) -> None:
        self.link.write(data)
        for line in data.split(b"\n"):
            if line:
                self._record(self.link.now_s(), ">", line)

    def _record(self, host_s: float, direction: str, line: bytes) -> None:
        if not self._record_line:
            return
        try:
            self._record_line(host_s, direction, line)
        except RobotError as error:
            self._record_line = None
            raise self._fail(error) from error

    def _ask_within(self, text: str, patience_s: float) -> Answer:
        answer: Answer | None = None
        with self._talking:
            for _ in range(10):  # Other threads may stop what moves nothing, too.
                self._check()
                self._number = (self._number + 1) & 0xFFFF
                answer = self._exchange(text, patience_s)
                if answer is None or answer.verdict.error != "stopped":
                    break
                if is_motion(text):  # the stop was meant for it
                    break
        if answer is None:
            raise self._fail(
                RobotLost(
                    f"no verdict for {text!r} within {patience_s:g} s, though {self.link.name} is "
                    "open: the board hangs or the wire is bad; if the robot moves, it stops by "
                    "itself within its silence time, or else cut its power; then check its cable"
                )
            )
        return answer

    def _exchange(self, text: str, patience_s: float) -> Answer | None:
        """Send until a verdict comes: again after 100 ms, or when the line came damaged.

        patience_s: of listening; a process that slept meanwhile did not listen.
        """
        hello, left_s, halts = self.inbox.hello, patience_s, self._halts
        line = seal(text, self._number, hello.joints if hello else 5)
        with self._changed:
            pending = self.inbox.ask(self._number, text)
        while True:
            pending.damaged = False
            if self._halts != halts and is_motion(text):
                raise refused(text, "stopped")
            self._write(line)
            self._spoken_s = self.link.now_s()
            retry_s = min(TIMES.retry_s, left_s)
            self.wait(
                lambda: pending.verdict is not None or pending.damaged, self._spoken_s + retry_s
            )
            if pending.damaged:  # not at the pace of a board that answers everything so
                self.wait(lambda: pending.verdict is not None, self._spoken_s + TIMES.retry_s / 5)
            if pending.verdict:
                return Answer(pending.verdict, pending.data)
            left_s -= min(self.link.now_s() - self._spoken_s, retry_s)
            if left_s < TIMES.min_patience_s:
                return None
            with self._changed:
                self.inbox.losses.resent_commands += 1

    def _attend(self) -> None:
        self._attended_s = self.link.now_s()
        with self._changed:
            notice, self.inbox.notice = self.inbox.notice, None
        if notice:
            raise notice

    def _check(self) -> None:
        lost = isinstance(self.failure, RobotLost)
        if self.failure and (lost or not self._leaving):
            self._failure_told |= threading.current_thread() not in self._threads
            raise self.failure
        if self._closing.is_set():
            raise RobotClosed(
                "the robot is closed; talk to it inside `with RobotBoard(port) as robot:`"
            )

    def _fail(self, error: RobotError) -> RobotError:
        """End the run with its first error: stop the robot if the wire still carries that."""
        with self._changed:
            first, self.failure = self.failure, self.failure or error
            if not first:
                self.inbox.states.halting()
            self._changed.notify_all()
        if not first:
            with suppress(RobotError):
                self.link.write(STOP)
        return first or error

    def _thread(self, name: str, work: Callable[[], None]) -> None:
        self._threads.append(threading.Thread(target=work, name=name, daemon=True))
        self._threads[-1].start()

    def _read_on(self) -> None:
        while not self._closing.is_set() and not isinstance(self.failure, RobotLost):
            self._step(0.05)

    def _keep_alive(self) -> None:
        while not self._closing.wait(self._ping_s / 4) and not self.failure:
            with suppress(RobotError):  # kept in _failure, for the program's next call
                if self.link.now_s() - self._attended_s > self._unattended_s:
                    self._abandon()
                self._ping_if_quiet()

    def _ping_if_quiet(self) -> None:
        if self.link.now_s() - self._spoken_s > self._ping_s:
            self._ask_within("ping", TIMES.patience_s)

    def _abandon(self) -> None:
        self._attended_s = self.link.now_s()
        with self._changed:
            self.inbox.notice = RobotUnattended(
                f"the program stood still for {self._unattended_s:g} s, so the robot was stopped: "
                "a terminal halted by Ctrl-S goes on by Ctrl-Q; a script iterates frames() "
                "meanwhile, or gives RobotBoard a longer unattended_s"
            )
        self.halt()

    def _step(self, timeout_s: float) -> None:
        """Read once and deal with every line that is complete."""
        begun_s = self.link.now_s()
        try:
            *lines, self._rest = (self._rest + self.link.read(timeout_s)).split(b"\n")
        except RobotError as error:
            self._fail(error)
            return
        if len(self._rest) > LONGEST_LINE:
            lines, self._rest = [*lines, self._rest], b""
        # A process that slept did not listen: it counts no more than it meant to wait.
        with self._changed:
            self.inbox.quiet_s += min(self.link.now_s() - begun_s, timeout_s)
        for line in lines:
            self._take(line, self.link.now_s())

    def _take(self, line: bytes, host_s: float) -> None:
        if not line.strip():
            return
        try:
            self._record(host_s, "<", line)
            self._listen(line)
            with self._changed:
                self.inbox.take(line, host_s)
                self._changed.notify_all()
        except RobotError as error:
            self._fail(error)
