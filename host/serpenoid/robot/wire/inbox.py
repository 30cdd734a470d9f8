"""Sort the board's lines into frames, verdicts, losses, resets; no input or output here."""

from __future__ import annotations

import re
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field

from ...base.errors import DamagedLine, ProtocolMismatch, RobotError, RobotReset
from .clock import FRAME_US, BoardClock
from .protocol import Data, Hello, Telemetry, Verdict, parse, unseal
from .state_tracker import StateTracker

MOST_UNREAD = 15_000  # frames: five minutes


@dataclass
class Losses:
    """What did not arrive whole: damaged lines, frames that never came.

    unread_frames: dropped here because the program iterated too slowly, or still waiting when the
    time of frames() was over. resent_commands: sent again for want of a verdict.
    """

    damaged_lines: int = 0
    missed_frames: int = 0
    unread_frames: int = 0
    resent_commands: int = 0


@dataclass
class Pending:
    """The command that waits for its verdict, and what came for it."""

    number: int
    text: str
    data: list[Data] = field(default_factory=list)
    verdict: Verdict | None = None
    damaged: bool = False  # it came damaged to the board: send it again


class Inbox:
    """Take the board's lines one by one, with the host's time at which each came.

    Not safe for threads by itself. every: frames from one telemetry line to the next, 0 for
    none, None while unknown; only while it is known are missed frames counted.
    """

    def __init__(self) -> None:
        self.hello: Hello | None = None
        self.heard = False  # a line of this protocol came
        self.foreign = b""  # the last one that made no sense
        self.protocol: int | None = None  # that of a greeting with a right CRC, of any form
        self.pending: Pending | None = None
        self.notice: RobotError | None = None
        self.states = StateTracker()
        self.quiet_s = 0.0  # listened to since the last frame
        self.clock = BoardClock()
        self.losses = Losses()
        self.latest: Telemetry | None = None
        self.unread: deque[Telemetry] = deque(maxlen=MOST_UNREAD)
        self.in_session = False
        self._session_s = 0.0
        self._counted: int | None = None  # the frame from which to count
        self.every: int | None = None

    def expect(self, frames_a_line: int | None) -> None:
        """Count missed frames from now on by one telemetry line in so many frames."""
        if frames_a_line != self.every:
            self.every, self._counted, self.quiet_s = frames_a_line, None, 0.0

    @property
    def frame_us(self) -> int:
        """Return the time from frame to frame, which depends on the number of joints."""
        return self.hello.frame_us if self.hello else FRAME_US

    @property
    def telemetry_s(self) -> float:
        """Return the time from one telemetry line to the next, 0 if there are none or unknown."""
        return (self.every or 0) * self.frame_us * 1e-6

    def ask(self, number: int, text: str) -> Pending:
        """Note the command that goes out now; what comes for it is put into what is returned."""
        self.pending = Pending(number, text)
        self.states.asking(text)
        return self.pending

    def open_session(self, host_s: float) -> None:
        """From now on a greeting means a reset; counts start anew."""
        self.in_session, self._session_s = True, host_s
        self.clock, self.losses, self.latest = BoardClock(self.frame_us), Losses(), None
        self._counted, self.quiet_s = None, 0.0
        self.unread.clear()

    def drop_unread(self) -> None:
        """Count the frames that wait as unread, and drop them."""
        self.losses.unread_frames += len(self.unread)
        self.unread.clear()

    def take(self, line: bytes, host_s: float) -> None:
        """Sort in one line; raise RobotReset if it shows that the board started again."""
        try:
            message = parse(line)
        except DamagedLine:
            self._take_damaged(line)
            start = line.rfind(b"hello: ")
            if start > 0:  # a reset cut a line short, and the greeting followed in the same line
                self.take(line[start:], host_s)
            return
        self.heard = True
        if isinstance(message, Telemetry):
            self._take_frame(message, host_s)
        elif isinstance(message, Hello):
            self._take_hello(message, host_s)
        elif isinstance(message, Verdict):
            self._take_verdict(message)
        else:
            self._take_data(message)

    def _take_damaged(self, line: bytes) -> None:
        self.losses.damaged_lines += 1
        self.foreign = line
        with suppress(DamagedLine):
            match = re.match(r"hello: serpenoid.* protocol=(\d{1,5})\b", unseal(line), re.ASCII)
            self.protocol = int(match[1]) if match else self.protocol

    def _take_hello(self, hello: Hello, host_s: float) -> None:
        if not self.in_session:
            self.hello, self.protocol = hello, hello.protocol
        elif hello != self.hello or not self._was_asked_for(host_s):
            raise self._started_again(hello.boot, hello.reset)

    def _started_again(self, boot: int, cause: str) -> RobotReset:
        last_boot = self.hello.boot if self.hello else "none"
        return _reset(f"the board started again (boot {last_boot}, now {boot}; cause: {cause})")

    def _was_asked_for(self, host_s: float) -> bool:
        by_hand = self.pending is not None and self.pending.text.strip() == "hello"
        # Soon after a session opened, a greeting may still answer an earlier asking.
        return by_hand or host_s <= self._session_s + 0.5

    def _take_verdict(self, verdict: Verdict) -> None:
        pending = self.pending
        if not pending or pending.verdict:
            return
        if verdict.number == pending.number:
            pending.verdict = verdict
            self.states.answered(pending.text, verdict.accepted)
            cadence = "set every ", "set silence ", "load", "defaults"  # commands that change it
            if verdict.accepted and " ".join(pending.text.split()).startswith(cadence):
                self.expect(None)
        elif verdict.mark == "?":
            pending.damaged = True

    def _take_data(self, data: Data) -> None:
        pattern = r"state=([a-z]+) .*\bboot=(\d{1,5})\b"
        status = re.match(pattern, data.text, re.ASCII) if data.word == "status" else None
        if status:
            self.states.hear(status[1])
        if status and self.in_session and self.hello and int(status[2]) != self.hello.boot:
            raise self._started_again(int(status[2]), "its greeting was lost")
        if data.word == "state":
            state, _, why = data.text.partition(" ")
            self._judge(state, by_silence=why == "why=silence")
        elif self.pending:
            self.pending.data.append(data)

    def _judge(self, state: str, *, by_silence: bool = False) -> None:
        """Keep the first surprise for the program's next call."""
        self.states.hear(state)
        if self.in_session:
            surprise = self.states.surprise(state, by_silence=by_silence)
            self.notice = self.notice or surprise

    def _take_frame(self, frame: Telemetry, host_s: float) -> None:
        joints = len(frame.setpoint_rad)
        if self.in_session and self.hello and joints != self.hello.joints:
            raise ProtocolMismatch(
                f"the board greeted with {self.hello.joints} joints, and a frame has {joints}: is "
                "another program's board on this wire? else flash it anew: `serpenoid flash`"
            )
        last = self.latest
        gap = (frame.frame - last.frame) & 0xFFFFFFFF if last else 1
        if self.in_session and last and gap >= 1 << 31:
            raise _reset(f"the board's frames went back from {last.frame} to {frame.frame}")
        if not gap:
            return
        if self.every and self._counted is not None:
            passed = (frame.frame - self._counted) & 0xFFFFFFFF
            self.losses.missed_frames += max(passed // self.every - 1, 0)
        self._counted = frame.frame
        self.latest, self.quiet_s = frame, 0.0
        self._judge(frame.state)
        self.clock.add(host_s, frame.frame, frame.board_us)
        if len(self.unread) == MOST_UNREAD:
            self.losses.unread_frames += 1
        self.unread.append(frame)


def _reset(what: str) -> RobotReset:
    return RobotReset(
        f"{what}: it forgot its motion and stands idle; look for a loose cable, a brown-out or "
        "another program opening the port, then start again"
    )
