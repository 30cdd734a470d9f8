"""Random programs against boards with random faults: each ends by name, no robot moves on."""

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
MOST_S = 90.0  # of the board's time that a run may take
MOVING = ("gait", "safing")


def losing(*words: bytes) -> Callable[[random.Random, bytes], bytes]:
    """Return a fault that loses the lines which start with one of the words."""
    return lambda _rng, line: b"" if line.startswith(words) else line


def noisy(rng: random.Random, line: bytes) -> bytes:
    """Flip a bit of every second line."""
    at, wrong = rng.randrange(len(line)), bytearray(line)
    wrong[at] ^= (1 << rng.randrange(8)) * rng.randrange(2)
    return bytes(wrong)


TO_HOST = {
    "mute": lambda _rng, _line: b"",
    "no telemetry": losing(b"t:"),
    "no verdicts": losing(b"ok:", b"err:"),
    "no data": losing(b"set:", b"trim:", b"status:", b"counters:", b"state:"),
    "loses lines": lambda rng, line: line * rng.randrange(2),
    "says lines twice": lambda rng, line: line * rng.randint(1, 2),
    "noise": noisy,
    "garbage": lambda rng, line: rng.randbytes(rng.randrange(60)) + line,
}
TO_BOARD = {
    "deaf": lambda _rng, _data: b"",
    "loses commands": lambda rng, data: data * rng.randrange(2),
    "noise to the board": noisy,
}
HAPPENS = {
    "reset": lambda board: board.boot("brownout"),
    "key": lambda board: board.write(STOP),
    "limp": lambda board: board.write(b"\nbye\nidle\n"),
    "hangs": lambda board: board.stall(3.0),
}


class FaultyBoard(FastBoard):
    """A board with up to three faults, each for a time.

    Noise spares the stop key; where the board is deaf its silence timer has to stop the robot.
    """

    def __init__(self, rng: random.Random):
        super().__init__(partial(self._spoilt, TO_HOST), partial(self._spoilt, TO_BOARD))
        self._rng = rng
        self.faults = {}
        for kind in rng.choices([*TO_HOST, *TO_BOARD, *HAPPENS], k=rng.randrange(4)):
            begun_s = rng.uniform(0.0, 3.0)
            self.faults[kind] = begun_s, begun_s + rng.choice((0.2, 3.0, math.inf))

    def _active(self, kinds: dict) -> list[str]:
        now_s = self.board.time_s
        return [k for k, (a, b) in self.faults.items() if k in kinds and a <= now_s < b]

    def read(self, timeout_s: float) -> bytes:
        for kind in self._active(HAPPENS):
            del self.faults[kind]
            HAPPENS[kind](self.board)
        return super().read(timeout_s)

    def _spoilt(self, kinds: dict, line: bytes) -> bytes:
        if line in (b"\n", b"!\n") and not self._active({"deaf": None}):
            return line
        for kind in self._active(kinds):
            line = kinds[kind](self._rng, line) if line else line
        return line


def some_gait(rng: random.Random) -> Gait:
    return Gait(math.radians(rng.uniform(5, 40)), rng.uniform(-2, 2), rng.uniform(0.5, 8))


def some_program(rng: random.Random, record: Path) -> None:
    """Talk to a robot in a random way."""
    with RobotBoard("any", record=record, timeout_s=3.0) as robot:
        for _ in range(rng.randrange(1, 6)):
            rng.choice(
                [
                    lambda: robot.gait(some_gait(rng)),
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
def test_any_program_with_any_board_ends_well_or_by_name(seed, monkeypatch, tmp_path):
    rng, record = random.Random(seed), tmp_path / "run.txt"
    link = FaultyBoard(rng)
    monkeypatch.setattr("serpenoid.robot.robot.open_link", lambda _port: link)
    ended = "well"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            some_program(rng, record)
    except SerpenoidError as error:
        ended = f"with {error!r}"
    told = f"{link.faults}, ended {ended}"
    assert link.board.time_s < MOST_S, told
    assert ended != "well" or link.board.state not in MOVING, told
    link.board.run(20.0)
    assert link.board.state not in MOVING, told
    if record.exists():  # whatever came, what was recorded loads
        assert load_stream(record).end is not None
