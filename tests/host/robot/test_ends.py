"""However a run is left - error, signal, kill, neglect, a lost terminal - the robot stops first."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time

import pytest
from command_line import program
from robot.fake_board import GAIT, GAIT_TYPED, FakeBoard
from robot.patience import LONG_S, clock, until
from robot.terminal import Person
from serpenoid.base.errors import CommandRefused, RobotClosed, RobotUnattended
from serpenoid.robot import RobotBoard
from serpenoid.robot.wire import dialogue

# A RobotBoard leaves an ignored signal ignored, as it is for what nohup started.
OPENING = """
import math, os, signal, sys, time
for number in (signal.SIGHUP, signal.SIGQUIT):
    signal.signal(number, signal.SIG_DFL)
from serpenoid import Gait
from serpenoid.base.errors import RobotClosed
from serpenoid.robot import RobotBoard
gait = Gait(math.radians(30), math.radians(80), 5.0)
with RobotBoard(sys.argv[1]) as robot:
    print("open", flush=True)
"""
COMMANDING = f"""{OPENING}
    while True:
        robot.gait(gait)
        robot.straight()
        time.sleep(0.02)
"""
FOLLOWING = f"{OPENING}    robot.gait(gait)\n    list(robot.frames())\n"
RESTING = f"{OPENING}    input(); robot.status(); print(1)\n"
DESERTING = f"{OPENING}    robot.gait(gait); robot.set('silence', 0.5); time.sleep(60)\n"
FORKING = f"""{OPENING}
    robot.gait(gait)
    child = os.fork()
    if not child:
        try:
            robot.stop()
        except RobotClosed:
            print("closed", flush=True)
        sys.exit(3)
    print(os.waitpid(child, 0)[1] >> 8, next(robot.frames(60.0)).state, flush=True)
