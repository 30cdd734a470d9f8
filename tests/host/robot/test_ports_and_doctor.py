"""Ports are opened by one program only; `ports` and `doctor` tell what is wrong with each."""

from __future__ import annotations

import os
import re
import time
from types import SimpleNamespace

import pytest
from command_line import answer, serpenoid
from robot.fake_board import (
    FakeBoard,
    change_body,
    change_greeting,
    drop_line,
    eeprom_after,
    keep_line,
)
from robot.terminal import Person
from serpenoid.base import system
from serpenoid.base.errors import PortBusy, PortMissing
from serpenoid.robot import RobotBoard
from serpenoid.robot.tools import doctor
from serpenoid.robot.tools.limp_test import FREE, RELEASED, limp_test
from serpenoid.robot.wire import ports
from serpenoid.robot.wire.virtual import VirtualLink


@pytest.fixture
def plugged(monkeypatch: pytest.MonkeyPatch):
    """Return a function that makes pyserial list these (device, vendor id)."""

    def plug(*rows: tuple[str, int | None]) -> None:
        found = [SimpleNamespace(device=d, description="x", vid=v, pid=0x43) for d, v in rows]
        monkeypatch.setattr("serial.tools.list_ports.comports", lambda: found)

    return plug


def opened(port: str | None) -> None:
    with RobotBoard(port, timeout_s=0.2):
        pass


def test_two_programs_cannot_have_one_port_and_the_first_does_not_notice():
    with FakeBoard() as fake:
        played = os.open(fake.port, os.O_RDWR | os.O_NOCTTY)  # who plays a board may keep it open
        with RobotBoard(fake.port) as robot:
            boot = robot.hello.boot
            with pytest.raises(PortBusy, match=r"another program .*lock.*: close"):
                opened(fake.port)
            assert "close serial monitors" in found(fake.port)["other programs"].fix
            assert robot.status().boot == boot
        os.close(played)


@pytest.mark.parametrize("vendor", [0x2341, 0x2A03, 0x1A86, 0x0403])
def test_the_one_board_is_found_by_its_usb_id(plugged, vendor):
    with FakeBoard() as fake:
        plugged(("/dev/ttyS0", None), (fake.port, vendor), ("/dev/ttyUSB1", 0x1234))
        opened(None)
        mine, other, _ = sorted(answer("ports")["ports"], key=lambda row: not row["chip"])
        assert (mine["device"], mine["usb"]) == (fake.port, f"{vendor:04x}:0043")
        assert not other["chip"]


def test_several_boards_or_none_are_listed(plugged, monkeypatch):
    plugged(("/dev/ttyACM0", 0x2341), ("/dev/ttyUSB0", 0x1A86))
    with pytest.raises(PortMissing, match=r"2 ports.*ttyACM0 \(Arduino, x\).*ttyUSB0"):
        opened(None)
    assert "likely a board (Arduino)" in serpenoid("ports").stdout
    assert "name one of them" in found(None)["port"].fix
    plugged(("/dev/ttyS0", None))
    monkeypatch.setattr(system, "usb_vendors", lambda: {"1a86"})
    with pytest.raises(PortMissing, match=r"here: /dev/ttyS0\. A CH340.*brltty.*plug the board in"):
        opened(None)
    plugged()
    assert "no board found" in serpenoid("ports").stderr
    assert "ports here: none" in found(None)["port"].fix


@pytest.mark.parametrize(("group", "cure"), [("uucp", "usermod -aG uucp "), ("root", "udev")])
def test_a_port_that_is_forbidden_names_the_group_or_a_rule(group, cure, monkeypatch):
    monkeypatch.setattr("grp.getgrgid", lambda _: SimpleNamespace(gr_name=group))
    monkeypatch.setattr(ports, "allowed", lambda _: False)
    with FakeBoard() as fake:
        told = found(fake.port)
    assert cure in told["permission"].fix
    assert "-aG root" not in told["permission"].fix
    assert "greeting" not in told


@pytest.mark.parametrize("port", ["virtual", "virtual:fast"])
def test_nothing_is_wrong_with_the_virtual_board(port):
    told = answer(f"doctor --port {port} --listen-s 0.5")
    assert told["well"]
    assert [f["name"] for f in told["findings"]] == [
        *("port", "greeting", "protocol", "settings", "without pulses", "counters"),
        *("timing", "clock", "platformio"),
    ]
    status, _, said = serpenoid(f"doctor --port {port} --listen-s 0")
    assert (status, "at least 0.2 and at most 600" in said) == (2, True)


def found(port: str | None) -> dict[str, doctor.Finding]:
    return {f.name: f for f in doctor.examine(port, listen_s=0.3, timeout_s=0.6)}


def damaged_settings() -> bytes:
    eeprom = bytearray(eeprom_after())
    eeprom[100] ^= 1  # in the one copy that there is
    return bytes(eeprom)


def counted(name: bytes, field: bytes, value: bytes):
    return lambda line: change_body(line, field, value) if line.startswith(name) else line


SICK = {  # what is wrong with the board: its tamper, its EEPROM; the finding and its mark and fix
    "silent": (drop_line, b"", "greeting", "fix", "is it flashed"),
    "another protocol": (
        change_greeting(rb"protocol=\d+", b"protocol=7"), b"", "protocol", "fix", "serpenoid flash",
    ),
    "a bad cable": (
        lambda said: re.sub(rb"t:(\d*[05]) j1", rb"t:\1 j!", said), b"", "counters", "fix", "cable",
    ),
    "settings": (keep_line, damaged_settings(), "settings", "fix", ""),
    "brown-out": (change_greeting(b"=external", b"=brownout"), b"", "last reset", "fix", "supply"),
    "silence off": (keep_line, eeprom_after("set silence off"), "silence", "note", ""),
    "lost bytes": (counted(b"counters:", b"rxfull=0", b"rxfull=3"), b"", "counters", "fix", ""),
    "overruns": (counted(b"timing:", rb"overruns=\d+", b"overruns=1"), b"", "timing", "fix", ""),
    "lateness": (counted(b"timing:", rb"late_us=\d+", b"late_us=5000"), b"", "timing", "fix", ""),
}  # fmt: skip


@pytest.mark.parametrize("board", SICK)
def test_the_doctor_names_what_a_board_has_and_moves_nothing(board):
    tamper, eeprom, name, mark, fix = SICK[board]
    with FakeBoard(tamper, eeprom=eeprom or None) as fake:
        told = found(fake.port)
        assert fake.board.setpoints_rad == [0.0] * 5
        assert fake.state == "idle"
    assert (told[name].mark, fix in told[name].fix) == (mark, True), told
    others = {n for n, f in told.items() if f.mark == "fix"} - {name}
    assert not others or board in ("settings", "another protocol")


@pytest.mark.parametrize(("turns", "code"), [(True, 1), (False, 2)])
def test_the_limp_tests_answer_is_kept_on_the_board(turns, code):
    link = VirtualLink(fast=True)
    assert limp_test(link, lambda text: turns or text == FREE) == RELEASED[code]
    assert link.board.state == "idle"
    link.board.boot("power")
    with RobotBoard(link) as robot:
        assert (robot.hello.settings, robot.settings()["released"]) == ("ok", code)


def test_the_limp_test_asks_before_anything_moves():
    with (
        FakeBoard(pace=time.monotonic) as fake,
        Person(f"doctor --limp --listen-s 0.3 --port {fake.port}") as one,
    ):
        one.sees("free space all around")
        assert b" pose " not in fake.received
        one.presses("n\r")
        one.sees("not tried")
        assert one.leaves() == 0
        assert b" pose " not in fake.received
