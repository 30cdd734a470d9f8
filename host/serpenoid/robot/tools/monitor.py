"""A conversation typed by a person: a line is a command, and what the board says is shown."""

from __future__ import annotations

import sys
from contextlib import suppress

from ...base.errors import BadInput, DamagedLine, RobotError, RobotUnattended, StateUnasked
from ...base.files import visible
from ..robot import RobotBoard
from ..wire.protocol import Telemetry, Verdict, parse, unseal


class MonitoredBoard(RobotBoard):
    """A board whose lines are printed as they come, once it is opened.

    Verdicts on pings are left out, and telemetry but for one line in fifty: one a second.
    """

    def __init__(self, port: str | None):
        super().__init__(port, unattended_s=86400.0)  # a person may think between two lines
        self._frames = 0
        self.shown = False

    def _take_line(self, line: bytes) -> None:
        text = self._text(line)
        try:
            if text and (self.shown or text.startswith("hello:")):
                print(visible(text), flush=True)
        except OSError as error:
            raise RobotError(f"nothing can be shown any more: {error}") from error

    def _text(self, line: bytes) -> str:
        """Return a line of the board as it is shown, "" for one that is left out."""
        try:
            message, text = parse(line), unseal(line)
        except DamagedLine as error:
            return f"damaged: {error}"
        if isinstance(message, Telemetry):
            self._frames += 1
            return "" if self._frames % 50 else text
        pending = self._talk and self._talk.inbox.pending
        is_ping = pending and pending.text == "ping"
        return "" if is_ping and isinstance(message, Verdict) else text

    def obey(self, line: str) -> None:
        """Send a typed line, or stop at one with `!`; print what does not end the conversation."""
        try:
            if "!" in line:
                self.stop()
            elif text := line.strip():
                self.command(text)
        except (BadInput, RobotUnattended, StateUnasked) as error:
            print(visible(str(error)), flush=True)


def converse(port: str | None) -> None:
    """Open a port and let a person talk until the input ends or Ctrl-C; the robot is stopped.

    Raises what RobotBoard raises, RobotError where nothing can be shown any more.
    """
    robot = MonitoredBoard(port)
    with suppress(KeyboardInterrupt), robot:
        robot.shown = True
        if sys.stdout is not None and sys.stdout.isatty():  # it may be closed
            stops = "a line with ! stops the robot; Ctrl-C or Ctrl-D stops it and leaves"
            print(f"type `help` and Enter; {stops}", flush=True)
        for line in sys.stdin or ():
            robot.obey(line)
