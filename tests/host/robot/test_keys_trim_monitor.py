"""What a person does by keys: trim a servo, talk to the board; and the terminal afterwards."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys

import pytest
from command_line import program, serpenoid
from robot.fake_board import FakeBoard, nothing
from robot.patience import LONG_S
from robot.terminal import Person
from serpenoid._core import firmware
from serpenoid.model.errors import RobotLost, StopUnconfirmed
from serpenoid.robot import Robot
from serpenoid.robot.tools import keys
from serpenoid.robot.tools.monitor import Monitor
from serpenoid.robot.tools.trimming import Trimming, straighten
from serpenoid.robot.wire.virtual import VirtualLink


def pressed(monkeypatch: pytest.MonkeyPatch, *parts: bytes) -> list[str]:
    """Return the keys in bytes that come in these parts, and then end."""
    out, into = os.pipe()
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.FileIO(out), encoding="ascii"))
    with keys.keyboard() as keyboard:
        found = []
        for part in parts:
            os.write(into, part)
            while key := keyboard(0.0):
                found.append(key)
        os.close(into)
        found.append(keyboard(0.1))
    return found


def test_every_key_has_one_name(monkeypatch):
    assert pressed(monkeypatch, b"a\x1b[A\x1b[B!\r", b"\x1b[5~\x1b[6~\x1bOC\x1b[D\x7fz") == [
        "a",
        "up",
        "down",
        "!",
        "enter",
        "page up",
        "page down",
        "right",
        "left",
        "backspace",
        "z",
        "end",
    ]


def test_a_lone_escape_does_not_wait_for_ever(monkeypatch):
    assert pressed(monkeypatch, b"\x1b", b"q") == ["\x1b", "q", "end"]


@pytest.fixture
def trimming():
    shown: list[str] = []
    with Robot("virtual:fast") as robot:
        straighten(robot)
        work = Trimming(robot, shown.append)
        work.shown = shown  # type: ignore[attr-defined]
        yield work


def centres(robot: Robot) -> list[float]:
    return [trim.centre_us for trim in robot.trims()]


def test_keys_move_the_chosen_servo(trimming):
    for key in ("up", "+", "page up", "right", "-", "5", "page down", "down", "left", "up", "x"):
        assert trimming.press(key)
    assert centres(trimming.robot) == [1512, 1499, 1500, 1501, 1489]
    assert [t.centre_us for t in trimming.trims] == centres(trimming.robot)


def test_digits_choose_the_joints_that_there_are():
    with Robot("virtual:fast:joints=7") as robot:
        work = Trimming(robot, lambda _: None)
        for key in ("7", "up", "8", "0", "up"):
            assert work.press(key)
        assert centres(robot) == [1500] * 6 + [1502]


def test_saved_outlives_the_power(trimming):
    trimming.press("page up")
    assert trimming.unsaved
    trimming.press("s")
    assert not trimming.unsaved
    board = firmware.Board()
    board.eeprom = trimming.robot._dialogue.link.board.eeprom
    board.boot("power")
    board.write(b"trim\n")
    board.run(0.2)
    assert b"trim: #1 centre=1510 " in board.read()


def test_the_limit_is_told_and_nothing_changes(trimming):
    for _ in range(11):  # 1600 us and 90 deg are the 2500 us that a pulse may have
        trimming.press("page up")
    assert centres(trimming.robot)[0] == 1600
    assert "pulse_ms" in trimming.shown[-1]


def test_leaving_unsaved_is_asked_once(trimming):
    trimming.press("up")
    assert trimming.press("q")
    assert "not saved" in trimming.shown[-1]
    assert trimming.press("up")
    assert trimming.press("q")
    assert trimming.press("")  # time passes
    assert not trimming.press("q")
    trimming.press("s")
    assert not trimming.press("q")


@pytest.mark.parametrize("how", ["q", "ctrl-c", "term", "unplugged"])
def test_trim_gives_the_terminal_back_however_it_is_left(how):
    with FakeBoard() as fake, Person(f"trim --json --port {fake.port}") as person:
        person.sees("joint 1  centre 1500 us")
        assert person.now != person.before
        assert fake.state == "pose"
        person.presses("3\x1b[A")
        person.sees("joint 3  centre 1501 us  (not saved)")
        if how == "q":
            person.presses("s")
            person.answers("saved on the board", "q")
        elif how == "ctrl-c":
            person.sends(signal.SIGINT)
        elif how == "term":
            person.sends(signal.SIGTERM)
        else:
            fake.unplug()
            person.presses("+")
        assert person.leaves() == {"q": 0, "ctrl-c": 130, "term": 143, "unplugged": 1}[how]
        assert ('"saved": true' in person.screen) == (how == "q")
        assert person.now == person.before
        assert fake.state == ("pose" if how == "unplugged" else "hold")
        assert "Traceback" not in person.screen


def monitored() -> tuple[Monitor, VirtualLink, list[str]]:
    link, shown = VirtualLink(fast=True), []
    talk = Monitor(link, shown.append, 50)
    talk.open()
    return talk, link, shown


def type_and_go(talk: Monitor, text: str) -> None:
    talk._keys = scripted(text)
    talk.go()


def scripted(text: str):
    """Return a keyboard on which a text is typed, then the input's end."""
    left = [*text]

    def key(_timeout_s: float) -> str:
        found = left.pop(0) if left else "\x04"
        return keys.NAMES.get(found, found)

    return key


