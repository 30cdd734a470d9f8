"""The command `flash` against a PlatformIO that succeeds, fails in each way, or is not there."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import program, serpenoid
from robot.fake_board import FakeBoard, nothing
from robot.patience import until
from serpenoid.robot.tools import upload as flash

ROOT = Path(__file__).parents[3]
BUILT = 'echo "Building in release mode"; echo "Uploading .pio/build/uno/firmware.hex"'


@pytest.fixture
def pio(tmp_path, monkeypatch):
    """Return a function that puts a `pio` of this shell script first on PATH."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")

    def write(script: str) -> Path:
        path = folder / "pio"
        kept = f'echo "$@" > {folder}/arguments; echo "$PLATFORMIO_BUILD_FLAGS" > {folder}/flags'
        path.write_text(f"#!/bin/sh\n{kept}\n{script}\n")
        path.chmod(0o755)
        return folder / "arguments"

    return write


def test_success_ends_with_the_greeting(pio):
    arguments = pio(f'{BUILT}; echo "avrdude done"; exit 0')
    with FakeBoard() as board:
        status, said, shown = serpenoid(f"flash --board mega --port {board.port} --json")
    assert status == 0
    assert json.loads(said)["firmware"] == "0.2.0"
    assert "avrdude done" in shown
    assert arguments.read_text() == (
        f"run -d {ROOT} -e mega -t upload --upload-port {board.port}\n"
    )


def test_joints_and_output_become_build_flags(pio, monkeypatch):
    monkeypatch.setenv("PLATFORMIO_BUILD_FLAGS", "-D MINE")
    arguments = pio(f"{BUILT}; exit 0")
    with FakeBoard() as board:
        options = f"--board uno --port {board.port} --output pca9685"
        assert serpenoid(f"flash {options}")[0] == 0
        flags = arguments.with_name("flags").read_text()
        assert flags == "-D MINE -D SERPENOID_JOINTS=5 -D SERPENOID_PCA9685\n"
        status, _, errors = serpenoid(f"flash {options} --joints 7")
    assert status == 1
    assert "greets with 5 joints, built were 7" in errors


@pytest.mark.parametrize(("board", "joints"), [("uno", 9), ("uno", 1), ("mega", 13)])
def test_joints_that_a_board_cannot_have_are_refused(pio, board, joints):
    arguments = pio("exit 0")
    with FakeBoard() as fake:
        options = f"--board {board} --port {fake.port} --joints {joints}"
        status, _, errors = serpenoid(f"flash {options}")
    assert status == 2
    assert f"joints is {joints}; the {board} takes 2 to" in errors
    assert not arguments.exists()


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ('echo "main.cpp:3: error: x"; exit 1', "did not compile (pio exited 1)"),
        ('echo "HTTPClientError: no route"; exit 1', "connect to the internet"),
        ("echo \"Error: Unknown environment names 'mega'\"; exit 1", "platformio.ini has no"),
        (f'{BUILT}; echo "stk500_getsync(): not in sync"; exit 1', "boot loader does not answer"),
        (f'{BUILT}; echo "can\'t open device /dev/x"; exit 1', "serpenoid doctor"),
        (
            f'{BUILT}; echo "avrdude: Expected signature for ATmega328P is"; exit 1',
            "another chip",
        ),
        (f'{BUILT}; echo "*** [upload] Error 1"; exit 7', "the upload failed (pio exited 7)"),
    ],
)
def test_each_failure_has_its_cure(pio, script, said):
    pio(script)
    with FakeBoard() as board:
        status, _, errors = serpenoid(f"flash --board mega --port {board.port}")
        assert not board.received
    assert status == 1
    assert said in errors


def test_a_board_that_is_silent_afterwards(pio, monkeypatch):
    pio(f"{BUILT}; exit 0")
    monkeypatch.setattr(flash, "GREETING_S", 0.3)
    with FakeBoard(nothing) as board:
        status, _, errors = serpenoid(f"flash --board uno --port {board.port}")
    assert (status, "no greeting" in errors) == (1, True)


def test_without_platformio(monkeypatch):
    monkeypatch.setattr(flash, "find_platformio", lambda: None)
    status, _, errors = serpenoid("flash --board uno --port /dev/null")
    assert (status, "pip install platformio" in errors) == (1, True)
    refused = serpenoid("flash --board uno --port /dev/null --joints 9")
    assert (refused[0], "take a Mega" in refused[2]) == (2, True)


