"""What `ports` and `doctor` say of ports, boards and wires in every state."""

from __future__ import annotations

import re
import time
from types import SimpleNamespace

import pytest
from command_line import answer, serpenoid
from robot.fake_board import FakeBoard, eeprom_after, greeting, nothing, resealed
from robot.terminal import Person
from serpenoid.robot import Robot
from serpenoid.robot.tools import doctor
from serpenoid.robot.tools.limp_test import FREE, RELEASED, limp_test
from serpenoid.robot.wire import ports
from serpenoid.robot.wire.virtual import VirtualLink

FAST = {"listen_s": 0.3, "timeout_s": 2.0}


@pytest.fixture
def plugged(monkeypatch: pytest.MonkeyPatch):
    """Return a function that makes pyserial list these (device, vendor id, product id)."""

    def plug(*rows: tuple[str, int | None, int | None]) -> None:
        found = [SimpleNamespace(device=d, description="x", vid=v, pid=p) for d, v, p in rows]
        monkeypatch.setattr("serial.tools.list_ports.comports", lambda: found)

    return plug


def marks(port: str | None) -> dict[str, str]:
    return {f.name: f.mark for f in doctor.examine(port, **FAST)}


def fix_of(name: str, port: str | None) -> str:
    found = {f.name: f for f in doctor.examine(port, **FAST)}
    assert found[name].mark == "fix"
    return found[name].fix


def test_ports_lists_ids_and_boards(plugged):
    with FakeBoard() as board:
        plugged((board.port, 0x2341, 0x43), ("/dev/ttyS0", None, None))
        mine, other = answer("ports")["ports"]
        assert (mine["usb"], mine["chip"], mine["likely_board"]) == ("2341:0043", "Arduino", True)
        assert (other["usb"], other["likely_board"]) == (None, False)
        assert "likely a board (Arduino)" in serpenoid("ports")[1]
    plugged()
    assert serpenoid("ports") == (0, "", serpenoid("ports")[2])
    assert "no board found" in serpenoid("ports")[2]


@pytest.mark.parametrize("port", ["virtual", "virtual:fast"])
def test_nothing_is_wrong_with_the_virtual_board(port):
    told = answer(f"doctor --port {port} --listen-s 2")
    assert told["well"]
    names = [f["name"] for f in told["findings"]]
    assert names == [
        "pyserial",
        "port",
        "greeting",
        "protocol",
        "settings",
        "without pulses",
        "counters",
        "timing",
        "clock",
        "platformio",
    ]


def test_listening_too_short_to_hear_a_frame_is_refused():
    status, _, said = serpenoid("doctor --port virtual --listen-s 0")
    assert status == 2
    assert "0.2<=x<=600" in said


@pytest.mark.parametrize(("turns", "code"), [(True, 1), (False, 2)])
def test_the_limp_tests_answer_is_kept_on_the_board(turns, code):
    link = VirtualLink(fast=True)
    assert limp_test(link, lambda text: turns or text == FREE) == RELEASED[code]
    assert link.board.state == "idle"
    link.board.boot("power")
    with Robot(link) as robot:
        assert (robot.hello.settings, robot.settings()["released"]) == ("ok", code)


@pytest.mark.parametrize("free", ["y", "n"])
def test_the_limp_test_asks_before_anything_moves(free):
    with FakeBoard(pace=time.monotonic) as fake, Person(f"doctor --limp --port {fake.port}") as one:
        one.sees("free space all around")
        assert b" pose " not in fake.received
        one.presses(f"{free}\r")
        if free == "y":
            one.answers("turn its horn by hand", "y\r")
            one.sees("kept on the board: these servos go limp")
        else:
            one.sees("not tried")
        assert one.leaves() == 0
        assert (b" pose " in fake.received) == (free == "y")


def test_the_robot_is_not_moved_by_a_doctor():
    with FakeBoard() as board:
        assert "fix" not in marks(board.port).values()
        assert board.state == "idle"
        assert board.board.setpoints_rad == [0.0] * 5


def test_no_port_no_board_and_two_boards(plugged):
    plugged()
    assert "none at all" in fix_of("port", None)
    assert "serial ports here: none" in fix_of("port", "/dev/no-such-port")
    plugged(("/dev/ttyA", 0x2341, 0x43), ("/dev/ttyB", 0x1A86, 0x7523))
    assert "name one of them" in fix_of("port", None)


def test_a_port_that_may_not_be_opened(monkeypatch):
    monkeypatch.setattr(ports, "allowed", lambda _: False)
    with FakeBoard() as board:
        assert "usermod -aG" in fix_of("permission", board.port)
        assert "greeting" not in marks(board.port)


def test_a_port_in_use():
    with FakeBoard() as board, Robot(board.port):
        assert "close serial monitors" in fix_of("other programs", board.port)
        assert board.state == "idle"


def test_a_silent_board():
    with FakeBoard(nothing) as board:
        assert "is it flashed" in fix_of("greeting", board.port)


def test_another_protocol():
    with FakeBoard(greeting(rb"protocol=\d+", b"protocol=7")) as board:
        fix = fix_of("protocol", board.port)
        assert "protocol 7" in fix
        assert "serpenoid flash" in fix


def test_a_bad_cable():
    def noisy(said: bytes) -> bytes:
        return re.sub(rb"t:(\d*[05]) j1", rb"t:\1 j!", said)

    with FakeBoard(noisy) as board:
        assert "cable" in fix_of("counters", board.port)


def test_settings_damaged_and_a_brown_out():
    eeprom = bytearray(eeprom_after())
    eeprom[100] ^= 1  # in the one copy that there is
    with FakeBoard(greeting(b"=external", b"=brownout"), eeprom=bytes(eeprom)) as fake:
        found = {f.name: f for f in doctor.examine(fake.port, **FAST)}
    assert found["settings"].mark == found["last reset"].mark == "fix"
    assert "supply" in found["last reset"].fix


def test_silence_off_is_told():
    with FakeBoard(eeprom=eeprom_after("set silence off")) as fake:
        assert marks(fake.port)["silence"] == "note"


@pytest.mark.parametrize(
    ("name", "field", "bad"),
    [
        ("counters", rb"rxfull=0", b"rxfull=3"),
        ("timing", rb"overruns=\d+", b"overruns=1"),
        ("timing", rb"late_us=\d+", b"late_us=5000"),
    ],
)
def test_what_the_counters_and_the_timing_mean(name, field, bad):
    def busy(line: bytes) -> bytes:
        return resealed(line, field, bad) if line.startswith((b"counters:", b"timing:")) else line

    with FakeBoard(busy) as board:
        assert fix_of(name, board.port)
