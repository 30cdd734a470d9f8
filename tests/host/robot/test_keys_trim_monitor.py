"""What a person does by keys: trim a servo, talk to the board; and the terminal afterwards."""

from __future__ import annotations

import re
import signal
import subprocess

import pytest
from command_line import program, serpenoid
from robot.fake_board import FakeBoard
from robot.patience import LONG_S
from robot.terminal import Person


def test_typed_numbers_centre_servos_until_the_power_goes_or_they_are_saved():
    lines = ["1 1512", "3 +5", "3 -4", "7 +2", "8 1500", "0 +1", "x", "1", "", "1 wide"]
    for end, said in (("quit", "not saved"), ("save", "saved on the board")):
        done = serpenoid("trim --port virtual:fast:joints=7", typed="\n".join([*lines, end]))
        centres = re.findall(r"joint (\d)  centre (\d+) us", done.stdout)
        assert {int(joint): int(us) for joint, us in centres} == CENTRES
        assert said in done.stdout.splitlines()[-1]


CENTRES = dict(enumerate([1512, 1500, 1501, 1500, 1500, 1500, 1502], 1))


@pytest.mark.parametrize("how", ["quit", "term", "unplugged"])
def test_trim_stops_the_robot_however_it_is_left(how):
    with FakeBoard() as fake, Person(f"trim --port {fake.port}") as person:
        person.sees("joint 5  centre 1500 us")
        assert fake.state == "pose"
        person.presses("3 1501\r")
        person.sees("joint 3  centre 1501 us")
        if how == "quit":
            person.presses("save\r")
            person.answers("saved on the board", "quit\r")
        elif how == "term":
            person.sends(signal.SIGTERM)
        else:
            fake.unplug()
            person.presses("3 +1\r")
        assert person.leaves() == {"quit": 0, "term": 143, "unplugged": 1}[how]
        assert fake.state == ("pose" if how == "unplugged" else "hold")
        assert "Traceback" not in person.screen


def test_monitor_whose_reader_goes_away_stops_the_robot():
    with FakeBoard() as fake:
        child = subprocess.Popen(
            program(f"monitor --port {fake.port}"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert child.stdin is not None
        assert child.stdout is not None
        child.stdin.write("gait 30 80 5\n")
        child.stdin.flush()
        assert fake.await_state("gait")
        child.stdout.close()
        assert fake.await_state("hold")
        child.stdin.close()
        assert child.wait(LONG_S) == 1


PIPED = {  # what is typed, and what the monitor says to it
    "status\nfoo\n": ["counters: good=3", "err: #3 command - no such command; type help"],
    "gait 30 80 5\nping\n!": ["ok: #!", "state: hold why=key"],
    "!ping\n": ["ok: #!"],
    f"{'x' * 90}\nstatus\n": ["at most 80", "counters: good="],
}


@pytest.mark.parametrize("typed", PIPED)
def test_monitor_from_a_pipe(any_live_port, typed):
    run = subprocess.run(
        program(f"monitor --port {any_live_port}"),
        input=typed,
        capture_output=True,
        text=True,
        timeout=LONG_S,
        check=True,
    )
    assert all(said in run.stdout for said in PIPED[typed])
    assert "\x1b" not in run.stdout


@pytest.mark.parametrize("key", ["\x03", "\x04"], ids=["ctrl-c", "ctrl-d"])
def test_monitor_at_a_terminal(key):
    with FakeBoard() as fake, Person(f"monitor --port {fake.port}") as person:
        person.answers("Ctrl-D stops it and leaves", "gait 30 80 5\r")
        person.answers("state: gait why=command", "!\r")
        person.answers("state: hold why=key", "gait 20 80 5\r")
        person.sees("state: gait why=command")
        person.presses(key)
        assert person.leaves() == 0
        assert fake.state == "hold"
        assert not fake.board.session
