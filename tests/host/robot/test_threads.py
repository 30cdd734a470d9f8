"""One robot, many threads: stop from any of them, frames to all, and no copies."""

from __future__ import annotations

import threading

import pytest
from robot.fake_board import GAIT, FakeBoard, nothing
from robot.patience import LONG_S, until
from serpenoid.base.errors import NoAnswer, RobotClosed, RobotHeld
from serpenoid.robot import Robot
from serpenoid.robot.wire import dialogue


def test_a_stop_goes_out_at_once_though_another_thread_waits_for_a_verdict(monkeypatch, crawling):
    monkeypatch.setattr(dialogue, "PATIENCE_S", LONG_S)
    fake, robot = crawling
    fake.to_host = lambda line: b"" if line.startswith(b"ok: #") else line  # it waits long
    waiting = threading.Thread(target=robot.status)
    waiting.start()
    assert until(lambda: b" status *" in fake.received)
    stopper = threading.Thread(target=robot.stop)
    stopper.start()
    assert fake.await_state("hold")
    assert waiting.is_alive()  # and would be for a minute
    fake.to_host = lambda line: line
    stopper.join()
    waiting.join()
    assert fake.received.index(b"\n!\n") < fake.received.index(b" stop *")


def test_stops_of_another_thread_lose_no_question_of_this_one():
    with FakeBoard() as fake, Robot(fake.port) as robot:
        done, asked, told = threading.Event(), 0, [0] * 60

        def stop() -> None:
            while not done.wait(0.003):
                if told[asked] < dialogue.MOST_STOPS // 2:  # however long the question takes
                    told[asked] += 1
                    robot._dialogue.halt()

        stopper = threading.Thread(target=stop)
        stopper.start()
        try:
            for asked in range(60):  # noqa: B007
                assert robot.status().state == "idle"
        finally:
            done.set()
            stopper.join()
        assert sum(told) > 5


def test_a_stop_that_is_to_stay_refuses_motion_until_it_is_released(crawling):
    fake, robot = crawling
    held = threading.Event()

    def press() -> None:
        robot.stop(stay=True)
        held.set()

    threading.Thread(target=press).start()
    with pytest.raises(RobotHeld, match="release"):
        while True:
            robot.gait(GAIT)
    assert held.wait(LONG_S)
    assert fake.state == "hold"
    with pytest.raises(RobotHeld):
        robot.straight()
    assert robot.status().state == "hold"
    robot.release()
    robot.straight()
    assert fake.await_state("pose")


def test_a_motion_that_waits_for_its_verdict_is_not_sent_again_after_such_a_stop(
    monkeypatch, crawling
):
    monkeypatch.setattr(dialogue, "RETRY_S", 0.3)  # in which the stop has come
    fake, robot = crawling
    stops: list[threading.Thread] = []

    def lose(line: bytes) -> bytes:
        if b" pose " not in line:
            return line
        if not stops:
            stops.append(threading.Thread(target=lambda: robot.stop(stay=True)))
            stops[0].start()
        return b""

    fake.to_board = lose
    with pytest.raises(RobotHeld):
        robot.straight()
    stops[0].join()
    before, _, after = fake.received.partition(b"\n!\n")
    assert b"pose straight" in before
    assert b"pose straight" not in after


def test_a_robot_that_did_not_open_has_no_greeting():
    with FakeBoard(nothing) as fake:
        robot = Robot(fake.port, timeout_s=0.2)
        with pytest.raises(NoAnswer), robot:
            pass
        with pytest.raises(RobotClosed, match="failed before"):
            robot.hello  # noqa: B018
