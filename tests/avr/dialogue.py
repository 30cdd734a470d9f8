"""Speak the robot's protocol (firmware/PROTOCOL.md) with a simulated board, in simulated time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from avr.board import Board, Line
from serpenoid.robot.wire.protocol import crc, parse, unseal

JOINTS = 5
COLUMNS = (  # of a frame as the host reads it, in the order of Telemetry below
    *("frame", "board_us", "phase_rad", "setpoint_rad", "pulse_us"),
    *("exec_us", "late_us", "clipped"),
)


def sealed(body: str) -> bytes:
    """Return the line as it goes over the wire: body, CRC, line end."""
    return f"{body} *{crc(body):04X}\n".encode()


def unsealed(line: Line) -> str:
    """Return the body of a line from the board; DamagedLine unless its CRC is right."""
    return unseal(line.text.encode())


def fields(body: str) -> dict[str, str]:
    """Split `word name=value ...` into its named values."""
    return dict(word.split("=", 1) for word in body.split() if "=" in word)


@dataclass(frozen=True)
class Telemetry:
    """Telemetry lines as arrays: frame (N,), time and widths in microseconds, angles in radians."""

    cycle: np.ndarray
    frame: np.ndarray
    time_us: np.ndarray
    phase_rad: np.ndarray
    angle_rad: np.ndarray
    pulse_us: np.ndarray
    exec_us: np.ndarray
    late_us: np.ndarray
    clipped: np.ndarray
    state: list[str]


def telemetry(lines: list[Line]) -> Telemetry:
    """Parse the telemetry among the lines, every CRC checked."""
    found = [(line.cycle, parse(line.text.encode())) for line in lines if line.text[:2] == "t:"]
    columns = [np.array([getattr(row, name) for _, row in found]) for name in COLUMNS]
    cycles = np.array([cycle for cycle, _ in found])
    return Telemetry(cycles, *columns, [row.state for _, row in found])


class Dialogue:
    """A host's end of one session: numbers its lines, awaits each verdict, checks every CRC."""

    def __init__(self, board: Board, last_number: int = 0):
        self.board = board
        self.number = last_number
        self.greeting = unsealed(board.run_until("hello:", 3.0))

    def obey(self, *commands: str) -> Dialogue:
        """Send commands that the board must take; the first one of a session is `hello`."""
        for command in commands:
            verdict = self.ask(command, 5.0)
            assert verdict.startswith("ok:"), (command, verdict)
        return self

    def send(self, command: str) -> int:
        """Send one command and return its number, without awaiting the verdict."""
        self.number = (self.number + 1) % 65536
        self.board.send(sealed(f"#{self.number} {command}"))
        return self.number

    def ask(self, command: str, timeout_s: float = 0.5) -> str:
        """Send a command and return the verdict, e.g. `ok: #3`."""
        return self.ask_data(command, timeout_s)[1]

    def ask_data(self, command: str, timeout_s: float = 0.5) -> tuple[list[str], str]:
        """Send a command; return its data lines (telemetry left out) and its verdict."""
        seen = len(self.board.lines)
        number = self.send(command)
        end = self.board.time_s + timeout_s
        while self.board.time_s < end:
            self.board.run(0.002)
            said = [unsealed(line) for line in self.board.lines[seen:]]
            verdicts = [
                b for b in said if b.split()[:2] in (["ok:", f"#{number}"], ["err:", f"#{number}"])
            ]
            if verdicts:
                return [b for b in said if b[:2] != "t:" and b not in verdicts], verdicts[0]
            assert self.board.runs, f"the board crashed after {command!r}"
        raise AssertionError(f"no verdict on {command!r} within {timeout_s} s; heard {said[-10:]}")

    def keep_alive(self, seconds: float, every_s: float = 0.5) -> None:
        """Let time pass, pinging so that the board does not take silence for an absent host."""
        end = self.board.time_s + seconds
        while end - self.board.time_s > 1e-6:
            self.ask("ping")
            self.board.run(max(0.0, min(every_s, end - self.board.time_s)))

    def counters(self) -> dict[str, int]:
        """Return the board's own counters."""
        data, verdict = self.ask_data("status")
        assert verdict.startswith("ok:"), verdict
        found = fields(" ".join(body for body in data if body.startswith(("counters:", "timing:"))))
        return {name: int(value) for name, value in found.items()}
