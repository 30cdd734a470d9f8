"""A robot to talk to: opened, driven and, however the block is left, stopped."""

from __future__ import annotations

import math
import os
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, TypeVar

from ..model.checks import check_number
from ..model.errors import (
    BadInput,
    CommandRefused,
    DamagedLine,
    NoAnswer,
    ProtocolMismatch,
    RobotClosed,
    RobotError,
)
from .signals import SignalGuard
from .wire.clock import Drift
from .wire.dialogue import Answer, Dialogue, Farewell
from .wire.error_table import ERRORS
from .wire.inbox import Losses
from .wire.link import BAUD, open_link
from .wire.protocol import PROTOCOL, Data, Hello, Telemetry, Verdict
from .wire.record import Recorder
from .wire.reports import JOINTS, Status, Trim, settings_of, status_of, trims_of

if TYPE_CHECKING:
    from ..model.gait import Gait

FLASH = "`serpenoid flash --port {port}`"
BOOT_S = 2.0  # in which a board that opening has reset greets of itself
ASK_S = 0.5
ATTEMPTS = 5
T = TypeVar("T")


class Robot:
    """Drive one robot, inside `with Robot(port) as robot:` only.

    port: such as "/dev/ttyACM0"; None finds the board by its USB id; "virtual" is the firmware's
    own controller in this process, "virtual:fast" the same as fast as it goes. record: a file
    that takes every line of the run as it comes. timeout_s: how long to wait for the board's
    greeting. unattended_s: if the program calls nothing for so long (iterating frames() counts
    as calling), it is taken to hang: the robot is stopped and the next call raises.

    However the block is left - by an exception, Ctrl-C, SIGTERM, SIGHUP - the robot is stopped
    first. Signals are caught in the main thread only: elsewhere, after a kill, the board's own
    silence time has to do. A fork of the process cannot use the robot. Opening raises
    PortMissing, PortBusy, NoAnswer or ProtocolMismatch; any call may raise RobotLost (unplugged
    or hung), RobotReset (it started again), RecordingFailed (disk full) or RobotUnattended.
    Angles are in radians; joints count from the tail.
    """

    def __init__(
        self,
        port: str | None = None,
        *,
        record: Path | None = None,
        timeout_s: float = 5.0,
        unattended_s: float = 60.0,
    ):
        self._port = port
        self._record = None if record is None else Path(record)
        self._timeout_s = check_number("timeout_s", timeout_s, 0.0, open_low=True)
        self._unattended_s = check_number("unattended_s", unattended_s, 0.0, open_low=True)
        self._talk: Dialogue | None = None
        self._recorder: Recorder | None = None
        self._signals = SignalGuard(self._halt)
        self._process = os.getpid()

    def __enter__(self) -> Robot:
        if self._talk is not None:
            raise RobotClosed("this Robot has been used already; make a new one")
        self._signals.install()
        try:
            self._open()
        except BaseException as error:
            self._leave(error)
            raise
        return self

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
        assert hello is not None  # or opening had failed
        return hello

    @property
    def clock(self) -> Drift:
        """Return how fast the board's clock runs against the host's, so far, with its s.d."""
        return self._dialogue.inbox.clock.drift()

    @property
    def losses(self) -> Losses:
        """Return the counts of what did not arrive whole since opening."""
        return self._dialogue.losses

    @property
    def latest(self) -> Telemetry | None:
        """Return the last frame that came, None before the first."""
        return self._dialogue.inbox.latest

    def true_rate_rad_s(self, omega_rad_s: float) -> tuple[float, float]:
        """Return the rate in host seconds of a gait commanded at omega, and its s.d."""
        return self.clock.true_rate(omega_rad_s)

    def command(self, text: str) -> tuple[Verdict, list[Data]]:
        """Send one command as PROTOCOL.md writes it; return the verdict and the data lines.

        Sent again, under the same number, until the verdict comes; raises RobotLost if none
        does, BadInput if the board could not read such a line. A refusal is a verdict too.
        """
        answer = self._command(text)
        return answer.verdict, answer.data

    def gait(self, gait: Gait) -> None:
        """Ramp into a gait (Eq. 57); raise CommandRefused beyond joint limits or servo speed.

        The lag is taken modulo a full turn, which changes nothing.
        """
        lag_rad = math.remainder(gait.beta_rad, 2 * math.pi)
        fields = [_degrees(gait.alpha_rad), _degrees(lag_rad), _digits(gait.omega_rad_s)]
        self._obeyed(" ".join(["gait", *fields, _degrees(gait.offset_rad)]))

    def pose(self, angles_rad: Sequence[float]) -> None:
        """Move the five joints, tail first, to angles at the board's `pose_speed`."""
        if len(angles_rad) != JOINTS:
            raise BadInput(f"a pose has {JOINTS} angles, one a joint, not {len(angles_rad)}")
        self._obeyed(" ".join(["pose", *(_degrees(a) for a in angles_rad)]))

    def straight(self) -> None:
        """Move all joints to 0."""
        self._obeyed("pose straight")

    def bent(self, lambda_rad: float) -> None:
        """Move the joints to +lambda, -lambda, +lambda, ..., as the calibration needs it."""
        self._obeyed(f"pose bent {_degrees(lambda_rad)}")

    def stop(self) -> None:
        """Freeze all joints now; return when the board has confirmed it."""
        _accept("stop", self._dialogue.stop())

    def idle(self) -> None:
        """Stop and let the servos go limp."""
        self._obeyed("idle")

    def settings(self) -> dict[str, float]:
        """Return the board's settings by name, in the units of PROTOCOL.md."""
        found = self._asked("set", settings_of)
        self._dialogue.inbox.every = int(found["every"])
        self._dialogue.feed(found["silence"])
        return found

    def set(self, name: str, value: float) -> None:
        """Change a setting, in the unit of PROTOCOL.md; save() makes it outlive the power."""
        self._obeyed(f"set {_word(name)} {_digits(value)}")

    def trims(self) -> tuple[Trim, ...]:
        """Return the five servos' trims, tail first."""
        return self._asked("trim", trims_of)

    def trim(self, joint: int, field: str, value: float) -> None:
        """Change one field (centre, scale, dir, low, high) of joint 1 to 5; units: PROTOCOL.md."""
        self._obeyed(f"trim {joint:d} {_word(field)} {_digits(value)}")

    def save(self) -> None:
        """Write settings and trims to the board's EEPROM; return when they were read back."""
        self._obeyed("save")

    def load(self) -> None:
        """Take settings and trims from the board's EEPROM; it must be idle."""
        self._obeyed("load")

    def defaults(self) -> None:
        """Take settings and trims from the firmware; the EEPROM stays. It must be idle."""
        self._obeyed("defaults")

    def status(self) -> Status:
        """Return the board's state and counters."""
        return self._asked("status", status_of)

    def frames(self, duration_s: float | None = None) -> Iterator[Telemetry]:
        """Iterate over the frames that come from now on, for a time or without end.

        Frames wait for a slow program, up to five minutes of them; older ones are then counted
        in losses.unread_frames. Iterating keeps the robot going.
        """
        if duration_s is not None:
            check_number("duration_s", duration_s, 0.0)
        self._dialogue.forget_frames()
        return self._frames(math.inf if duration_s is None else duration_s)

    def _frames(self, duration_s: float) -> Iterator[Telemetry]:
        dialogue = self._dialogue
        end_s = dialogue.link.now_s() + duration_s
        while (frame := dialogue.next_frame(end_s)) is not None:
            yield frame

    @property
    def _dialogue(self) -> Dialogue:
        if self._talk is None:
            raise RobotClosed("the robot is not open; use it inside `with Robot(port) as robot:`")
        if os.getpid() != self._process:
            raise RobotClosed("the robot belongs to the process that opened it, not to its fork")
        return self._talk

    def _obeyed(self, text: str) -> None:
        _accept(text, self._command(text))

    def _command(self, text: str) -> Answer:
        answer = self._dialogue.command(text)
        if self._dialogue.inbox.every is None:  # this command may have changed it
            self.settings()
        return answer

    def _asked(self, text: str, read: Callable[[list[Data]], T]) -> T:
        """Ask until every line of the answer came whole; verdicts are repeated, data are not."""
        for _ in range(ATTEMPTS):
            answer = self._dialogue.command(text)
            _accept(text, answer)
            with suppress(DamagedLine):
                return read(answer.data)
        raise DamagedLine(f"{ATTEMPTS} answers to {text!r} came damaged; check cable and ground")

    def _halt(self) -> None:
        if self._talk is not None and os.getpid() == self._process:
            with suppress(RobotError):
                self._talk.halt()

    def _open(self) -> None:
        link = open_link(self._port)
        try:
            if self._record is not None:
                self._recorder = Recorder(self._record, link.now_s())
        except BaseException:
            link.close()
            raise
        self._talk = Dialogue(link, self._recorder, self._unattended_s)
        self._talk.start()
        self._greet(self._talk, link.name)
        try:
            self.settings()
        except (DamagedLine, CommandRefused):  # missed frames are counted by the default then
            self._talk.inbox.every = 1

    def _greet(self, talk: Dialogue, port: str) -> None:
        """Wait for the greeting, which most boards give when opened, and ask for it."""
        link = talk.link
        end_s = link.now_s() + self._timeout_s
        talk.wait(lambda: _heard(talk), link.now_s() + min(BOOT_S, self._timeout_s / 2))
        while link.now_s() < end_s:
            _check_protocol(talk, port)
            if talk.open_session(min(ASK_S, end_s - link.now_s())):
                _check_protocol(talk, port)
                return
        raise _no_answer(talk, port, self._timeout_s)

    def _leave(self, error: BaseException | None) -> None:
        self._signals.held = True
        talk, farewell = self._talk, None
        try:
            if talk is not None:
                farewell = talk.leave()
                talk.link.close()
            self._end_recording(error)
        finally:
            self._signals.restore()
        if talk is not None and farewell is not None:
            _tell(talk, farewell, error)

    def _end_recording(self, error: BaseException | None) -> None:
        why = error or (self._talk.failure if self._talk else None)
        if self._recorder is None:
            return
        with suppress(RobotError):  # it is told already, or the end row alone is missing
            text = " ".join(f"{type(why).__name__}: {why}".split())
            self._recorder.close("closed" if why is None else text)
        if self._talk is None or not self._talk.inbox.in_session:
            self._recorder.discard()