def verdicts(shown: list[str]) -> list[str]:
    return [line for line in shown if line.startswith(("ok", "err"))]


def test_pings_keep_a_gait_going_and_stay_out_of_sight():
    talk, link, shown = monitored()
    type_and_go(talk, "gait 30 80 5\n")
    while link.now_s() < 10:
        talk.step()
    assert link.board.state == "gait"
    assert verdicts(shown) == ["ok: #0", "ok: #1"]
    assert len([line for line in shown if line.startswith("t:")]) == pytest.approx(10, abs=1)
    assert link.board.counters["good"] > 20
    talk.leave()
    assert link.board.state == "hold"
    assert not link.board.session


def test_one_key_stops_before_all_that_waits():
    talk, link, shown = monitored()
    type_and_go(talk, "gait 30 80 5\n")
    for key in [*"pose straight 2", "enter", "!"]:
        talk.press(key)
    for _ in range(3):
        talk.step()
    assert link.board.state == "hold"
    assert any(line.endswith("before it: pose straight 2") for line in shown)
    type_and_go(talk, "pose straight 2\n")
    assert link.board.state == "pose"


def test_a_reset_is_told_and_a_session_opened_again():
    talk, link, shown = monitored()
    type_and_go(talk, "gait 30 80 5\n")
    link.board.boot("brownout")
    while link.now_s() < 5:
        talk.step()
    assert link.board.session
    assert len([line for line in shown if "started again" in line]) == 1
    assert any("reset=brownout" in line for line in shown)
    type_and_go(talk, "gait 30 80 5\n")
    assert link.board.state == "gait"


def test_a_stop_key_that_is_lost_is_made_good_by_a_stop_that_is_confirmed():
    talk, link, shown = monitored()
    type_and_go(talk, "gait 30 80 5\n")
    write = link.write
    link.write = lambda data: write(data.replace(b"!", b"?"))  # the key is lost on the way
    talk.leave()
    assert link.board.state == "hold"
    assert verdicts(shown)[-2:] == ["ok: #2", "ok: #3"]


def test_a_stop_that_is_not_confirmed_is_told():
    talk, link, _ = monitored()
    type_and_go(talk, "gait 30 80 5\n")
    read = link.read
    link.read = lambda timeout_s: (read(timeout_s), b"")[1]
    with pytest.raises(StopUnconfirmed):
        talk.leave()


def test_damage_is_shown_and_a_verdict_that_never_comes_ends_it():
    talk, link, shown = monitored()
    read, link.read = link.read, lambda timeout_s: read(timeout_s).replace(b"ok: #", b"ok: $")
    with pytest.raises(RobotLost, match="no verdict for 'status'"):
        type_and_go(talk, "status\n")
    assert any(line.startswith("damaged: b'ok: $") for line in shown)


