"""However a run is left - exception, Ctrl-C, TERM, HUP, kill, neglect - the robot stops."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time

import pytest
from robot.fake_board import GAIT, FakeBoard, honest
from robot.patience import LONG_S, until
from serpenoid.base.errors import RobotReset, RobotUnattended
from serpenoid.robot import Robot

DRIVER = """
import math, sys, time
from serpenoid import Gait
from serpenoid.robot import Robot
with Robot(sys.argv[1]) as robot:
    print("open", flush=True)
    robot.gait(Gait(math.radians(30), math.radians(80), 5.0))
    while True:
        robot.straight()
        robot.gait(Gait(math.radians(30), math.radians(80), 5.0))
        time.sleep(0.02)
"""

FORKING = """
import os, signal, sys, time
from serpenoid import Gait
from serpenoid.base.errors import RobotClosed
from serpenoid.robot import Robot
parent = os.getpid()
try:
    with Robot(sys.argv[1]) as robot:
        print("open", flush=True)
        robot.gait(Gait(0.5, 1.4, 5.0))
        child = os.fork()
        if child:
            status = os.waitpid(child, 0)[1]
            frame = next(robot.frames(60.0))
            print(status, frame.state, flush=True)
        else:
            try:
                robot.stop()
            except RobotClosed:
                print("closed", flush=True)
            os.kill(os.getpid(), signal.SIGTERM)
except SystemExit:
    if os.getpid() != parent:
        print("left", flush=True)
        os._exit(0)
"""


# A Robot leaves an ignored signal ignored, as it is for what nohup started.
HEAR_HANGUPS = """import signal
for number in (signal.SIGHUP, signal.SIGQUIT):
    signal.signal(number, signal.SIG_DFL)
