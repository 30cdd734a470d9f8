"""The one family of exceptions: whatever serpenoid raises on purpose is a SerpenoidError."""

from __future__ import annotations

from typing import Any


class SerpenoidError(Exception):
    """Base of every error raised on purpose: what happened, the value, the limits, the way out."""


class BadInput(SerpenoidError, ValueError):
    """A parameter, a file or a state is outside what the models or the robot allow."""


class NotConverged(SerpenoidError, ArithmeticError):
    """An iteration ended without reaching the accuracy that was asked for.

    best: the best result there is, with the error that it has; None where there is none.
    """

    def __init__(self, message: str, best: Any = None):
        super().__init__(message)
        self.best = best


class StepTooLarge(SerpenoidError, ArithmeticError):
    """A time step is outside the stability region of its method for this scene."""


class Diverged(SerpenoidError, ArithmeticError):
    """A run left the finite numbers; names the time, the cause and a step that works."""


class ClusterFailed(SerpenoidError):
    """A cluster does not answer, has no worker, or lost a piece of work for good."""


class RobotError(SerpenoidError):
    """Something between the host and the board went wrong."""


class DamagedLine(RobotError):
    """A line from the board cannot be trusted; it is to be counted, never used."""


class PortMissing(RobotError):
    """There is no such port, it is no serial port, or the board on it cannot be picked out."""


class PortBusy(RobotError):
    """The port is there, but another program has it or this user may not open it."""


class NoAnswer(RobotError):
    """The port opened, but no board with this firmware greeted in time."""


class ProtocolMismatch(RobotError):
    """The board speaks another version of the protocol; it must be flashed."""


class RobotLost(RobotError):
    """The wire to the board broke while it was in use: unplugged, hung, or silent."""


class StopUnconfirmed(RobotLost):
    """The board did not confirm that it stopped, or refused to: it may be moving still."""


class FramesMissing(RobotError):
    """Telemetry that was asked for did not come, or too little of it."""


class StateUnasked(RobotError):
    """The board left the motion that was asked for, though this program told it nothing."""


class ClockWrong(RobotError):
    """The board's clock is further off than a resonator can be: its rates mean nothing here."""


class RobotReset(RobotError):
    """The board started again in mid-run: it forgot its motion and stands idle."""


class RobotClosed(RobotError):
    """The robot was used outside its `with` block."""


class RobotHeld(RobotError):
    """A motion was asked for after stop(stay=True) and before release()."""


class RobotUnattended(RobotError):
    """The motion was ended because the program gave no sign of life for too long."""


class RecordingFailed(RobotError):
    """The recording cannot go on or cannot be read; what was written before is whole."""


class FlashFailed(RobotError):
    """The firmware could not be built or put on the board; says which, and what to do."""


class CommandRefused(RobotError):
    """The board answered a command with `err:`; nothing changed on it.

    word: which error of firmware/PROTOCOL.md's table, such as "range" or "motion".
    """

    def __init__(self, message: str, word: str):
        super().__init__(message)
        self.word = word
