"""Opening a port: taken by one program only, and what to do when it cannot be had."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from robot.fake_board import FakeBoard
from robot.patience import LONG_S
from serial.tools import list_ports
from serpenoid.base import system
from serpenoid.base.errors import PortBusy, PortMissing, RobotClosed
from serpenoid.robot import Robot
from serpenoid.robot.wire import link

PACKAGE = Path(link.__file__).parents[1]
OPENING = "import sys; from serpenoid.robot import Robot\nwith Robot(sys.argv[1]): pass"


def usb(device: str, vendor: int | None, description: str = "a port") -> SimpleNamespace:
    return SimpleNamespace(device=device, description=description, vid=vendor, pid=0x43)


@pytest.fixture
def plugged_in(monkeypatch):
    def plug(*ports: SimpleNamespace) -> None:
        monkeypatch.setattr(list_ports, "comports", lambda: list(ports))

    return plug


def test_two_programs_cannot_have_one_port_and_the_first_does_not_notice():
    with FakeBoard() as fake, Robot(fake.port) as robot:
        boot = robot.hello.boot
        with pytest.raises(PortBusy, match=r"another program .*lock.*: close"), Robot(fake.port):
            pass
        other = subprocess.run(
            [sys.executable, "-c", OPENING, fake.port],
            capture_output=True,
            text=True,
            timeout=LONG_S,
            check=False,
        )
        assert f"PortBusy: {fake.port} is in use by another program" in other.stderr
        assert robot.status().boot == boot


def test_who_plays_the_board_behind_a_pseudo_terminal_may_keep_it_open():
    with FakeBoard() as fake:
        played = os.open(fake.port, os.O_RDWR | os.O_NOCTTY)
        for _ in range(2):
            with Robot(fake.port) as robot:
                robot.straight()
                with pytest.raises(PortBusy), Robot(fake.port):
                    pass
        os.close(played)


def test_a_port_that_is_forbidden_names_the_group(tmp_path, monkeypatch):
    monkeypatch.setattr("grp.getgrgid", lambda _: SimpleNamespace(gr_name="uucp"))
    port = tmp_path / "tty"
    port.touch()
    error = link._refused(str(port), PermissionError(13, "Permission denied"))
    assert isinstance(error, PortBusy)
    assert "usermod -aG uucp " in str(error)


def test_a_port_that_is_not_there_or_is_no_port(tmp_path, plugged_in):
    plugged_in(usb("/dev/ttyACM3", 0x2341))
    with pytest.raises(PortMissing, match=r"no port /dev/none; serial ports here: /dev/ttyACM3"):
        link.open_link("/dev/none")
    (tmp_path / "file").touch()
    with pytest.raises(PortMissing, match="cannot be used as a serial port"):
        link.open_link(str(tmp_path / "file"))


@pytest.mark.parametrize("vendor", [0x2341, 0x2A03, 0x1A86, 0x0403])
def test_the_one_board_is_found_by_its_usb_id(plugged_in, vendor):
    plugged_in(usb("/dev/ttyS0", None), usb("/dev/ttyUSB7", vendor), usb("/dev/ttyUSB1", 0x1234))
    assert link.find_port() == "/dev/ttyUSB7"


def test_several_boards_or_none_are_listed(plugged_in, monkeypatch):
    plugged_in(usb("/dev/ttyACM0", 0x2341, "Uno"), usb("/dev/ttyUSB0", 0x1A86, "Nano"))
    with pytest.raises(PortMissing, match=r"2 ports.*ttyACM0 \(Arduino, Uno\).*ttyUSB0"):
        link.find_port()
    plugged_in(usb("/dev/ttyS0", None))
    monkeypatch.setattr(system, "usb_vendors", lambda: {"1a86"})
    with pytest.raises(PortMissing, match=r"here: /dev/ttyS0\. A CH340.*brltty.*plug the board in"):
        link.find_port()


def test_a_robot_is_used_inside_its_block_only_and_once():
    with FakeBoard() as fake:
        robot = Robot(fake.port)
        with pytest.raises(RobotClosed, match="with Robot"):
            robot.straight()
        with robot:
            robot.straight()
    for use in (robot.straight, robot.stop, lambda: next(robot.frames(1.0)), robot.__enter__):
        with pytest.raises(RobotClosed):
            use()


def test_pyserial_is_imported_in_two_files_and_only_when_used():
    using = {
        p.name
        for p in PACKAGE.glob("**/*.py")
        if re.search(r"(from|import) serial\b", p.read_text())
    }
    assert using == {"link.py", "ports.py"}
    heavy = "import sys, serpenoid.robot; print({'serial', 'numpy'} & set(sys.modules))"
    assert subprocess.check_output([sys.executable, "-c", heavy], text=True) == "set()\n"
