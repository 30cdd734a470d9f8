"""A robot's board: opened, driven, and always stopped at the end."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, TypeVar

from ..base.checks import check_number
from ..base.errors import (
    BadInput,
    CommandRefused,
    DamagedLine,
    RecordingFailed,
    RobotClosed,
    RobotError,
    RobotLost,
    RobotUnattended,
    StopUnconfirmed,
)
from .recording.recorder import Recorder, refuse_existing
from .signals import SignalGuard
from .wire.clock import Drift
from .wire.dialogue import Answer, Dialogue
from .wire.encoding import degrees, digits
from .wire.greeting import greet
from .wire.inbox import Losses
from .wire.link import Link, open_link
from .wire.protocol import Data, Hello, Telemetry, Verdict, refused
from .wire.reports import Status, Trim, settings_of, status_of, trims_of

if TYPE_CHECKING:
    from ..model.gait import Gait

T = TypeVar("T")


class RobotBoard:
    """A robot's board to talk to, inside `with RobotBoard(port) as robot:` only.

    port: such as "/dev/ttyACM0"; None finds the board by its USB id; "virtual" is the firmware's
    own controller in this process, "virtual:fast" the same as fast as it goes, and
    "virtual:joints=9" one with so many joints; a Link is taken as it is. joints: how many the robot
    must have, else BadInput before anything moves; None: any number. record: a new file that takes
    every line of the run as it comes. timeout_s: how long to wait for the board's greeting.
    unattended_s: if the program calls nothing for so long (iterating frames() counts as calling),
    it is taken to hang: the robot is stopped and the next call raises.

    When the block ends, also by an exception, Ctrl-C, SIGQUIT, SIGTERM or SIGHUP, and before Ctrl-Z
    suspends the program, the robot is stopped first. If the board did not confirm that,
    StopUnconfirmed is raised; beside an error of the program itself it is a warning. Signals are
    caught in the main thread only: elsewhere, after a kill, the board's own silence time has to
    do. A fork of the process cannot use the robot.

    Opening raises PortMissing, PortBusy, NoAnswer or ProtocolMismatch; any call may raise
    RobotLost (unplugged or hung), RobotReset (it started again), StateUnasked (it left the motion
    that was asked for), RecordingFailed (disk full) or RobotUnattended. stop() may be called from
    any thread at any time; other calls wait for one another. Angles are in radians; joints count
    from the tail.
    """

    def __init__(
        self,
        port: str | Link | None = None,
        *,
        joints: int | None = None,
        record: Path | None = None,
        timeout_s: float = 5.0,
        unattended_s: float = 60.0,
    ):
        self._port, self._joints = port, joints
        self._record = None if record is None else Path(record)
        if self._record is not None:
            refuse_existing(self._record)
        self._timeout_s = check_number("timeout_s", timeout_s, 0.0, open_low=True)
        self._unattended_s = check_number("unattended_s", unattended_s, 0.0, open_low=True)
        self._talk: Dialogue | None = None
        self._recorder: Recorder | None = None
        self._signals = SignalGuard(
            self._halt, (RobotBoard.__exit__, RobotBoard._leave), self._resumed
        )
        self._process = os.getpid()
        self._cut_short = False  # the robot moved when a signal stopped it

    def __enter__(self) -> RobotBoard:
        if self._talk is not None:
            raise RobotClosed("this RobotBoard has been used already; make a new one")
        try:
            self._signals.install()
            self._open()
            return self
        except BaseException as error:
            self._leave(error)
            raise

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if os.getpid() == self._process:  # a fork that leaves must not stop its parent's robot
            self._leave(error)

    @property
    def hello(self) -> Hello:
        """Return the board's greeting: firmware, board, boot id, cause of its last reset."""
        hello = self._dialogue.inbox.hello
        if hello is None:
            raise RobotClosed("opening the robot failed before its greeting came")
        return hello

    @property
    def clock(self) -> Drift:
        """Return how fast the board's clock runs against the host's, so far, with its s.d."""
        return self._dialogue.inbox.clock.drift()

    @property
    def losses(self) -> Losses:
        """Return the counts of what did not arrive whole since opening."""
        return replace(self._dialogue.inbox.losses)

    @property
    def latest(self) -> Telemetry | None:
        """Return the last frame that came, None before the first."""
        return self._dialogue.inbox.latest

    def command(self, text: str) -> tuple[Verdict, list[Data]]:
        """Send one command as PROTOCOL.md writes it; return the verdict and the data lines.

        Sent again, under the same number, until the verdict comes; raises RobotLost if none
        does, BadInput if the board could not read such a line. A refusal is a verdict too.
        """
        return self._ask(text)

    def gait(self, gait: Gait) -> None:
        """Ramp into a gait (Eq. 57); raise CommandRefused beyond joint limits or servo speed.

        The lag is taken modulo a full turn, which changes nothing.
        """
        if gait.joint_gain or gait.joint_shift_rad:
            raise BadInput("a board's gait has no joint_gain or joint_shift_rad; leave them out")
        lag_rad = math.remainder(gait.beta_rad, 2 * math.pi)
        fields = [degrees(gait.alpha_rad), degrees(lag_rad), digits(gait.omega_rad_s)]
        self._obeyed(" ".join(["gait", *fields, degrees(gait.offset_rad)]))

    def pose(self, angles_rad: Sequence[float]) -> None:
        """Move all joints, tail first, to angles in rad, none faster than `pose_speed`."""
        if len(angles_rad) != (joints := self.hello.joints):
            raise BadInput(f"a pose has {joints} angles, one a joint, not {len(angles_rad)}")
        self._obeyed(" ".join(["pose", *(degrees(a) for a in angles_rad)]))

    def straight(self) -> None:
        """Move all joints to 0."""
        self._obeyed("pose straight")

    def stop(self) -> None:
        """Freeze all joints now; return when the board has confirmed it. Safe from any thread.

        The key goes out at once, before whatever other threads are waiting for; the confirmation
        comes after their commands. A motion that another thread is asking for is given up.
        """
        _obey("stop", self._dialogue.stop())

    def idle(self) -> None:
        """Stop and let the servos go limp."""
        self._obeyed("idle")

    def settings(self) -> dict[str, float]:
        """Return the board's settings by name, in the units of PROTOCOL.md."""
        settings = self._answer_of("set", settings_of)
        self._dialogue.inbox.expect(int(settings["every"]))
        self._dialogue.feed(settings["silence"])
        return settings

    def set(self, name: str, value: float) -> None:
        """Set a setting's value, in the unit of PROTOCOL.md; save() makes it outlive the power."""
        self._obeyed(f"set {name} {digits(value)}")

    def trims(self) -> tuple[Trim, ...]:
        """Return all servos' trims, tail first."""
        joints = self.hello.joints
        return self._answer_of("trim", lambda data: trims_of(data, joints))

    def trim(self, joint: int, field: str, value: float) -> None:
        """Set a joint's centre, scale, dir, low or high to a value; units: PROTOCOL.md."""
        self._obeyed(f"trim {digits(joint)} {field} {digits(value)}")

    def save(self, *, unattended: bool = False) -> None:
        """Write settings and trims to the board's EEPROM; return when they were read back.

        With silence off the board refuses, unless unattended: a robot that starts like that goes
        on when its host has gone.
        """
        self._obeyed("save unattended" if unattended else "save")

    def status(self) -> Status:
        """Return the board's state and counters."""
        return self._answer_of("status", status_of)

    def settle(self, most_s: float = 20.0) -> None:
        """Wait until no joint is on its way to a pose, at most most_s, s; else raise RobotLost.

        A pose takes less than 20 s at any pose_speed that the board has.
        """
        talk = self._dialogue
        end_s = talk.link.now_s() + most_s
        while self.status().moving:
            if talk.link.now_s() > end_s:
                raise RobotLost(f"the robot is not there after {most_s:g} s; ask for `status`")
            talk.pass_time(0.05)

    def frames(self, duration_s: float | None = None) -> Iterator[Telemetry]:
        """Iterate over the frames that come from now on, for a time in s or without end.

        Frames wait for a slow program, up to five minutes of them; older ones, and those that
        wait when the time is over, are counted in losses.unread_frames. Iterating keeps the robot
        going; leaving the block, or stop(), ends its motion.
        """
        if duration_s is not None:
            check_number("duration_s", duration_s, 0.0)
        dialogue = self._dialogue
        dialogue.forget_frames()
        end_s = dialogue.link.now_s() + (math.inf if duration_s is None else duration_s)
        return iter(lambda: dialogue.next_frame(end_s), None)

    @property
    def _dialogue(self) -> Dialogue:
        if self._talk is None:
            raise RobotClosed(
                "the robot is not open; use it inside `with RobotBoard(port) as robot:`"
            )
        if os.getpid() != self._process:
            raise RobotClosed("the robot belongs to the process that opened it, not to its fork")
        return self._talk

    def _obeyed(self, text: str) -> None:
        _obey(text, self._ask(text))

    def _ask(self, text: str) -> Answer:
        answer = self._dialogue.ask(text)
        if self._dialogue.inbox.every is None:  # this command may have changed it
            self.settings()
        return answer

    def _answer_of(self, text: str, read: Callable[[list[Data]], T]) -> T:
        """Ask until every line of the answer came whole; verdicts are repeated, data are not."""
        attempts = 5
        for _ in range(attempts):
            answer = self._dialogue.ask(text)
            _obey(text, answer)
            with suppress(DamagedLine):
                return read(answer.data)
        raise DamagedLine(f"{attempts} answers to {text!r} came damaged; check cable and ground")

    def _halt(self) -> None:
        if self._talk is not None and os.getpid() == self._process:
            self._cut_short = self._talk.inbox.states.moves
            with suppress(RobotError):
                self._talk.halt()

    def _resumed(self) -> None:
        if self._talk is not None and self._cut_short:
            self._talk.inbox.notice = RobotUnattended(
                "the program was suspended (Ctrl-Z), so the robot was stopped first; start again"
            )

    def _open(self) -> None:
        link = open_link(self._port)
        try:
            if self._record is not None:
                self._recorder = Recorder(self._record, link.now_s())
        except BaseException:
            link.close()
            raise
        record = self._recorder.line if self._recorder else None
        self._talk = Dialogue(link, record, self._unattended_s, self._take_line)
        self._talk.start()
        greet(self._talk, self._timeout_s)
        if self._joints not in (None, self.hello.joints):
            raise BadInput(
                f"this is for a robot of {self._joints + 1} links, but this board moves "
                f"{self.hello.joints + 1} links; take the board of that robot (or --port "
                f"virtual:joints={self._joints}), or choose the robot of this board"
            )
        try:
            self.settings()
        except (DamagedLine, CommandRefused):  # missed frames are counted by the default then
            self._talk.inbox.expect(1)

    def _take_line(self, line: bytes) -> None:
        """Take each line of the board, in the reader's thread; whoever shows them overrides it."""

    def _leave(self, error: BaseException | None) -> None:
        """Stop and close; raise an error that no call has raised yet, or warn of it.

        An error of the program itself is not replaced: beside it, what went wrong is a warning.
        """
        self._signals.held = True
        problems: list[RobotError] = []
        raised = None
        try:
            if self._talk is not None:
                problems += self._talk.leave()
                self._talk.link.close()
            problems += self._end_recording(error)
            if error is None or isinstance(error, (KeyboardInterrupt, SystemExit)):
                raised = next(iter(problems), None)
            else:
                for problem in problems:
                    if not (isinstance(problem, StopUnconfirmed) and isinstance(error, RobotLost)):
                        warnings.warn(str(problem), RuntimeWarning, stacklevel=3)
        finally:
            self._signals.restore(forget=raised is not None)
        if raised:
            raise raised from error

    def _end_recording(self, error: BaseException | None) -> list[RecordingFailed]:
        """Close the recording; return why it is not whole, if that is not told otherwise."""
        if self._recorder is None:
            return []
        failure = self._talk.failure if self._talk else None
        why = error or failure
        unwritten = None
        how = f"{type(why).__name__}: {' '.join(str(why).split())}" if why else "closed"
        try:
            self._recorder.close(how)
        except RecordingFailed as failed:
            unwritten = failed
        if self._talk is None or not self._talk.inbox.in_session:
            self._recorder.discard()
        return [] if unwritten is None or unwritten is failure else [unwritten]


def _obey(text: str, answer: Answer) -> None:
    if not answer.verdict.accepted:
        raise refused(text, answer.verdict.error, answer.verdict.detail)
