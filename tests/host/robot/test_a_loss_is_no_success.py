"""Whatever is lost - the stop, frames, the state asked for, the clock - no run ends as if well."""

from __future__ import annotations

import json
import os
import re
import signal
import time
from collections.abc import Callable

import pytest
from command_line import serpenoid
from robot.fake_board import GAIT, GAIT_TYPED, FakeBoard, nothing, resealed, sealed, without
from robot.patience import LONG_S, clock
from serpenoid.base.errors import (
    FramesMissing,
    RobotLost,
    StateUnasked,
    StopUnconfirmed,
)
from serpenoid.robot import Robot
from serpenoid.robot.recording.stream import load_stream
from serpenoid.robot.wire import dialogue


@pytest.fixture(autouse=True)
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dialogue, "PATIENCE_S", 0.6)


def after_gait_frames(count: int, tamper: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """Return a tamper that acts from the count-th frame of a gait on."""
    seen = 0

    def pass_on(line: bytes) -> bytes:
        nonlocal seen
        seen += b" st=gait" in line
        return tamper(line) if seen > count else line

    return pass_on


def refusing_stop(line: bytes) -> bytes:
    """Change the verdict on the stop, and on it alone, into a refusal."""
    return resealed(line, rb"^ok: (#\d+)$", rb"err: \1 saving - settings are being saved")


def test_a_refused_stop_is_told():
    with (
        FakeBoard() as fake,
        pytest.raises(StopUnconfirmed, match=r"refuses 'stop': saving.*power"),
    ):
        with Robot(fake.port) as robot:
            robot.gait(GAIT)
            fake.to_host = refusing_stop


def deaf_to_stops(line: bytes) -> bytes:
    """Change every stop into a ping, which a board answers with ok."""
    return resealed(line.replace(b"!", b""), rb"^(#\d+) stop$", rb"\1 ping")


def move(robot: Robot, every: int) -> None:
    robot.set("every", every)
    robot.set("pose_speed", 1.0)
    robot.zigzag(0.4)


@pytest.mark.parametrize("every", [0, 1])
def test_a_stop_that_is_confirmed_and_not_obeyed_is_told(every):
    with FakeBoard() as fake, pytest.raises(StopUnconfirmed, match=r"not confirmed.*'pose'.*power"):
        with Robot(fake.port) as robot:
            move(robot, every)
            fake.to_board = deaf_to_stops
            with pytest.raises(StopUnconfirmed, match=r"said ok.*'pose'.*cut its power"):
                robot.stop()


@pytest.mark.parametrize("every", [0, 1])
def test_a_stop_is_sure_though_the_line_on_its_state_was_lost(every):
    with FakeBoard(without("state:")) as fake:
        with Robot(fake.port) as robot:
            move(robot, every)
            robot.stop()
            assert fake.state == "hold"
            robot.idle()
        assert fake.state == "idle"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_does_not_hide_that_the_stop_is_not_sure(number):
    mute = r"not confirmed: no verdict.*power"
    with FakeBoard() as fake, pytest.raises(StopUnconfirmed, match=mute) as told:
        with Robot(fake.port) as robot:
            robot.gait(GAIT)
            fake.to_host = nothing
            os.kill(os.getpid(), number)
            time.sleep(1.0)
    assert isinstance(told.value.__cause__, (KeyboardInterrupt, SystemExit))


def test_a_lost_stop_is_told_though_its_loss_was_caught():
    with FakeBoard() as fake, pytest.raises(StopUnconfirmed):
        with Robot(fake.port) as robot:
            robot.gait(GAIT)
            fake.unplug()
            with pytest.raises(RobotLost):
                list(robot.frames(5.0))


def without_frames(clock_s: Callable[[float], bool]) -> Callable[[bytes], bytes]:
    """Return a tamper that loses frames at some times of the clock."""
    return lambda line: b"" if line.startswith(b"t:") and clock_s(clock()) else line


def test_telemetry_that_ends_just_before_the_frames_do_is_missed(crawling):
    fake, robot = crawling
    muted_s = clock() + 1.5 - 0.25
    fake.to_host = without_frames(lambda now_s: now_s > muted_s)
    with pytest.raises(FramesMissing, match=r"no telemetry for \d\.\d s"):
        list(robot.frames(1.5))


def test_frames_that_are_late_at_the_end_are_awaited_and_not_told(crawling):
    fake, robot = crawling
    robot.set("every", 1)
    list(robot.frames(0.5))
    end_s = clock() + 0.7
    fake.to_host = without_frames(lambda now_s: now_s < end_s)
    assert len(list(robot.frames(0.4))) <= 2
    assert clock() >= end_s
    assert next(robot.frames(LONG_S))


def test_a_key_that_somebody_else_sent_is_told_once(crawling):
    fake, robot = crawling
    fake.write(b"\n!\n")
    with pytest.raises(StateUnasked, match="'hold'"):
        list(robot.frames(20.0))
    list(robot.frames(0.1))
    robot.straight()
    list(robot.frames(0.1))


def test_what_the_program_asks_for_is_no_surprise():
    with Robot("virtual:fast") as robot:
        for ask in (
            robot.stop,
            lambda: robot.gait(GAIT),
            robot.straight,
            robot.stop,
            lambda: robot.command("  gait  20 30 5"),
            robot.idle,
            robot.stop,
            lambda: robot.bent(0.1),
            robot._dialogue.halt,
            robot.idle,
        ):
            ask()
            assert list(robot.frames(0.2))


def stopping(line: bytes) -> bool:
    return b" stop *" in line


def cut_at_the_stop(fake: FakeBoard) -> None:
    def watch(line: bytes) -> bytes:
        if stopping(line):
            fake.unplug()
            return b""
        return line

    fake.to_board = watch


def mute_soon(fake: FakeBoard) -> None:
    fake.to_host = after_gait_frames(25, nothing)


def no_usable_frame(fake: FakeBoard) -> None:
    fake.to_host = lambda line: line[:20] + b"\n" if line.startswith(b"t:") else line


def frames_end(fake: FakeBoard) -> None:
    fake.to_host = after_gait_frames(50, without("t:"))


def browned_out(fake: FakeBoard) -> None:
    hello = "hello: serpenoid fw=0.2.0 protocol=5 board=uno joints=5 frame_us=20000 boot=9"
    again = sealed(f"{hello} reset=brownout settings=ok silence=2")
    fake.to_host = after_gait_frames(25, lambda line: line + again)


def every_fifth_lost(fake: FakeBoard) -> None:
    fake.to_host = lambda line: b"" if re.match(rb"t:\d*[05] ", line) else line


def goes_limp(fake: FakeBoard) -> None:
    fake.to_host = after_gait_frames(25, lambda line: resealed(line, b" st=gait", b" st=idle"))


def clock_at_double_pace(fake: FakeBoard) -> None:
    def faster(line: bytes) -> bytes:
        us = re.search(rb" board_us=(\d+)", line)
        return resealed(line, rb" board_us=\d+", b" board_us=%d" % (2 * int(us[1]))) if us else line

    fake.to_host = faster


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (mute_soon, "no telemetry|no verdict for 'ping'"),
        (cut_at_the_stop, "went away"),
        (no_usable_frame, "no telemetry"),
        (frames_end, "no telemetry"),
        (browned_out, "boot .*brownout"),
        (every_fifth_lost, "frames came and"),
        (goes_limp, "state 'idle', asked for was 'gait'"),
        (clock_at_double_pace, "clock runs"),
    ],
)
def test_drive_tells_a_loss_once_and_keeps_the_recording(tmp_path, harm, said):
    file = tmp_path / "run.wire"
    with FakeBoard() as fake:
        harm(fake)
        args = f"--port {fake.port} --duration-s 2.5 --record {file} --json"
        status, out, errors = serpenoid(f"drive {GAIT_TYPED} {args}")
    assert status == 1, errors
    told = [line for line in errors.splitlines() if re.search(said, line)]
    assert len(told) == 1, errors
    assert "Traceback" not in errors
    assert load_stream(file).end is not None
    if harm is clock_at_double_pace:
        assert json.loads(out)["frequency_hz"] is None


def test_drive_interrupted_without_a_sure_stop_has_failed():
    def interrupt(line: bytes) -> bytes:
        fake.to_host = nothing
        os.kill(os.getpid(), signal.SIGINT)
        return line

    with FakeBoard() as fake:
        fake.to_host = after_gait_frames(20, interrupt)
        status, _, errors = serpenoid(f"drive {GAIT_TYPED} --port {fake.port}")
    assert (status, "stop was not confirmed" in errors) == (1, True)
