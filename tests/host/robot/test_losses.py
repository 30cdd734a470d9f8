"""Whatever is lost - a stop, frames, verdicts, the clock, the board - no run ends as if well."""

from __future__ import annotations

import itertools
import json
import os
import random
import re
import signal
import time
from collections.abc import Callable
from functools import partial

import pytest
from avr.dialogue import sealed
from command_line import serpenoid
from robot.fake_board import (
    GAIT,
    GAIT_TYPED,
    FakeBoard,
    FastBoard,
    Tamper,
    change_body,
    change_greeting,
    drop_line,
    drop_lines,
    keep_line,
)
from robot.patience import LONG_S, clock
from serpenoid.base.errors import (
    CommandRefused,
    NoAnswer,
    ProtocolMismatch,
    RobotLost,
    StateUnasked,
    StopUnconfirmed,
)
from serpenoid.robot import RobotBoard


def after_gait_frames(count: int, tamper: Tamper) -> Tamper:
    """Return a tamper that acts from the count-th frame of a gait on."""
    seen = 0

    def pass_on(line: bytes) -> bytes:
        nonlocal seen
        seen += b" st=gait" in line
        return tamper(line) if seen > count else line

    return pass_on


def refusing_stop(line: bytes) -> bytes:
    return change_body(line, rb"^ok: (#\d+)$", rb"err: \1 saving - settings are being saved")


def deaf_to_stops(line: bytes) -> bytes:
    """Change every stop into a ping, which a board answers with ok."""
    return change_body(line.replace(b"!", b""), rb"^(#\d+) stop$", rb"\1 ping")


def at_double_pace(line: bytes) -> bytes:
    us = re.search(rb" board_us=(\d+)", line)
    return change_body(line, rb" board_us=\d+", b" board_us=%d" % (2 * int(us[1]))) if us else line


def on_the_way_out(board: FastBoard, word: bytes, act: Callable[[], None]) -> None:
    """Do something once, when a line with a word goes to the board."""

    def watch(line: bytes) -> bytes:
        if word not in line:
            return line
        board.to_board = keep_line
        act()
        return line

    board.to_board = watch


def in_the_gait(tamper: Tamper, count: int = 25) -> Callable[[FastBoard], None]:
    return lambda board: setattr(board, "to_host", after_gait_frames(count, tamper))


def once(board: FastBoard, act: Callable[[], None], then: Tamper = keep_line) -> Tamper:
    """Return a tamper that does something at its first line, and is `then` from there on."""

    def tamper(line: bytes) -> bytes:
        board.to_host = then
        act()
        return then(line)

    return tamper


def reset_in_the_gait(then: Tamper) -> Callable[[FastBoard], None]:
    return lambda board: in_the_gait(once(board, lambda: board.reset("brownout"), then))(board)


def cut_line_and_greeting(line: bytes) -> bytes:
    return b"t:2" + line if line.startswith(b"hello: ") else line


RESET = r"boot \d, now \d; cause: brownout"
LOSSES = {
    "frames end": (in_the_gait(drop_lines("t:"), 50), "no telemetry"),
    "every fifth frame": (
        in_the_gait(lambda line: b"" if re.match(rb"t:\d*[05] ", line) else line, 0),
        "frames came and",
    ),
    "a key of somebody else": (
        lambda board: in_the_gait(once(board, lambda: board.board.write(b"\n!\n")))(board),
        "state 'hold', asked for was 'gait'",
    ),
    "a clock at double pace": (
        lambda board: setattr(board, "to_host", at_double_pace),
        "clock runs",
    ),
    "reset": (reset_in_the_gait(keep_line), RESET),
    "reset, greeting behind half a line": (reset_in_the_gait(cut_line_and_greeting), RESET),
    "reset, greeting lost": (reset_in_the_gait(drop_lines("hello:")), "frames went back from"),
    "reset at the stop": (
        lambda board: on_the_way_out(board, b" stop *", lambda: board.reset("brownout")),
        RESET,
    ),
    "a stop that is refused": (
        lambda board: on_the_way_out(board, b"!", lambda: setattr(board, "to_host", refusing_stop)),
        "refuses 'stop': saving.*power",
    ),
    "a stop that is not obeyed": (
        lambda board: setattr(board, "to_board", deaf_to_stops),
        "not confirmed.*said ok.*'gait'.*cut its power",
    ),
}


@pytest.mark.parametrize("loss", LOSSES)
def test_drive_tells_a_loss_once_and_keeps_the_recording(tmp_path, monkeypatch, loss):
    harm, said = LOSSES[loss]
    board, file = FastBoard(), tmp_path / "run.wire"
    harm(board)
    monkeypatch.setattr("serpenoid.robot.robot.open_link", lambda _: board)
    args = f"--port any --duration-s 2.5 --record {file} --json"
    status, out, errors = serpenoid(f"drive {GAIT_TYPED} {args}")
    assert status == 1, errors
    assert len(re.findall(said, errors)) == 1, errors
    assert "Traceback" not in errors
    assert b"\n# end: " in file.read_bytes()
    if loss == "a clock at double pace":
        assert json.loads(out)["frequency_hz"] is None


