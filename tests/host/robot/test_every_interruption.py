"""Ctrl-C before every third line of opening and leaving a run: the robot is left in order."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import pytest
import serpenoid.robot
from serpenoid import Gait
from serpenoid.robot import RobotBoard

ROOM = str(Path(serpenoid.robot.__file__).parent)
GAIT = Gait(0.5, 1.4, 5.0)
HANDLERS = {
    signal.SIGINT: signal.default_int_handler,
    signal.SIGTERM: signal.SIG_DFL,
    signal.SIGHUP: signal.SIG_DFL,
    signal.SIGQUIT: signal.SIG_DFL,
}


class Interruptions:
    """Count the lines of this room that the main thread is about to execute; act at chosen ones."""

    def __init__(self, *at: int):
        self.at, self.lines = at, 0

    def __enter__(self) -> Interruptions:
        sys.settrace(self._trace)
        return self

    def __exit__(self, *_: object) -> None:
        sys.settrace(None)

    def _trace(self, frame, event, _):
        if not frame.f_code.co_filename.startswith(ROOM):
            return None
        if event == "line":
            self.lines += 1
            if self.lines in self.at:
                # As the interpreter calls it: with the frame that was interrupted.
                signal.getsignal(signal.SIGINT)(signal.SIGINT, frame)
        return self._trace


@pytest.fixture(autouse=True)
def usual_handlers():
    before = {number: signal.signal(number, usual) for number, usual in HANDLERS.items()}
    yield
    for number, usual in before.items():
        signal.signal(number, usual)


def run(path, *at):
    """Drive the virtual robot and leave it; return the lines of Python that this took."""
    with Interruptions(*at) as done:
        with RobotBoard("virtual:fast", record=path) as robot:
            robot.gait(GAIT)
            for _ in robot.frames(0.1):
                pass
    return done.lines


def handlers():
    return {number: signal.getsignal(number) for number in HANDLERS}


def check_left(path):
    assert handlers() == HANDLERS
    if path.is_file() and path.stat().st_size:  # an empty file holds nothing, and is free
        assert b"\n# end: " in path.read_bytes()


def test_a_run_interrupted_at_any_line_is_left_in_order(tmp_path):
    total = run(tmp_path / "whole")
    early = range(1, 150, 3)  # opening: wire, recording, threads
    points = [*early, *range(150, total - 300, 40), *range(total - 300, total, 3)]
    interrupted = 0
    for at in points:
        path = tmp_path / f"{at}"
        try:
            run(path, at, at + 1 + at % 13)  # and an impatient second one
        except KeyboardInterrupt:
            interrupted += 1
        check_left(path)
    assert interrupted > 0.8 * len(points)  # how often threads are waited for differs
