"""A board that is silent, old, torn, late, twice or gone: every run ends well or by name."""

from __future__ import annotations

import itertools
import random
import re

import pytest
from robot.fake_board import GAIT, FakeBoard, greeting, honest, nothing, sealed, without
from robot.patience import LONG_S, clock, until
from serpenoid.base.errors import (
    DamagedLine,
    NoAnswer,
    ProtocolMismatch,
    RobotError,
    RobotLost,
    RobotReset,
)
from serpenoid.robot import Robot
from serpenoid.robot.wire import dialogue
from serpenoid.robot.wire.virtual import VirtualLink


def test_a_silent_board():
    with (
        FakeBoard(nothing) as fake,
        pytest.raises(NoAnswer, match=r"nothing came.*flash"),
        Robot(fake.port, timeout_s=1.0),
    ):
        pass
    assert b"#0 hello" in fake.received


def test_a_wrong_baud_rate():
    noise = random.Random(1)
    with (
        FakeBoard(lambda line: noise.randbytes(len(line))) as fake,
        pytest.raises(NoAnswer, match="not of this firmware at 250000 baud"),
        Robot(fake.port, timeout_s=1.0),
    ):
        pass


@pytest.mark.parametrize(
    "greeting",
    [
        sealed("hello: serpenoid fw=0.0.9 protocol=0 board=uno boot=3 reset=power settings=ok"),
        sealed("hello: serpenoid fw=9.0.0 protocol=0 name=snake"),
    ],
)
def test_another_protocol_is_refused_with_both_numbers_and_the_cure(greeting):
    with (
        FakeBoard(lambda line: greeting if line.startswith(b"hello") else b"") as fake,
        pytest.raises(ProtocolMismatch, match=r"protocol 0.*protocol 5.*serpenoid flash --port"),
        Robot(fake.port, timeout_s=1.0),
    ):
        pass


def test_a_greeting_of_other_joints_than_the_frames_have_ends_the_run():
    with FakeBoard(greeting(b"joints=5", b"joints=12")) as fake:
        with pytest.raises(ProtocolMismatch, match="12 joints, and a frame has 5"):
            with Robot(fake.port) as robot:
                list(robot.frames(LONG_S))


@pytest.mark.parametrize("protocol", ["4", "9" * 5000])
def test_a_damaged_greeting_is_not_believed_but_asked_for_again(protocol):
    damaged = itertools.chain([True] * 2, itertools.repeat(False))

    def spoil(line: bytes) -> bytes:
        if not line.startswith(b"hello") or not next(damaged):
            return line
        return re.sub(rb"protocol=\d+", b"protocol=" + protocol.encode(), line)

    with FakeBoard(spoil) as fake, Robot(fake.port) as robot:
        assert robot.hello.board == "virtual"


def test_greetings_that_are_always_damaged_are_told_as_such():
    with (
        FakeBoard(lambda line: line.replace(b" *", b" *0")) as fake,
        pytest.raises(NoAnswer, match=r"greetings came damaged.*cable"),
        Robot(fake.port, timeout_s=1.0),
    ):
        pass


@pytest.mark.parametrize(
    ("tamper", "found"),
    [
        (honest, "boot 1, now 2; cause: brownout"),
        # by its frames, or by its count of boots where that is asked for first
        (without("hello:"), "frames went back from|boot 1, now 2"),
    ],
    ids=["greets", "greeting lost"],
)
def test_a_reset_in_mid_run_ends_it_and_keeps_the_recording(tmp_path, tamper, found):
    record = tmp_path / "run.txt"
    with (
        FakeBoard() as fake,
        pytest.raises(RobotReset, match=found),
        Robot(fake.port, record=record) as robot,
    ):
        robot.gait(GAIT)
        for number, _ in enumerate(robot.frames(LONG_S)):
            if number == 20:
                fake.to_host = tamper
                fake.reset("brownout")
    text = record.read_text()
    assert text.count(" < t:") > 20
    assert "# end: RobotReset" in text


@pytest.mark.parametrize(
    "tamper",
    [
        without("ok:", "err:"),
        lambda line: sealed("ok: #999") if line.startswith(b"ok:") else line,
        lambda line: sealed("err: #? crc") if line.startswith(b"ok:") else line,
    ],
    ids=["none", "for another number", "always damaged"],
)
def test_a_verdict_that_never_comes(tamper, monkeypatch):
    monkeypatch.setattr(dialogue, "PATIENCE_S", 0.5)
    with FakeBoard() as fake:
        with pytest.raises(RobotLost, match="no verdict for 'pose straight'"):
            with Robot(fake.port) as robot:
                robot.gait(GAIT)
                fake.to_host = tamper
                robot.straight()
        assert fake.await_state("hold")
        assert 3 <= fake.received.count(b"pose straight") < 50


