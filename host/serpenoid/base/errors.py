"""The one family of exceptions: bad input, numerics, a cluster, the board; all SerpenoidErrors."""

from __future__ import annotations

from typing import Any


def shortened(text: str) -> str:
    """Return a message without the middle if it is long: begin and way out stay."""
    half = 1000  # characters of either part: text from outside may be a megabyte
    return text if len(text) <= 2 * half else f"{text[:half]} [...] {text[-half:]}"


class SerpenoidError(Exception):
    """Base of every error raised on purpose: what happened, the value, the limits, the way out.

    Way out: in the message.

    Examples
    --------
    >>> try:
    ...     sn.Robot(links=1, link_mass_kg=0.1, link_length_m=0.1)
    ... except sn.SerpenoidError as error:
    ...     print(type(error).__name__)
    BadInput
    """

    def __str__(self) -> str:
        return shortened(super().__str__())


class BadInput(SerpenoidError, ValueError):
    """A parameter, a file or a state is outside what the models or the robot allow.

    Way out: the message names the value, the limits and, of a file, the line: change it there.

    Examples
    --------
    >>> sn.Ground(ct=-1.0, cn=10.0)
    Traceback (most recent call last):
    serpenoid.base.errors.BadInput: ct is -1.0; it must be a finite number, at least 0
    """


class NotConverged(SerpenoidError, ArithmeticError):
    """An iteration ended without reaching the accuracy that was asked for.

    Way out: ask for less (a larger rtol or accuracy), or take `best` with the error that it
    tells.

    best: the best result there is, with the error that it has; None where there is none.

    Examples
    --------
    >>> issubclass(sn.NotConverged, sn.SerpenoidError)
    True
    """

    def __init__(self, message: str, best: Any = None):
        super().__init__(message)
        self.best = best


class StepTooLarge(SerpenoidError, ArithmeticError):
    """A time step is outside the stability region of its method for this scene.

    Way out: take the step or the method that the message names.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> scene = sn.Scene(robot, ground, gait, formulation="implicit", method="rk4", dt_s=0.1)
    >>> try:
    ...     sn.simulate(scene)
    ... except sn.StepTooLarge:
    ...     print("refused")
    refused
    """


class Diverged(SerpenoidError, ArithmeticError):
    """A run grew without bound; names the time, the cause and a step that works.

    Way out: take the step or the method that the message names.

    Examples
    --------
    >>> issubclass(sn.Diverged, sn.SerpenoidError)
    True
    """


class ClusterFailed(SerpenoidError):
    """A cluster does not answer, has no worker, or lost a piece of work for good.

    Way out: see that scheduler and workers run, with the same version of this package.
    """


class RobotError(SerpenoidError):
    """Something between the host and the board went wrong.

    Way out: that of the exceptions below.
    """


class DamagedLine(RobotError):
    """A line from the board cannot be trusted; it is to be counted, never used.

    Way out: none is needed for one; if many come, shorten the cable or check its ground.
    """


class PortMissing(RobotError):
    """There is no such port, it is no serial port, or the board on it cannot be picked out.

    Way out: `serpenoid ports` lists what is there; name it with --port.
    """


class PortBusy(RobotError):
    """The port is there, but another program has it or this user may not open it.

    Way out: close the program named, or join the group that owns the port (dialout on Debian).
    """


class NoAnswer(RobotError):
    """The port opened, but no board with this firmware greeted in time.

    Way out: `serpenoid doctor` finds the cause; `serpenoid flash` puts the firmware on the
    board.
    """


class ProtocolMismatch(RobotError):
    """The board speaks another version of the protocol; it must be flashed.

    Way out: `serpenoid flash --board BOARD`.
    """


class RobotLost(RobotError):
    """The wire to the board broke while it was in use: unplugged, hung, or silent.

    Way out: plug it in, see that the servos have a supply of their own, `serpenoid doctor`.
    """


class StopUnconfirmed(RobotLost):
    """The board did not confirm that it stopped, or refused to: it may be moving still.

    Way out: cut the servos' power.
    """


class FramesMissing(RobotError):
    """Telemetry that was asked for did not come, or too little of it.

    Way out: close other programs that keep this computer busy; check the cable.
    """


class StateUnasked(RobotError):
    """The board left the motion that was asked for, though this program told it nothing.

    Way out: look what the board says in `serpenoid monitor`: a key, a limit, or its silence
    timer.
    """


class ClockWrong(RobotError):
    """The board's clock is further off than a resonator can be: its rates mean nothing here.

    Way out: the board's crystal is broken or was built for another rate: flash the right
    board's firmware.
    """


class RobotReset(RobotError):
    """The board started again in mid-run: it forgot its motion and stands idle.

    Way out: mostly the servos pull the supply down: give them one of their own.
    """


class RobotClosed(RobotError):
    """The robot was used outside its `with` block.

    Way out: talk to the robot inside `with Robot(...) as robot:` alone.
    """


class RobotUnattended(RobotError):
    """The motion was ended because the program gave no sign of life for too long.

    Way out: read frames(), or call anything else, at least that often.
    """


class RecordingFailed(RobotError):
    """The recording cannot go on or cannot be read; what was written before is whole.

    Way out: make room or name another file; `serpenoid view` shows what is whole.
    """


class FlashFailed(RobotError):
    """The firmware could not be built or put on the board; says which, and what to do.

    Way out: the message has PlatformIO's own last words and the step to take.
    """


class CommandRefused(RobotError):
    """The board answered a command with `err:`; nothing changed on it.

    Way out: by word, in the table of what a board refuses.

    word: which error of firmware/PROTOCOL.md's table, such as "range" or "motion".
    """

    def __init__(self, message: str, word: str):
        super().__init__(message)
        self.word = word