"""


def drive(port: str, program: str = DRIVER, shell: bool = True) -> subprocess.Popen[str]:
    child = subprocess.Popen(
        [sys.executable, "-c", HEAR_HANGUPS + program, port],
        start_new_session=not shell,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "open\n", child.stderr and child.stderr.read()
    return child


def test_an_exception_stops_the_robot_and_is_passed_on(any_port):
    with pytest.raises(ZeroDivisionError), Robot(any_port) as robot:
        robot.gait(GAIT)
        assert next(robot.frames(LONG_S)).state == "gait"
        talk = robot._dialogue
        raise ZeroDivisionError
    assert talk.inbox.pending.text == "bye"
    assert talk.inbox.pending.verdict.accepted


def test_a_stop_is_confirmed_before_bye():
    with FakeBoard() as fake:
        with Robot(fake.port) as robot:
            robot.gait(GAIT)
        assert fake.state == "hold"
        assert not fake.board.session
        tail = [line.split(b" *")[0].split(b" ")[-1] for line in fake.received.split(b"\n")]
        assert [w for w in tail if w][-3:] == [b"!", b"stop", b"bye"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
@pytest.mark.parametrize("case", range(2))
def test_a_signal_at_any_moment_stops_the_robot(number, case):
    moment = random.Random(f"{number}{case}")
    with FakeBoard() as fake:
        child = drive(fake.port)
        time.sleep(moment.uniform(0.0, 0.4))
        child.send_signal(number)
        if case:  # an impatient second one must not cut the stopping short
            time.sleep(moment.uniform(0.0, 0.01))
            child.send_signal(number)
        _, said = child.communicate(timeout=LONG_S)
        assert fake.state in ("hold", "idle"), said
        assert fake.received.count(b"\n!\n") >= 1
        assert until(lambda: not fake.board.session) or case
    assert child.returncode in ((130, -2) if number == signal.SIGINT else (128 + number, -number))


@pytest.mark.parametrize("word", [b"!", b" stop *"])
def test_a_reset_at_the_moment_of_the_stop_is_told(word):
    with FakeBoard() as fake:

        def reset(line: bytes) -> bytes:
            if word in line:
                fake.to_board = honest
                fake.reset("brownout")
            return line

        with pytest.raises(RobotReset, match="brownout"), Robot(fake.port) as robot:
            robot.gait(GAIT)
            fake.to_board = reset


def test_a_greeting_behind_half_a_line_is_one():
    """A reset cuts the line that was being sent; what follows it on the wire is the greeting."""
    with FakeBoard() as fake:

        def cut(line: bytes) -> bytes:
            return b"t:2" + line if line.startswith(b"hello: ") else line

        with pytest.raises(RobotReset, match="brownout"), Robot(fake.port) as robot:
            robot.gait(GAIT)
            fake.to_host = cut
            fake.reset("brownout")
            for _ in robot.frames(duration_s=60.0):
                pass


FOLLOWING = DRIVER.partition("    while True")[0] + "    list(robot.frames())\n"


def test_ctrl_z_stops_the_robot_before_it_suspends():
    with FakeBoard() as fake:
        child = drive(fake.port, FOLLOWING, shell=False)
        assert fake.await_state("gait")
        child.send_signal(signal.SIGTSTP)
        assert os.WIFSTOPPED(os.waitpid(child.pid, os.WUNTRACED)[1])
        assert fake.await_state("hold")
        child.send_signal(signal.SIGCONT)
        assert "RobotUnattended: the program was suspended" in child.communicate(timeout=LONG_S)[1]


def test_a_program_whose_robot_rested_at_ctrl_z_goes_on():
    waiting = DRIVER.partition("    robot.gait")[0] + "    input(); robot.status(); print(1)"
    with FakeBoard() as fake:
        child = drive(fake.port, waiting, shell=False)
        child.send_signal(signal.SIGTSTP)
        assert os.WIFSTOPPED(os.waitpid(child.pid, os.WUNTRACED)[1])
        child.send_signal(signal.SIGCONT)
        assert child.communicate("\n", timeout=LONG_S)[0] == "1\n"


def test_ctrl_c_that_the_program_catches_has_stopped_the_robot_before():
    with FakeBoard() as fake, Robot(fake.port) as robot:
        robot.gait(GAIT)
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1.0)
        except KeyboardInterrupt:
            assert fake.await_state("hold")


def test_a_killed_program_leaves_the_robot_to_its_silence_timer():
    program = DRIVER.partition("    while")[0] + "    robot.set('silence', 0.5); time.sleep(60)"
    with FakeBoard() as fake:
        child = drive(fake.port, program)
        assert fake.await_state("gait")
        child.kill()
        child.communicate()
        assert fake.await_state("safing")


def test_a_sleeping_program_keeps_its_robot_going_and_a_lost_one_does_not():
    said: list[tuple[float, bytes]] = []

    def listen(line: bytes) -> bytes:
        if line.startswith(b"state:"):
            said.append((fake.board.time_s, line.split()[1]))
        return line

    with FakeBoard(listen) as fake, Robot(fake.port, unattended_s=1.5) as robot:
        robot.set("silence", 0.6)
        robot.gait(GAIT)
        while not fake.await_state("hold", 0.1):
            robot.latest  # noqa: B018  # looking is not calling
        assert until(lambda: said[-1][1] == b"hold")
        (went_s, gait), (held_s, _) = said[-2:]
        assert gait == b"gait"
        assert held_s - went_s > 1.2  # two silence times
        with pytest.raises(RobotUnattended, match=r"1\.5 s.*was stopped.*unattended_s"):
            robot.straight()
        robot.straight()
        assert fake.await_state("pose")


def test_pings_are_as_frequent_as_the_boards_silence_time_asks():
    with FakeBoard() as fake, Robot(fake.port) as robot:
        robot.gait(GAIT)
        robot.command("set  silence  0.4")
        fake.goes_on(1.0)
        assert fake.state == "gait"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system with fork")
def test_a_fork_neither_uses_nor_stops_its_parents_robot():
    with FakeBoard() as fake:
        child = drive(fake.port, FORKING)
        said, errors = child.communicate(timeout=LONG_S)
        assert (said.split(), child.returncode) == (["closed", "left", "0", "gait"], 0), errors
        assert fake.state == "hold"


def test_a_process_that_was_suspended_is_told_that_the_board_went_safe():
    with FakeBoard() as fake, Robot(fake.port) as robot:
        robot.set("silence", 0.2)
        robot.gait(GAIT)
        fake.goes_on(0.7)  # until all servos are attached
        with robot._dialogue._talking:  # nobody can speak, as if the whole process slept
            assert fake.await_state("safe")
        assert until(lambda: robot._dialogue.inbox.notice)
        with pytest.raises(RobotUnattended, match="safe pose"):
            robot.status()