def test_lines_lost_on_the_way_to_the_board_are_sent_again_and_obeyed_once():
    lost: set[bytes] = set()

    def lose_the_first(line: bytes) -> bytes:
        if line in lost or not line.startswith(b"#") or line.startswith(b"#0 "):
            return line
        lost.add(line)
        return b""

    with FakeBoard(to_board=lose_the_first) as fake, Robot(fake.port) as robot:
        robot.gait(GAIT)
        robot.trims()
        assert len(lost) >= 3
        assert robot.losses.resent >= len(lost)
        assert fake.board.counters["lost"] == 0


@pytest.mark.filterwarnings("error")
def test_a_reset_without_greeting_or_frames_shows_in_the_status():
    with FakeBoard() as fake, pytest.raises(RobotReset, match=r"boot \d+, now \d+.*lost"):
        with Robot(fake.port) as robot:
            robot.gait(GAIT)
            robot.set("every", 0)
            fake.to_host = without("hello:", "t:")
            fake.reset("brownout")
            robot.status()


def test_a_board_that_does_not_list_its_settings_can_be_driven():
    with FakeBoard(without("set:")) as fake, Robot(fake.port) as robot:
        robot.gait(GAIT)
        assert fake.await_state("gait")
        with pytest.raises(DamagedLine, match="cable"):
            robot.settings()


def test_half_and_doubled_frames_are_counted_and_never_used():
    which = itertools.count()

    def spoil(line: bytes) -> bytes:
        if not line.startswith(b"t:"):
            return line
        kind = next(which) % 10
        return {3: line[: len(line) // 2] + b"\n", 5: line * 2, 7: b""}.get(kind, line)

    with FakeBoard() as fake, Robot(fake.port) as robot:
        robot.gait(GAIT)
        fake.to_host = spoil
        frames = list(robot.frames(0.7))
        fake.to_host = honest
        robot.status()  # whose verdict comes after all that was spoilt
        losses = robot.losses
    numbers = [f.frame for f in frames]
    assert numbers == sorted(set(numbers))
    spoiled = next(which) // 10
    assert losses.damaged_lines == pytest.approx(spoiled, abs=1)
    assert losses.repeated_frames == pytest.approx(spoiled, abs=1)
    assert losses.missed_frames == pytest.approx(2 * spoiled, abs=2)


def test_a_line_without_end_does_not_fill_the_memory():
    with FakeBoard() as fake, Robot(fake.port) as robot:
        fake.to_host = lambda _: b"x" * 1000
        assert until(lambda: robot.losses.damaged_lines >= 2)
        fake.to_host = honest


@pytest.mark.parametrize(
    "moment", ["hello:", "hello", "set", "gait", "frames", "pose", "status", "save", "bye"]
)
def test_unplugged_at_every_state_of_the_dialogue_is_lost_and_never_hangs(moment):
    def watch(line: bytes) -> bytes:
        if re.match(rf"(#\d+ )?{moment}\W".encode(), line):
            fake.unplug()
            return b""
        return line

    def run() -> None:
        with Robot(fake.port, timeout_s=2.0) as robot:
            robot.gait(GAIT)
            for _ in itertools.islice(robot.frames(LONG_S), 5):
                if moment == "frames":
                    fake.unplug()
            robot.pose([0.0, 0.1, 0.0, 0.1, 0.0])
            robot.status()
            robot.stop()
            robot.save()

    begun_s = clock()
    with FakeBoard() as fake:
        fake.to_board = watch
        fake.to_host = watch if moment == "hello:" else honest
        if moment == "bye":  # the stop was confirmed: nothing is amiss
            run()
        else:
            with pytest.raises(RobotLost, match=r"went away.*cable"):
                run()
    assert clock() - begun_s < 10.0


@pytest.mark.parametrize("word", [b" hello *", b" pose ", b" status *"])
def test_a_process_that_slept_after_asking_still_hears_the_answer(word, monkeypatch):
    """As when a machine is suspended, or too busy: time went by in which nobody listened."""
    link, slept = VirtualLink(fast=True), [b""]

    def write(data: bytes) -> None:
        slept.append(data) if word in data else None
        VirtualLink.write(link, data)

    link.write = write
    link.now_s = lambda: link.board.time_s + 100.0 * len(slept)
    monkeypatch.setattr("serpenoid.robot.robot.open_link", lambda _port: link)
    with Robot("any", unattended_s=1e4) as robot:
        robot.straight()
        robot.status()
    assert len(slept) > 1


def test_an_error_of_the_program_is_not_masked_by_the_loss_of_the_board():
    with FakeBoard() as fake, pytest.warns(RuntimeWarning, match="stop was not confirmed"):
        with pytest.raises(ZeroDivisionError):
            with Robot(fake.port) as robot:
                robot.gait(GAIT)
                fake.unplug()
                raise ZeroDivisionError


def test_a_loss_that_no_call_met_is_told_on_leaving():
    with FakeBoard() as fake, pytest.raises(RobotError, match="went away"):
        with Robot(fake.port) as robot:
            robot.gait(GAIT)
            fake.unplug()
            assert until(lambda: robot._dialogue.failure)
