"""A conversation typed by a person: a line is a command, and what the board says is shown."""

from __future__ import annotations

import sys
from contextlib import suppress

from ...base.errors import BadInput, DamagedLine, RobotUnattended, StateUnasked
from ...base.files import visible
from ..robot import RobotBoard
from ..wire.protocol import Telemetry, Verdict, parse, unseal

HELP = "type `help` and Enter; a line with ! stops the robot; Ctrl-C or Ctrl-D stops it and leaves"

UNATTENDED_S = 86400.0  # a person may think between two lines


class MonitoredBoard(RobotBoard):
    """A board whose lines are printed as they come, once it is opened.

    every: print so many telemetry lines as one. Verdicts on pings are left out.
    """

    def __init__(self, port: str | None, every: int):
        super().__init__(port, unattended_s=UNATTENDED_S)
        self._every, self._frames = every, 0
        self.gone: OSError | None = None  # why nothing can be printed any more
        self.shown = False

    def _heard(self, line: bytes) -> None:
        try:
            text = self._text(line)
            if text and (self.shown or text.startswith("hello:")):
                print(visible(text), flush=True)
        except OSError as error:  # the reader must outlive a screen that is gone
            if self.gone is None:
                self._halt()
            self.gone = self.gone or error

    def _text(self, line: bytes) -> str:
        """Return a line of the board as it is shown, "" for one that is left out."""
        try:
            message, text = parse(line), unseal(line)
        except DamagedLine as error:
            return f"damaged: {error}"
        if isinstance(message, Telemetry):
            self._frames += 1
            return "" if self._frames % self._every else text
        asked = self._talk and self._talk.inbox.pending
        answered = asked and isinstance(message, Verdict) and message.number == asked.number
        return "" if answered and asked and asked.text == "ping" else text

    def obey(self, line: str) -> None:
        """Send a typed line, or stop at one with `!`; print what does not end the conversation."""
        if "!" in line:
            self.stop()
        elif text := line.strip():
            try:
                self._send(text)
            except BadInput as error:
                print(visible(str(error)), flush=True)

    def _send(self, text: str) -> None:
        try:
            self.command(text)
        except (RobotUnattended, StateUnasked) as error:  # of what was before
            print(visible(str(error)), flush=True)
            self.command(text)


def converse(port: str | None, every: int) -> None:
    """Open a port and let a person talk until the input ends or Ctrl-C; the robot is stopped.

    Raises what RobotBoard raises, OSError when nothing can be printed any more.
    """
    robot = MonitoredBoard(port, every)
    with suppress(KeyboardInterrupt), robot:
        robot.shown = True
        if sys.stdout is not None and sys.stdout.isatty():  # it may be closed
            print(HELP, flush=True)
        for line in sys.stdin or ():
            if robot.gone is None:
                robot.obey(line)
    if robot.gone is not None:
        raise robot.gone