def _tell(talk: Dialogue, farewell: Farewell, error: BaseException | None) -> None:
    """Raise what went wrong unseen, unless another error is on its way already."""
    if error is None and farewell.unseen:
        raise farewell.unseen
    if not farewell.stopped and error is not talk.failure:
        warnings.warn(
            f"the board on {talk.link.name} did not confirm the stop: it stops by itself within "
            "its silence time, if that is not off; otherwise cut its power",
            RuntimeWarning,
            stacklevel=4,
        )


def _heard(talk: Dialogue) -> bool:
    return talk.inbox.heard or b"hello: " in talk.inbox.foreign


def _check_protocol(talk: Dialogue, port: str) -> None:
    hello, foreign = talk.inbox.hello, talk.inbox.foreign
    found = hello.protocol if hello else None
    if not hello and (said := re.search(rb"hello: serpenoid.* protocol=(\d+)", foreign)):
        found = int(said[1])
    if found is not None and found != PROTOCOL:
        raise ProtocolMismatch(
            f"the board speaks protocol {found}, this program protocol {PROTOCOL}; flash the "
            f"firmware that belongs to it: {FLASH.format(port=port)}"
        )


def _no_answer(talk: Dialogue, port: str, timeout_s: float) -> NoAnswer:
    flash = FLASH.format(port=port)
    if talk.inbox.heard:
        what = "lines came, but no greeting for ours: another program may write to it too"
    elif talk.inbox.foreign:
        what = (
            f"what came is not of this firmware at {BAUD} baud, such as "
            f"{talk.inbox.foreign[:40]!r}; if this is the robot, flash it: {flash}"
        )
    else:
        what = f"nothing came; is this the robot's port, and is it flashed? {flash}"
    return NoAnswer(f"no greeting from {port} within {timeout_s:g} s: {what}")


def _accept(text: str, answer: Answer) -> None:
    verdict = answer.verdict
    if verdict.accepted:
        return
    known = ERRORS.get(verdict.error)
    detail = verdict.detail or (f"- {known.cause}; {known.cure}" if known else "")
    raise CommandRefused(f"the board refuses {text!r}: {verdict.error} {detail}", verdict.error)


def _digits(value: float) -> str:
    """Write a number as the wire takes it: at most 6 decimals, no exponent."""
    if not math.isfinite(value):
        raise BadInput(f"{value} cannot be sent; every number must be finite")
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _degrees(angle_rad: float) -> str:
    return _digits(math.degrees(angle_rad))


def _word(name: str) -> str:
    if not re.fullmatch(r"[a-z_]+", name):
        raise BadInput(f"{name!r} is no name of a setting or field; see firmware/PROTOCOL.md")
    return name