def test_what_the_board_could_not_read_is_not_sent():
    talk, _, shown = monitored()
    type_and_go(talk, f"{'x' * 90}\nping")
    assert any("at most 80" in line for line in shown)
    assert "not sent, for want of a line end: ping" in shown
    assert not any(line.startswith("ok: #1") for line in shown)


@pytest.mark.parametrize("closed", ["<&-", ">&-", "<&- >&-"])
def test_monitor_without_a_screen_or_keys(closed):
    run = subprocess.run(
        ["sh", "-c", f"{sys.executable} -m serpenoid monitor --port virtual {closed}"],
        input="status\n",
        capture_output=True,
        text=True,
        timeout=LONG_S,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")


def test_monitor_whose_reader_goes_away_stops_the_robot():
    with FakeBoard() as fake:
        child = subprocess.Popen(
            program(f"monitor --all --port {fake.port}"),
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
        assert child.wait(LONG_S) == 1
        child.stdin.close()


def piped(port: str, typed: str) -> str:
    """Return what the monitor says to a pipe that brings it some lines."""
    run = subprocess.run(
        program(f"monitor --port {port}"),
        input=typed,
        capture_output=True,
        text=True,
        timeout=LONG_S,
        check=True,
    )
    return run.stdout


def test_monitor_from_a_pipe(any_live_port):
    said = piped(any_live_port, "status\nfoo\n")
    assert "counters: good=2" in said
    assert "err: #2 command - no such command; type help" in said
    assert "\x1b" not in said


@pytest.mark.parametrize("typed", ["ping\n!", "!ping\n", "ping\n!ping\n", "!"])
def test_a_stop_typed_before_the_greeting_leaves_nothing_to_wait_for(any_live_port, typed):
    assert "ok: #!" in piped(any_live_port, typed)


def test_the_stop_key_goes_out_before_the_board_has_greeted():
    """A board that does not reset when its port is opened may be moving."""

    def deaf_to_hello(line: bytes) -> bytes:
        return b"" if b"hello" in line else line

    with (
        FakeBoard(nothing, deaf_to_hello) as fake,
        Person(f"monitor --port {fake.port}") as person,
    ):
        person.sees("Ctrl-D stops it and leaves")
        while not fake.await_state("gait", 0.3):  # it may reset only now
            fake.write(b"set silence off\ngait 30 80 5\n")
        person.presses("!")
        assert fake.await_state("hold")
        assert person.leaves() == 1
        assert person.now == person.before
        assert "no greeting" in person.screen


def test_what_is_typed_before_the_greeting_is_sent_after_it():
    with FakeBoard() as fake, Person(f"monitor --port {fake.port}") as person:
        person.answers("Ctrl-D stops it and leaves", "gait 30 80 5\r")
        person.answers("state: gait why=command", "\x04")
        assert person.leaves() == 0
        assert fake.state == "hold"


@pytest.mark.parametrize("how", ["ctrl-c", "ctrl-d", "term"])
def test_monitor_at_a_terminal(how):
    with FakeBoard() as fake, Person(f"monitor --port {fake.port}") as person:
        person.sees("Ctrl-D stops it and leaves")
        person.answers("ok: #0", "gait 30 80 5\r")
        person.answers("state: gait why=command", "idl")
        person.presses("!")
        person.answers("state: hold why=key", "\x7f\x7f\x7fgait 20 80 5\r")
        person.sees("state: gait why=command")
        if how == "ctrl-d":
            person.presses("\x04")
        else:
            person.sends(signal.SIGINT if how == "ctrl-c" else signal.SIGTERM)
        assert person.leaves() == (143 if how == "term" else 0)
        assert person.now == person.before
        assert fake.state == "hold"
        assert not fake.board.session


def test_trim_wants_a_person(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO())
    status, _, errors = serpenoid("trim --port virtual")
    assert (status, "no terminal" in errors) == (2, True)
