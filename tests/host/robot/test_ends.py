"""The robot stops however a run ends: by an error, a signal, a kill, a pause, a lost terminal."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace

import pytest
from command_line import program
from robot.fake_board import GAIT, GAIT_TYPED, FakeBoard
from robot.patience import LONG_S, clock, until
from robot.terminal import Person
from serpenoid.base.errors import CommandRefused, RobotClosed, RobotUnattended
from serpenoid.robot import RobotBoard
from serpenoid.robot.wire import dialogue

# The programs restore the default signals first, because RobotBoard does not handle ignored ones.
OPEN_ROBOT = """
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
SEND_COMMANDS = f"""{OPEN_ROBOT}
    while True:
        robot.gait(gait)
        robot.straight()
        time.sleep(0.02)
"""
READ_FRAMES = f"{OPEN_ROBOT}    robot.gait(gait)\n    list(robot.frames())\n"
WAIT_AT_REST = f"{OPEN_ROBOT}    input(); robot.status(); print(1)\n"
SLEEP_LONG = f"{OPEN_ROBOT}    robot.gait(gait); robot.set('silence', 0.5); time.sleep(60)\n"
FORK_CHILD = f"""{OPEN_ROBOT}
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


def start_program(port: str, source: str, shell: bool = True) -> subprocess.Popen[str]:
    """Start a program and wait until it prints `open`, when it has opened its robot."""
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


def test_an_exception_stops_the_robot_and_is_raised_again():
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
    rng = random.Random(f"{number}{impatient}")
    with FakeBoard() as fake:
        child = start_program(fake.port, SEND_COMMANDS)
        time.sleep(rng.uniform(0.0, 0.3))
        child.send_signal(number)
        if impatient:  # the second signal must not interrupt the stop
            time.sleep(rng.uniform(0.0, 0.01))
            child.send_signal(number)
        _, errors = child.communicate(timeout=LONG_S)
        assert fake.state in ("hold", "idle"), errors
        assert b"\n!\n" in fake.received
        assert until(lambda: not fake.board.session) or impatient
    assert child.returncode in ((130, -2) if number == signal.SIGINT else (128 + number, -number))


def test_ctrl_z_stops_a_moving_robot_and_lets_a_program_with_a_resting_one_continue():
    for source, output in ((READ_FRAMES, "the program was suspended"), (WAIT_AT_REST, "1\n")):
        with FakeBoard() as fake:
            child = start_program(fake.port, source, shell=False)
            assert source is WAIT_AT_REST or fake.await_state("gait")
            child.send_signal(signal.SIGTSTP)
            assert os.WIFSTOPPED(os.waitpid(child.pid, os.WUNTRACED)[1])
            assert source is WAIT_AT_REST or fake.await_state("hold")
            child.send_signal(signal.SIGCONT)
            assert output in "".join(child.communicate("\n", timeout=LONG_S))
            assert (child.returncode == 0) == (source is WAIT_AT_REST)


def test_the_robot_has_stopped_when_a_program_catches_ctrl_c(crawling):
    fake, _ = crawling
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(1.0)
    except KeyboardInterrupt:
        assert fake.await_state("hold")


def test_the_silence_timer_stops_the_robot_of_a_killed_program():
    with FakeBoard() as fake:
        child = start_program(fake.port, SLEEP_LONG)
        assert fake.await_state("gait")
        child.kill()
        child.communicate()
        assert fake.await_state("safing")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system with fork")
def test_a_forked_child_cannot_use_its_parents_robot():
    with FakeBoard() as fake:
        child = start_program(fake.port, FORK_CHILD)
        output, errors = child.communicate(timeout=LONG_S)
        assert (output.split(), child.returncode) == (["closed", "3", "gait"], 0), errors
        assert fake.state == "hold"


def test_the_robot_moves_while_a_program_sleeps_until_unattended_s():
    states: list[tuple[float, bytes]] = []  # time of the board, s, and its new state

    def listen(line: bytes) -> bytes:
        if line.startswith(b"state:"):
            states.append((fake.board.time_s, line.split()[1]))
        return line

    with FakeBoard(listen) as fake, RobotBoard(fake.port, unattended_s=1.5) as robot:
        robot.set("silence", 0.6)
        robot.gait(GAIT)
        # Reading `latest` does not count as a call of the program.
        assert until(lambda: robot.latest and states[-1][1] == b"hold", 20.0)
        (gait_s, gait), (hold_s, _) = states[-2:]
        assert gait == b"gait"
        assert hold_s - gait_s > 1.2  # twice the silence time
        with pytest.raises(RobotUnattended, match=r"1\.5 s.*was stopped.*unattended_s"):
            robot.straight()
        robot.straight()
        assert fake.await_state("pose")


def test_a_suspended_process_learns_that_the_board_went_to_the_safe_pose(crawling):
    fake, robot = crawling
    robot.set("silence", 0.2)
    fake.wait_in_board_time(0.7)  # until all servos are attached; pings prevent the silence timer
    assert fake.state == "gait"
    with robot._dialogue._talking:  # no thread can send, as in a suspended process
        assert fake.await_state("safe")
    assert until(lambda: robot._dialogue.inbox.notice)
    with pytest.raises(RobotUnattended, match="safe pose"):
        robot.status()


TERMINALS = {  # further options, the event, the exit status, text on the screen
    "Ctrl-C": ("", lambda person: person.presses("\x03"), 0, "true gait frequency"),
    "early Ctrl-C": ("--duration-s 60", lambda person: person.presses("\x03"), 130, "true gait"),
    "SIGHUP": ("", lambda person: person.sends(signal.SIGHUP), 129, "stopped"),
    "Ctrl-S": ("", lambda person: person.presses("\x13"), 1, "the program stood still for 2 s"),
    "closed": ("", lambda person: person.closes(), None, ""),
}


@pytest.mark.parametrize(("end", "hangup"), [*((e, "heard") for e in TERMINALS), ("closed", "")])
def test_drive_stops_the_robot_when_its_terminal_ends(end, hangup, tmp_path):
    (options, act, status, text), path = TERMINALS[end], tmp_path / "run.txt"
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
            code = person.process.wait(LONG_S) if end == "closed" else person.leaves()
            assert code == status if status is not None else code > 0
            assert text in person.screen
            assert "Traceback" not in person.screen
    assert b"\n# end: " in path.read_bytes()


def test_a_slow_loop_ends_in_time_and_counts_unread_frames(crawling):
    _, robot = crawling
    start_s, frames = clock(), 0
    for _ in robot.frames(1.0):
        frames += 1
        time.sleep(0.03)  # a frame comes every 0.02 s
        assert clock() - start_s < 3.0
    assert clock() - start_s < 1.5
    assert robot.losses.unread_frames == pytest.approx(50 - frames, abs=8)
    robot.straight()  # the board works as before


def test_a_stop_is_sent_while_another_thread_waits_for_a_verdict(monkeypatch, crawling):
    monkeypatch.setattr(dialogue, "TIMES", replace(dialogue.TIMES, patience_s=LONG_S))
    fake, robot = crawling
    fake.to_host = lambda line: b"" if line.startswith(b"ok: #") else line  # without a verdict
    waiting = threading.Thread(target=robot.status)
    waiting.start()
    assert until(lambda: b" status *" in fake.received)
    stopper = threading.Thread(target=robot.stop)
    stopper.start()
    assert fake.await_state("hold")
    assert waiting.is_alive()  # it would wait for a minute
    fake.to_host = lambda line: line
    stopper.join()
    waiting.join()
    assert fake.received.index(b"\n!\n") < fake.received.index(b" stop *")


def test_a_motion_with_a_lost_verdict_is_not_repeated_after_a_stop(monkeypatch, crawling):
    times = replace(dialogue.TIMES, retry_s=0.3)  # longer than the stop takes
    monkeypatch.setattr(dialogue, "TIMES", times)
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


def test_a_robot_is_used_only_inside_its_block_and_once():
    robot = RobotBoard("virtual:fast")
    with pytest.raises(RobotClosed, match="with RobotBoard"):
        robot.straight()
    with robot:
        robot.straight()
    for use in (robot.straight, robot.stop, lambda: next(robot.frames(1.0)), robot.__enter__):
        with pytest.raises(RobotClosed):
            use()