noise = random.Random(1)
OLD = sealed("hello: serpenoid fw=9.0.0 protocol=0 name=snake")
OPENINGS = {
    "silent": (drop_line, NoAnswer, "nothing came.*flash"),
    "another baud rate": (
        lambda line: noise.randbytes(len(line)),
        NoAnswer,
        "not of this firmware at 250000 baud",
    ),
    "greetings always damaged": (
        lambda line: line.replace(b" *", b" *0"),
        NoAnswer,
        "not of this firmware.*cable",
    ),
    "another protocol": (
        lambda line: OLD if line.startswith(b"hello") else b"",
        ProtocolMismatch,
        "protocol 0.*protocol 5.*serpenoid flash --port",
    ),
    "other joints than the frames have": (
        change_greeting(b"joints=5", b"joints=12"),
        ProtocolMismatch,
        "12 joints, and a frame has 5",
    ),
}


@pytest.mark.parametrize("board", OPENINGS)
def test_a_board_that_is_none_of_ours_is_told_by_what_came(board):
    tamper, error, said = OPENINGS[board]
    link = FastBoard(tamper)
    with pytest.raises(error, match=said), RobotBoard(link, timeout_s=1.0) as robot:
        list(robot.frames(LONG_S))
    assert b"#0 hello" in link.received or error is ProtocolMismatch


@pytest.mark.parametrize("every", [0, 1])
def test_a_stop_is_sure_though_the_line_on_its_state_was_lost_and_else_told(every):
    board = FastBoard(drop_lines("state:"))
    with pytest.raises(StopUnconfirmed, match=r"not confirmed.*'pose'"):
        with RobotBoard(board) as robot:
            robot.set("every", every)
            robot.set("pose_speed", 1.0)
            robot.pose([0.8] * 5)
            robot.stop()
            assert board.state == "hold"
            robot.pose([-0.8] * 5)
            board.to_board = deaf_to_stops
            with pytest.raises(StopUnconfirmed, match=r"said ok.*'pose'.*cut its power"):
                robot.stop()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_does_not_hide_that_the_stop_is_not_sure(number):
    board = FastBoard()
    with pytest.raises(StopUnconfirmed, match=r"not confirmed: no verdict.*power") as told:
        with RobotBoard(board) as robot:
            robot.gait(GAIT)
            board.to_host = drop_line
            os.kill(os.getpid(), number)
            time.sleep(1.0)
    assert isinstance(told.value.__cause__, (KeyboardInterrupt, SystemExit))


def test_a_loss_that_was_caught_leaves_the_stop_unconfirmed():
    with FakeBoard() as fake, pytest.raises(StopUnconfirmed), RobotBoard(fake.port) as robot:
        robot.gait(GAIT)
        fake.unplug()
        with pytest.raises(RobotLost):
            list(robot.frames(5.0))


def test_an_error_of_the_program_is_not_masked_by_the_loss_of_the_board():
    board = FastBoard()
    with pytest.warns(RuntimeWarning, match="stop was not confirmed"):
        with pytest.raises(ZeroDivisionError), RobotBoard(board) as robot:
            robot.gait(GAIT)
            board.unplug()
            raise ZeroDivisionError


def test_a_state_that_nobody_asked_for_is_told_once_and_one_asked_for_never():
    board = FastBoard()
    with RobotBoard(board) as robot:
        start = partial(robot.gait, GAIT)
        for ask in (robot.stop, start, robot.straight, robot.stop, robot.idle, robot.stop, start):
            ask()
            assert list(robot.frames(0.2))
        board.board.write(b"\n!\n")
        with pytest.raises(StateUnasked, match="'hold'"):
            list(robot.frames(20.0))
        robot.straight()
        assert list(robot.frames(0.1))


def test_a_motion_that_a_stop_overtook_is_not_sent_again_and_a_question_is():
    board = FastBoard()
    with RobotBoard(board) as robot:
        board.to_host = lambda line: change_body(line, rb"^ok: (#\d+)$", rb"err: \1 stopped - by !")
        for ask, asked_again in ((robot.straight, False), (robot.status, True)):
            sent = len(board.received)
            with pytest.raises(CommandRefused, match="stopped"):
                ask()
            assert (board.received[sent:].count(b"\n") > 1) == asked_again
        board.to_host = keep_line


def test_half_and_doubled_frames_are_counted_and_never_used():
    which = itertools.count()

    def spoil(line: bytes) -> bytes:
        if not line.startswith(b"t:"):
            return line
        kind = next(which) % 10
        return {3: line[: len(line) // 2] + b"\n", 5: line * 2, 7: b""}.get(kind, line)

    board = FastBoard()
    with RobotBoard(board) as robot:
        robot.gait(GAIT)
        board.to_host = spoil
        numbers = [frame.frame for frame in robot.frames(4.0)]
        losses, tens = robot.losses, next(which) // 10
        assert numbers == sorted(set(numbers))
        assert losses.damaged_lines == pytest.approx(tens, abs=1)
        assert losses.missed_frames == pytest.approx(2 * tens, abs=2)
        board.to_host = keep_line


@pytest.mark.parametrize("moment", ["hello", "set", "gait", "frames", "pose", "status", "save"])
def test_unplugged_at_every_state_of_the_dialogue_is_lost_and_never_hangs(moment):
    def watch(line: bytes) -> bytes:
        if re.match(rf"(#\d+ )?{moment}\W".encode(), line):
            fake.unplug()
            return b""
        return line

    begun_s = clock()
    with FakeBoard(to_board=watch) as fake, pytest.raises(RobotLost, match=r"went away.*cable"):
        with RobotBoard(fake.port, timeout_s=2.0) as robot:
            robot.gait(GAIT)
            for _ in itertools.islice(robot.frames(LONG_S), 5):
                if moment == "frames":
                    fake.unplug()
            robot.straight()
            robot.status()
            robot.save()
    assert clock() - begun_s < 10.0