"""


def drive(port: str, source: str, shell: bool = True) -> subprocess.Popen[str]:
    """Start a program that says `open` once it has its robot, and wait for that."""
    child = subprocess.Popen(
        [sys.executable, "-c", source, port],
        start_new_session=not shell,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "open\n", child.stderr and child.stderr.read()
    return child


def test_an_exception_is_passed_on_and_a_stop_is_confirmed_before_bye():
    with FakeBoard() as fake:
        with pytest.raises(ZeroDivisionError), RobotBoard(fake.port) as robot:
            robot.gait(GAIT)
            assert next(robot.frames(LONG_S)).state == "gait"
            raise ZeroDivisionError
        assert (fake.state, fake.board.session) == ("hold", False)
        sent = [line.split(b" *")[0].split(b" ")[-1] for line in fake.received.split(b"\n")]
        assert [word for word in sent if word][-3:] == [b"!", b"stop", b"bye"]


@pytest.mark.parametrize("impatient", [False, True])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
def test_a_signal_at_any_moment_stops_the_robot(number, impatient):
    moment = random.Random(f"{number}{impatient}")
    with FakeBoard() as fake:
        child = drive(fake.port, COMMANDING)
        time.sleep(moment.uniform(0.0, 0.3))
        child.send_signal(number)
        if impatient:  # the second one must not cut the stopping short
            time.sleep(moment.uniform(0.0, 0.01))
            child.send_signal(number)
        _, said = child.communicate(timeout=LONG_S)
        assert fake.state in ("hold", "idle"), said
        assert b"\n!\n" in fake.received
        assert until(lambda: not fake.board.session) or impatient
    assert child.returncode in ((130, -2) if number == signal.SIGINT else (128 + number, -number))


def test_ctrl_z_stops_the_robot_before_it_suspends_and_ends_no_program_whose_robot_rested():
    for source, said in ((FOLLOWING, "the program was suspended"), (RESTING, "1\n")):
        with FakeBoard() as fake:
            child = drive(fake.port, source, shell=False)
            assert source is RESTING or fake.await_state("gait")
            child.send_signal(signal.SIGTSTP)
            assert os.WIFSTOPPED(os.waitpid(child.pid, os.WUNTRACED)[1])
            assert source is RESTING or fake.await_state("hold")
            child.send_signal(signal.SIGCONT)
            assert said in "".join(child.communicate("\n", timeout=LONG_S))
            assert (child.returncode == 0) == (source is RESTING)


def test_ctrl_c_that_the_program_catches_has_stopped_the_robot_before(crawling):
    fake, _ = crawling
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(1.0)
    except KeyboardInterrupt:
        assert fake.await_state("hold")


def test_a_killed_program_leaves_the_robot_to_its_silence_timer():
    with FakeBoard() as fake:
        child = drive(fake.port, DESERTING)
        assert fake.await_state("gait")
        child.kill()
        child.communicate()
        assert fake.await_state("safing")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system with fork")
def test_a_fork_neither_uses_nor_stops_its_parents_robot():
    with FakeBoard() as fake:
        child = drive(fake.port, FORKING)
        said, errors = child.communicate(timeout=LONG_S)
        assert (said.split(), child.returncode) == (["closed", "3", "gait"], 0), errors
        assert fake.state == "hold"


def test_a_sleeping_program_keeps_its_robot_going_and_a_lost_one_does_not():
    said: list[tuple[float, bytes]] = []

    def listen(line: bytes) -> bytes:
        if line.startswith(b"state:"):
            said.append((fake.board.time_s, line.split()[1]))
        return line

    with FakeBoard(listen) as fake, RobotBoard(fake.port, unattended_s=1.5) as robot:
        robot.set("silence", 0.6)
        robot.gait(GAIT)
        assert until(lambda: robot.latest and said[-1][1] == b"hold", 20.0)  # looking is no call
        (went_s, gait), (held_s, _) = said[-2:]
        assert gait == b"gait"
        assert held_s - went_s > 1.2  # two silence times
        with pytest.raises(RobotUnattended, match=r"1\.5 s.*was stopped.*unattended_s"):
            robot.straight()
        robot.straight()
        assert fake.await_state("pose")


def test_a_process_that_was_suspended_is_told_that_the_board_went_safe(crawling):
    fake, robot = crawling
    robot.set("silence", 0.2)
    fake.goes_on(0.7)  # until all servos are attached; pings come as often as this silence asks
    assert fake.state == "gait"
    with robot._dialogue._talking:  # nobody can speak, as if the whole process slept
        assert fake.await_state("safe")
    assert until(lambda: robot._dialogue.inbox.notice)
    with pytest.raises(RobotUnattended, match="safe pose"):
        robot.status()


TERMINALS = {  # more options, what is done, the exit status, what the screen says
    "Ctrl-C": ("", lambda one: one.presses("\x03"), 0, "true gait frequency"),
    "Ctrl-C before its end": ("--duration-s 60", lambda one: one.presses("\x03"), 130, "true gait"),
    "SIGHUP": ("", lambda one: one.sends(signal.SIGHUP), 129, "stopped"),
    "Ctrl-S": ("", lambda one: one.presses("\x13"), 1, "the program stood still for 2 s, so the"),
    "closed": ("", lambda one: one.closes(), None, ""),
}


@pytest.mark.parametrize(("end", "hangup"), [*((e, "heard") for e in TERMINALS), ("closed", "")])
def test_drive_stops_the_robot_however_its_terminal_ends_it(end, hangup, tmp_path):
    (options, act, status, said), path = TERMINALS[end], tmp_path / "run.txt"
    with FakeBoard(pace=time.monotonic) as fake:
        command = program(f"drive {GAIT_TYPED} {options} --port {fake.port} --record {path}")
        if not hangup:
            command = ["sh", "-c", "trap '' HUP; exec \"$@\"", "sh", *command]
        with Person(command) as person:
            person.sees("setpoint, deg")
            act(person)
            assert fake.await_state("hold", 30.0)
            if end == "Ctrl-S":
                person.presses("\x11")
            left = person.process.wait(LONG_S) if end == "closed" else person.leaves()
            assert left == status if status is not None else left > 0
            assert said in person.screen
            assert "Traceback" not in person.screen
    assert b"\n# end: " in path.read_bytes()


def test_a_loop_slower_than_the_frames_ends_in_time_and_counts_what_it_left(crawling):
    _, robot = crawling
    begun_s, frames = clock(), 0
    for _ in robot.frames(1.0):
        frames += 1
        time.sleep(0.03)  # a frame comes every 0.02 s
        assert clock() - begun_s < 3.0
    assert clock() - begun_s < 1.5
    assert robot.losses.unread_frames == pytest.approx(50 - frames, abs=8)
    robot.straight()  # the board is as well as before


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


def test_a_motion_whose_verdict_was_lost_is_not_sent_again_after_a_stop(monkeypatch, crawling):
    monkeypatch.setattr(dialogue, "RETRY_S", 0.3)  # in which the stop has come
    fake, robot = crawling
    stops: list[threading.Thread] = []

    def lose(line: bytes) -> bytes:
        if b" pose " not in line:
            return line
        stops.append(threading.Thread(target=robot.stop))
        stops[0].start()
        return b""

    fake.to_board = lose
    with pytest.raises(CommandRefused, match="stopped"):
        robot.straight()
    stops[0].join()
    assert len(stops) == 1
    assert robot.status().state == "hold"
    fake.to_board = lambda line: line
    robot.straight()
    assert fake.await_state("pose")


def test_a_robot_is_used_inside_its_block_only_and_once():
    robot = RobotBoard("virtual:fast")
    with pytest.raises(RobotClosed, match="with RobotBoard"):
        robot.straight()
    with robot:
        robot.straight()
    for use in (robot.straight, robot.stop, lambda: next(robot.frames(1.0)), robot.__enter__):
        with pytest.raises(RobotClosed):
            use()
