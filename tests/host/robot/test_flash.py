"""The command `flash` with a PlatformIO that succeeds, fails in several ways, or is missing."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import program, serpenoid
from robot.fake_board import FakeBoard, drop_line
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

    def write(script: str, first: str = "#!/bin/sh") -> Path:
        path = folder / "pio"
        kept = f'echo "$@" > {folder}/arguments; echo "$PLATFORMIO_BUILD_FLAGS" > {folder}/flags'
        path.write_text(f"{first}\n{kept}\n{script}\n")
        path.chmod(0o755)
        return folder / "arguments"

    return write


def test_success_ends_with_the_greeting_of_the_new_firmware(pio, monkeypatch):
    monkeypatch.setenv("PLATFORMIO_BUILD_FLAGS", "-D MINE")
    arguments = pio(f'{BUILT}; echo "avrdude done"; exit 0')
    with FakeBoard() as board:
        options = f"flash --board mega --port {board.port} --output pca9685"
        status, output, messages = serpenoid(options)
        assert (status, "avrdude done" in messages) == (0, True)
        assert "runs firmware 0.3.0" in output
        upload = f"run -d {ROOT} -e mega -t upload --upload-port {board.port}\n"
        assert arguments.read_text() == upload
        flags = arguments.with_name("flags").read_text()
        assert flags == "-D MINE -D SERPENOID_JOINTS=5 -D SERPENOID_PCA9685\n"
        status, _, errors = serpenoid(f"{options} --joints 7")
    assert (status, "greets with 5 joints, built were 7" in errors) == (1, True)


CAUSES = [
    ('echo "main.cpp:3: error: x"; exit 1', "did not compile (pio exited 1)"),
    ('echo "HTTPClientError: no route"; exit 1', "connect to the internet"),
    (f'{BUILT}; echo "stk500_getsync(): not in sync"; exit 1', "boot loader does not answer"),
    (f'{BUILT}; echo "can\'t open device /dev/x"; exit 1', "serpenoid doctor"),
    (f'{BUILT}; echo "avrdude: Expected signature for ATmega328P is"; exit 1', "another chip"),
    (f'{BUILT}; echo "*** [upload] Error 1"; exit 7', "the upload failed (pio exited 7)"),
]


@pytest.mark.parametrize(("script", "message"), CAUSES)
def test_each_failure_has_its_cure(pio, script, message):
    pio(script)
    with FakeBoard() as board:
        status, _, errors = serpenoid(f"flash --board mega --port {board.port}")
        assert not board.received
    assert (status, message in errors) == (1, True), errors


def test_a_silent_board_and_a_platformio_that_cannot_run(pio, monkeypatch):
    monkeypatch.setattr(flash, "GREETING_S", 0.3)
    handlers = set()
    with FakeBoard(drop_line) as board:
        for first, message in (("#!/bin/sh", "no greeting"), ("#!/no", "no such file")):
            pio(f"{BUILT}; exit 0", first)
            status, _, errors = serpenoid(f"flash --board uno --port {board.port}")
            assert (status, message in errors) == (1, True), errors
            handlers.add(signal.getsignal(signal.SIGTERM))
    assert len(handlers) == 1
    monkeypatch.setattr(flash, "find_platformio", lambda: None)
    status, _, errors = serpenoid("flash --board uno --port /dev/null")
    assert (status, "pip install platformio" in errors) == (1, True)


@pytest.mark.parametrize(
    ("options", "status", "message"),
    [
        ("--board uno --joints 9 --port /dev/null", 2, "a mega up to 12"),
        ("--board uno --joints 1 --port /dev/null", 2, "joints is 1; the uno takes 2 to 8"),
        ("--board mega --joints 13 --port /dev/null", 2, "joints is 13; the mega takes 2 to 12"),
        ("--board due", 2, "due"),
        ("--port virtual", 2, "no flash memory"),
        ("--port /dev/ttyC", 2, "give --board uno|nano|nano_old|mega"),
        *((f"--board uno --port {p}", 1, "there is no port") for p in ("tty", "a\x01b", "/tmp")),
    ],
)
def test_wrong_options_are_refused_before_the_build(pio, monkeypatch, options, status, message):
    found = SimpleNamespace(device="/dev/ttyC", description="", vid=0x1A86, pid=0x7523)
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [found])
    arguments = pio("exit 0")
    result = serpenoid(f"flash {options}")
    assert (result.returncode, message in result.stderr) == (status, True), result.stderr
    assert not arguments.exists()


@pytest.mark.parametrize(
    ("reached", "number", "status"),
    [("Building", signal.SIGINT, 130), ("Uploading", signal.SIGTERM, 143)],
)
def test_a_signal_ends_platformio_and_its_children(pio, tmp_path, reached, number, status):
    """A signal during the upload leaves half a program on the board; the message says so."""
    child = tmp_path / "child"
    pio(f"sleep 60 & echo $! > {child}; echo {reached} ...; wait")
    with FakeBoard() as board:
        run = subprocess.Popen(
            program(f"flash --board uno --port {board.port}"), stderr=subprocess.PIPE, text=True
        )
        assert reached in run.stderr.readline()  # the child runs, and signals are handled
        run.send_signal(number)
        _, messages = run.communicate(timeout=60)
    assert run.returncode == status
    assert ("half a program" in messages) == (reached == "Uploading")
    assert until(lambda: not alive(int(child.read_text())))


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except FileNotFoundError:
        return False


def test_a_wheel_builds_its_own_firmware_in_a_cache(pio, tmp_path, monkeypatch):
    """Files of other releases are removed from the cache."""
    package = tmp_path / "site-packages" / "serpenoid"
    (package / "board" / "firmware" / "src").mkdir(parents=True)
    (package / "board" / "platformio.ini").touch()
    (package / "board" / "firmware" / "src" / "main.cpp").touch()
    monkeypatch.setattr(flash._core, "__file__", str(package / "_core.so"))
    monkeypatch.setattr(flash, "__file__", str(package / "robot" / "tools" / "a" / "upload.py"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    arguments = pio("echo 'x.cpp:1: error'; exit 1")
    with FakeBoard() as board:
        for _ in range(2):
            status, _, errors = serpenoid(f"flash --board uno --port {board.port}")
            folder = Path(arguments.read_text().split()[2])
            sources = folder / "firmware" / "src"
            assert [path.name for path in sources.iterdir()] == ["main.cpp"]
            (sources / "gone.cpp").touch()
    assert (status, f"what was changed in {folder}?" in errors) == (1, True)
