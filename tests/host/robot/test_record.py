"""Recordings: frames are read back, also from a truncated file; a full disk stops the robot."""

from __future__ import annotations

import fcntl
import os
import time
from itertools import islice

import numpy as np
import pytest
from refusals import refused
from robot.fake_board import GAIT, FakeBoard, FastBoard, drop_line
from robot.patience import LONG_S, clock
from robot.test_ends import start_program
from serpenoid.base.errors import NoAnswer, RecordingFailed
from serpenoid.robot import RobotBoard
from serpenoid.robot.recording import recorder
from serpenoid.robot.recording.stream import load_stream

needs_pipe_size = pytest.mark.skipif(
    not hasattr(fcntl, "F_SETPIPE_SZ"), reason="needs Linux, where a pipe can be made small"
)
PAGE = 4096


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "run.txt"
    with RobotBoard("virtual:fast", record=path) as robot:
        robot.gait(GAIT)
        frames = list(robot.frames(1.0))
    return path, frames


def test_a_recording_holds_all_frames(recorded):
    path, frames = recorded
    stream = load_stream(path)
    first = int(np.flatnonzero(stream.frame == frames[0].frame)[0])
    rows = slice(first, first + len(frames))
    for name in ("frame", "phase_rad", "state", "late_us"):
        assert getattr(stream, name)[rows].tolist() == [getattr(f, name) for f in frames]
    for name in ("setpoint_rad", "pulse_us"):
        assert getattr(stream, name)[rows].tolist() == [list(getattr(f, name)) for f in frames]
    np.testing.assert_allclose(np.diff(stream.board_s), 0.02, atol=1e-4)
    np.testing.assert_allclose(np.diff(stream.host_s), 0.02, atol=0.003)
    assert (stream.damaged, stream.end) == (0, "closed")
    assert any(" gait 30 80 5 0 *" in text for _, text in stream.sent)
    assert [t for _, t in stream.reports if t.startswith("state: gait why=command")]


def test_a_truncated_recording_keeps_its_complete_lines(recorded, tmp_path):
    path, _ = recorded
    whole, cut = path.read_bytes(), tmp_path / "cut.txt"
    header = whole.index(b"\n") + 1
    for end in [*range(header, header + 140, 3), *range(len(whole) - 140, len(whole) - 10, 3)]:
        cut.write_bytes(whole[:end])
        stream = load_stream(cut)
        assert len(stream.frame) == whole[:end].rpartition(b"\n")[0].count(b" < t:")
        assert stream.end is None
    assert load_stream(path).end == "closed"


def test_a_run_that_fails_to_start_leaves_no_file(tmp_path):
    path = tmp_path / "run.txt"
    for _ in range(2):
        with pytest.raises(NoAnswer), RobotBoard(FastBoard(drop_line), record=path, timeout_s=0.2):
            pass
    assert not path.exists()
    path.write_text("thesis\n")
    with refused("another name"), RobotBoard("virtual:fast", record=path):
        pass
    assert path.read_text() == "thesis\n"


FILL_DISK = """
import math, resource, signal, sys, time
from pathlib import Path
from serpenoid import Gait
from serpenoid.robot import RobotBoard
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
with RobotBoard(sys.argv[1], record=Path(sys.argv[2])) as robot:
    resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))
    robot.gait(Gait(math.radians(30), math.radians(80), 5.0))
    print("open", flush=True)
    sys.stdin.read()
    robot.straight()
"""


def test_a_full_disk_stops_the_robot_and_keeps_the_data(tmp_path):
    path = tmp_path / "run.txt"
    with FakeBoard() as fake:
        child = start_program(fake.port, FILL_DISK.replace("sys.argv[2]", repr(str(path))))
        assert fake.await_state("hold")
        errors = child.communicate("", timeout=LONG_S)[1]
        assert child.returncode == 1
        assert f"RecordingFailed: recording to {path} ended: File too large; " in errors
        assert b"pose straight" not in fake.received
    assert len(load_stream(path).frame) > 30


@pytest.fixture
def stalled(tmp_path):
    """Yield a FIFO that nobody reads: its writer blocks after one page."""
    path = tmp_path / "fifo"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    fcntl.fcntl(reader, fcntl.F_SETPIPE_SZ, PAGE)
    yield path, reader
    end_s = time.monotonic() + 2.0
    while read_nonblocking(reader) and time.monotonic() < end_s:  # until the writer has ended
        time.sleep(0.01)
    os.close(reader)


def read_nonblocking(reader: int) -> bytes:
    try:
        return os.read(reader, 65536)
    except BlockingIOError:
        return b"\n"


@needs_pipe_size
def test_a_stalled_disk_stops_no_robot_and_is_reported(stalled, monkeypatch):
    monkeypatch.setattr(recorder, "DISK_S", 0.2)
    with pytest.raises(RecordingFailed, match=r"stalled, and \d+ rows could not be written"):
        with RobotBoard("virtual", record=stalled[0]) as robot:
            robot.gait(GAIT)
            frames = list(islice(robot.frames(LONG_S), 60))
            start_s = clock()
            robot.stop()
            assert clock() - start_s < 5.0  # a stop that waits for the disk never ends
    assert len(frames) == 60
    assert robot.losses.missed_frames == 0


FIRST_LINE = b"# serpenoid wire 1, begun 2026\n"


@pytest.mark.parametrize(
    ("text", "where"),
    [
        (b"thesis\n", "no recording"),
        (FIRST_LINE + b"x < t:1\n", r":2: .*SECONDS < LINE"),
        (FIRST_LINE + b"0.5 < a\n0.3 < b\n", r":3: .*backwards"),
        (FIRST_LINE + b"0.5 < a\nnan < b\n", r":3: .*nan < b.*SECONDS < LINE"),
        (FIRST_LINE + b"inf > a\n", ":2: "),
        (FIRST_LINE + b"0.1 x a\n", r":2: .*SECONDS < LINE"),
        (FIRST_LINE + b"0.1 < \\xzz\n", r":2: .*escape"),
        (FIRST_LINE + "٣.٥ < a\n".encode(), r":2: .*SECONDS < LINE"),
        (FIRST_LINE + b"1_0.0 < a\n", ":2: "),
    ],
)
def test_an_invalid_recording_is_refused_with_its_line(tmp_path, text, where):
    path = tmp_path / "run.txt"
    path.write_bytes(text)
    with refused(where):
        load_stream(path)
