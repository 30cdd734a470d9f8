"""A program, a terminal or a disk that is slower than the frames keeps no robot moving."""

from __future__ import annotations

import os
import select
import signal
import sys
import time

import pytest
from command_line import program
from robot.fake_board import GAIT_TYPED as TYPED
from robot.fake_board import FakeBoard
from robot.patience import LONG_S, clock, until
from robot.terminal import Person
from serpenoid.base.errors import RobotReset
from serpenoid.robot import Robot
from serpenoid.robot.recording.stream import load_stream
from serpenoid.robot.tools.driven_run import UNATTENDED_S

SLOW_S = 0.03  # a frame comes every 0.02 s
LATE_S = 0.5  # by which a busy machine may end a loop late


def look_at(robot: Robot, duration_s: float, body_s: float) -> tuple[int, float]:
    """Return how many frames a loop with a body of so many seconds gets, and its time in s."""
    begun_s, frames = clock(), 0
    for _ in robot.frames(duration_s):
        frames += 1
        time.sleep(body_s)
        if clock() - begun_s > 3 * duration_s:
            break
    return frames, clock() - begun_s


def test_a_loop_slower_than_the_frames_ends_in_time_and_counts_what_it_left(crawling):
    _, robot = crawling
    frames, took_s = look_at(robot, 1.5, SLOW_S)
    assert took_s < 1.5 + LATE_S
    assert frames < 55
    assert robot.losses.unread_frames == pytest.approx(75 - frames, abs=8)
    robot.straight()  # the board is as well as before


def test_a_flood_of_frames_keeps_no_loop_going():
    with FakeBoard(pace=lambda: 10 * clock()) as fake, Robot(fake.port) as robot:
        assert look_at(robot, 1.0, 0.01)[1] < 1.0 + LATE_S
        assert robot.losses.unread_frames > 50


def test_a_reset_is_told_before_the_frames_that_wait(crawling):
    fake, robot = crawling
    given_after = 0
    with pytest.raises(RobotReset, match="brownout"):
        for number, _ in enumerate(robot.frames(LONG_S)):
            time.sleep(SLOW_S)
            if number == 20:
                fake.reset("brownout")
                assert until(lambda: robot._dialogue.failure)
            given_after = max(number - 20, 0)
    assert given_after == 0


def test_a_slow_terminal_makes_no_drive_longer():
    with FakeBoard(pace=time.monotonic) as fake:
        with Person(f"drive {TYPED} --duration-s 4 --port {fake.port}") as person:
            person.sees("setpoint, deg")
            begun_s, piece, bytes_a_s = fake.board.time_s, 100, 5000.0
            while fake.state == "gait" and fake.board.time_s < begun_s + 20.0:
                if select.select([person.master], [], [], 0.01)[0]:
                    os.read(person.master, piece)
                time.sleep(piece / bytes_a_s)
            assert fake.board.time_s - begun_s < 4.0 + UNATTENDED_S + 1.0
            person.leaves()
            assert "true gait frequency" in person.screen


@pytest.mark.parametrize("halt", ["Ctrl-S", "a reader that stops"])
def test_a_halted_terminal_stops_the_robot_and_is_told(halt):
    with FakeBoard(pace=time.monotonic) as fake:
        with Person(f"drive {TYPED} --duration-s 60 --port {fake.port}") as person:
            person.sees("setpoint, deg")
            begun_s = fake.board.time_s
            if halt == "Ctrl-S":
                person.presses("\x13")
            assert fake.await_state("hold", 30.0)
            if halt == "Ctrl-S":
                assert fake.board.time_s - begun_s < UNATTENDED_S + 1.5
                person.presses("\x11")
            assert person.leaves() == 1
            assert "the terminal took nothing for 2 s, so the robot was stopped" in person.screen


@pytest.mark.parametrize("hangup", ["heard", "ignored"])
def test_a_closed_terminal_stops_the_robot(hangup):
    with FakeBoard(pace=time.monotonic) as fake:
        command = program(f"drive {TYPED} --port {fake.port}")
        if hangup == "ignored":
            command = ["sh", "-c", "trap '' HUP; exec \"$@\"", "sh", *command]
        with Person(command) as person:
            person.sees("setpoint, deg")
            person.closes()
            assert person.process.wait(LONG_S) > 0
            assert fake.state == "hold"


@pytest.mark.parametrize("name", ["SIGQUIT", "SIGTERM", "SIGHUP"])
def test_a_signal_that_ends_a_drive_stops_the_robot_and_ends_the_recording(name, tmp_path):
    number, path = signal.Signals[name], tmp_path / "run.txt"
    with FakeBoard(pace=time.monotonic) as fake:
        with Person(f"drive {TYPED} --port {fake.port} --record {path}") as person:
            person.sees("setpoint, deg")
            person.sends(number)
            assert person.leaves() == 128 + number
            assert fake.state == "hold"
            assert "stopped" in person.screen
    assert load_stream(path).end == f"_Signalled: {128 + number}"


KEYS = """
from serpenoid.base import system
with system.single_keys():
    print("ready", flush=True)
    while (came := system.read_input(60.0)) != b"q":
        print("key", came, flush=True)
"""


def test_the_terminal_is_given_back_while_a_program_of_keys_is_suspended():
    with Person([sys.executable, "-c", KEYS]) as person:
        person.sees("ready")
        assert until(lambda: person.now != person.before)
        person.sends(signal.SIGTSTP)
        assert os.WIFSTOPPED(os.waitpid(person.process.pid, os.WUNTRACED)[1])
        assert person.now == person.before
        person.sends(signal.SIGCONT)
        assert until(lambda: person.now != person.before)
        person.presses("k")
        person.sees("key b'k'")
        person.presses("q")
        assert person.leaves() == 0
        assert person.now == person.before
