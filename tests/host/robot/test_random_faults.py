"""Random programs with faulty boards: each ends or raises SerpenoidError, and the robot stops."""

from __future__ import annotations

import math
import random
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from robot.fake_board import FastBoard
from serpenoid import Gait, SerpenoidError
from serpenoid.robot import RobotBoard
from serpenoid.robot.recording.stream import load_stream

STOP = b"\n!\n"
MAX_RUN_S = 90.0  # limit of a run, in the board's time
MOVING = ("gait", "safing")


def lose_lines(*words: bytes) -> Callable[[random.Random, bytes], bytes]:
    """Return a fault that loses the lines which start with one of the words."""
    return lambda _rng, line: b"" if line.startswith(words) else line


def flip_bit(rng: random.Random, line: bytes) -> bytes:
    """Return the line, every second time with one bit flipped."""
    index, damaged = rng.randrange(len(line)), bytearray(line)
    damaged[index] ^= (1 << rng.randrange(8)) * rng.randrange(2)
    return bytes(damaged)


TO_HOST = {
    "mute": lambda _rng, _line: b"",
    "no telemetry": lose_lines(b"t:"),
    "no verdicts": lose_lines(b"ok:", b"err:"),
    "no data": lose_lines(b"set:", b"trim:", b"status:", b"counters:", b"state:"),
    "loses lines": lambda rng, line: line * rng.randrange(2),
    "says lines twice": lambda rng, line: line * rng.randint(1, 2),
    "noise": flip_bit,
    "garbage": lambda rng, line: rng.randbytes(rng.randrange(60)) + line,
}
TO_BOARD = {
    "deaf": lambda _rng, _data: b"",
    "loses commands": lambda rng, data: data * rng.randrange(2),
    "noise to the board": flip_bit,
}
EVENTS = {
    "reset": lambda board: board.boot("brownout"),
    "key": lambda board: board.write(STOP),
    "limp": lambda board: board.write(b"\nbye\nidle\n"),
    "hangs": lambda board: board.stall(3.0),
}


class FaultyBoard(FastBoard):
    """A board with up to three temporary faults.

    Noise does not change the stop key. A deaf board must stop the robot by its silence timer.
    """

    def __init__(self, rng: random.Random):
        super().__init__(partial(self._damage, TO_HOST), partial(self._damage, TO_BOARD))
        self._rng = rng
        self.faults = {}
        for kind in rng.choices([*TO_HOST, *TO_BOARD, *EVENTS], k=rng.randrange(4)):
            start_s = rng.uniform(0.0, 3.0)
            self.faults[kind] = start_s, start_s + rng.choice((0.2, 3.0, math.inf))

    def _active(self, kinds: dict) -> list[str]:
        now_s = self.board.time_s
        times = self.faults.items()
        return [kind for kind, (start, end) in times if kind in kinds and start <= now_s < end]

    def read(self, timeout_s: float) -> bytes:
        for kind in self._active(EVENTS):
            del self.faults[kind]
            EVENTS[kind](self.board)
        return super().read(timeout_s)

    def _damage(self, kinds: dict, line: bytes) -> bytes:
        if line in (b"\n", b"!\n") and not self._active({"deaf": None}):
            return line
        for kind in self._active(kinds):
            line = kinds[kind](self._rng, line) if line else line
        return line


def random_gait(rng: random.Random) -> Gait:
    return Gait(math.radians(rng.uniform(5, 40)), rng.uniform(-2, 2), rng.uniform(0.5, 8))


def run_random_program(rng: random.Random, record: Path) -> None:
    """Send a robot random commands."""
    with RobotBoard("any", record=record, timeout_s=3.0) as robot:
        for _ in range(rng.randrange(1, 6)):
            rng.choice(
                [
                    lambda: robot.gait(random_gait(rng)),
                    lambda: list(robot.frames(rng.uniform(0, 2.5))),
                    lambda: robot.pose([rng.uniform(-0.4, 0.4)] * 5),
                    lambda: robot.set("every", rng.choice((1, 2, 5))),
                    robot.status,
                    robot.trims,
                    robot.stop,
                    robot.idle,
                ]
            )()


@pytest.mark.parametrize("seed", range(15))
def test_any_program_ends_and_no_robot_keeps_moving(seed, monkeypatch, tmp_path):
    rng, record = random.Random(seed), tmp_path / "run.txt"
    link = FaultyBoard(rng)
    monkeypatch.setattr("serpenoid.robot.robot.open_link", lambda _port: link)
    ended = "well"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            run_random_program(rng, record)
    except SerpenoidError as error:
        ended = f"with {error!r}"
    context = f"{link.faults}, ended {ended}"
    assert link.board.time_s < MAX_RUN_S, context
    assert ended != "well" or link.board.state not in MOVING, context
    link.board.run(20.0)
    assert link.board.state not in MOVING, context
    if record.exists():  # every recording can be loaded
        assert load_stream(record).end is not None