@pytest.mark.parametrize(
    ("reached", "number", "status"),
    [("Building", signal.SIGINT, 130), ("Uploading", signal.SIGTERM, 143)],
)
def test_a_signal_ends_platformio_and_what_it_started(pio, tmp_path, reached, number, status):
    """Before the upload the board is whole; amid it it has half a program."""
    child = tmp_path / "child"
    pio(f"sleep 60 & echo $! > {child}; echo {reached} ...; wait")
    with FakeBoard() as board:
        run = subprocess.Popen(
            program(f"flash --board uno --port {board.port}"),
            stderr=subprocess.PIPE,
            text=True,
        )
        assert reached in run.stderr.readline()  # so the child runs, and who would end it listens
        run.send_signal(number)
        _, said = run.communicate(timeout=60)
    assert run.returncode == status
    assert ("half a program" in said) == (reached == "Uploading")
    assert until(lambda: not alive(int(child.read_text())))


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except FileNotFoundError:
        return False


def test_the_usb_id_tells_an_uno_and_a_mega(monkeypatch, pio):
    rows = [("/dev/ttyA", 0x2341, 0x43), ("/dev/ttyB", 0x2A03, 0x42), ("/dev/ttyC", 0x1A86, 0x7523)]
    found = [SimpleNamespace(device=d, description="", vid=v, pid=p) for d, v, p in rows]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: found)
    assert flash.board_at("/dev/ttyA") == "uno"
    assert flash.board_at("/dev/ttyB") == "mega"
    pio("exit 0")
    status, _, errors = serpenoid("flash --port /dev/ttyC")
    assert (status, "give --board uno|nano|nano_old|mega" in errors) == (2, True)


def test_what_cannot_be_flashed(pio, tmp_path):
    pio("exit 0")
    status, _, errors = serpenoid("flash --port virtual")
    assert (status, "no flash memory" in errors) == (2, True)
    status, _, errors = serpenoid(f"flash --board uno --project {tmp_path}")
    assert (status, "--project" in errors) == (2, True)
    status, _, errors = serpenoid("flash --board due")
    assert status == 2


@pytest.mark.parametrize("port", ["ttyACM0", "a\x01b", "/tmp", "{folder}/file", "{folder}/no"])
def test_what_is_no_port_is_told_before_anything_is_built(pio, tmp_path, port):
    arguments = pio("exit 0")
    (tmp_path / "file").touch()
    port = port.format(folder=tmp_path)
    status, _, errors = serpenoid(f"flash --board uno --port {port}")
    assert (status, "there is no port" in errors) == (1, True)
    assert not arguments.exists()


def test_a_platformio_that_cannot_run(pio):
    pio("exit 0").with_name("pio").write_text("#!/nowhere/python\n")
    before = signal.getsignal(signal.SIGTERM)
    with FakeBoard() as board:
        status, _, errors = serpenoid(f"flash --board uno --port {board.port}")
    assert (status, "PlatformIO cannot be started" in errors) == (1, True)
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.fixture
def wheel(monkeypatch, tmp_path):
    """Pretend that the package came as a wheel, with a firmware in it; return its folder."""
    brought = tmp_path / "site-packages" / "serpenoid"
    (brought / "board" / "firmware" / "src").mkdir(parents=True)
    (brought / "board" / "platformio.ini").touch()
    (brought / "board" / "firmware" / "src" / "main.cpp").touch()
    monkeypatch.setattr(flash._core, "__file__", str(brought / "_core.so"))
    monkeypatch.setattr(flash, "__file__", str(brought / "robot" / "tools" / "a" / "upload.py"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    return brought / "board"


def test_a_wheel_brings_its_firmware_and_nothing_of_another_day(wheel, pio):
    arguments = pio("echo 'x.cpp:1: error'; exit 1")
    with FakeBoard() as board:
        for _ in range(2):
            status, _, errors = serpenoid(f"flash --board uno --port {board.port}")
            folder = Path(arguments.read_text().split()[2])
            sources = folder / "firmware" / "src"
            assert [path.name for path in sources.iterdir()] == ["main.cpp"]
            (sources / "gone.cpp").touch()
    assert (status, f"what was changed in {folder}?" in errors) == (1, True)


def test_a_cache_that_cannot_be_written(wheel, pio, monkeypatch):
    pio("exit 0")
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    status, _, errors = serpenoid("flash --board uno --port /dev/ttyS0")
    assert (status, "set XDG_CACHE_HOME" in errors) == (1, True)


def test_the_boards_are_those_of_platformio_ini():
    ini = (ROOT / "platformio.ini").read_text()
    for board in flash.BOARDS:
        assert f"[env:{board}]" in ini
