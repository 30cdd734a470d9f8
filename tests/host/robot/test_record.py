"""A run on disk: what came is read back, cut off or not, and a full disk stops the robot."""

from __future__ import annotations

import fcntl
import os
import time
from itertools import islice

import numpy as np
import pytest
from refusals import refused
from robot.fake_board import GAIT, FakeBoard, FastBoard, nothing
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


def test_frames_read_back_as_they_came(recorded):
    path, frames = recorded
    stream = load_stream(path)
    first = int(np.flatnonzero(stream.frame == frames[0].frame)[0])
    mine = slice(first, first + len(frames))
    for name in ("frame", "phase_rad", "state", "late_us"):
        assert getattr(stream, name)[mine].tolist() == [getattr(f, name) for f in frames]
    for name in ("setpoint_rad", "pulse_us"):
        assert getattr(stream, name)[mine].tolist() == [list(getattr(f, name)) for f in frames]
    np.testing.assert_allclose(np.diff(stream.board_s), 0.02, atol=1e-4)
    np.testing.assert_allclose(np.diff(stream.host_s), 0.02, atol=0.003)
    assert (stream.damaged, stream.end) == (0, "closed")
    assert any(" gait 30 80 5 0 *" in text for _, text in stream.sent)
    assert [t for _, t in stream.reports if t.startswith("state: gait why=command")]


def test_any_cut_leaves_every_whole_line(recorded, tmp_path):
    path, _ = recorded
    whole, cut = path.read_bytes(), tmp_path / "cut.txt"
    header = whole.index(b"\n") + 1
    for end in [*range(header, header + 140, 3), *range(len(whole) - 140, len(whole) - 10, 3)]:
        cut.write_bytes(whole[:end])
        stream = load_stream(cut)
        assert len(stream.frame) == whole[:end].rpartition(b"\n")[0].count(b" < t:")
        assert stream.end is None
    assert load_stream(path).end == "closed"


def test_a_run_that_never_began_leaves_its_name_free(tmp_path):
    path = tmp_path / "run.txt"
    for _ in range(2):
        with pytest.raises(NoAnswer), RobotBoard(FastBoard(nothing), record=path, timeout_s=0.2):
            pass
    assert not path.exists()
    path.write_text("thesis\n")
    with refused("another name"), RobotBoard("virtual:fast", record=path):
        pass
    assert path.read_text() == "thesis\n"


FILLING = """
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


def test_a_disk_that_fills_up_stops_the_robot_and_keeps_the_data(tmp_path):
    path = tmp_path / "run.txt"
    with FakeBoard() as fake:
        child = start_program(fake.port, FILLING.replace("sys.argv[2]", repr(str(path))))
        assert fake.await_state("hold")
        said = child.communicate("", timeout=LONG_S)[1]
        assert child.returncode == 1
        assert f"RecordingFailed: recording to {path} ended: File too large; " in said
        assert b"pose straight" not in fake.received
    assert len(load_stream(path).frame) > 30


@pytest.fixture
def stalled(tmp_path):
    """Return a FIFO whose reader takes nothing: it holds a page, then blocks who writes."""
    path = tmp_path / "fifo"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    fcntl.fcntl(reader, fcntl.F_SETPIPE_SZ, PAGE)
    yield path, reader
    end_s = time.monotonic() + 2.0
    while reads(reader) and time.monotonic() < end_s:  # let the writer go
        time.sleep(0.01)
    os.close(reader)


def reads(reader: int) -> bytes:
    try:
        return os.read(reader, 65536)
    except BlockingIOError:
        return b"\n"


@needs_pipe_size
def test_a_stalled_disk_stops_nothing_and_is_told(stalled, monkeypatch):
    monkeypatch.setattr(recorder, "DISK_S", 0.2)
    with pytest.raises(RecordingFailed, match=r"stalled, and \d+ rows could not be written"):
        with RobotBoard("virtual", record=stalled[0]) as robot:
            robot.gait(GAIT)
            frames = list(islice(robot.frames(LONG_S), 60))
            begun_s = clock()
            robot.stop()
            assert clock() - begun_s < 5.0  # whoever waited for this disk would wait for ever
    assert len(frames) == 60
    assert robot.losses.missed_frames == 0


TITLE = b"# serpenoid wire 1, begun 2026\n"


@pytest.mark.parametrize(
    ("text", "where"),
    [
        (b"thesis\n", "no recording"),
        (TITLE + b"x < t:1\n", r":2: .*SECONDS < LINE"),
        (TITLE + b"0.5 < a\n0.3 < b\n", r":3: .*backwards"),
        (TITLE + b"0.5 < a\nnan < b\n", r":3: .*nan < b.*SECONDS < LINE"),
        (TITLE + b"inf > a\n", ":2: "),
        (TITLE + b"0.1 x a\n", r":2: .*SECONDS < LINE"),
        (TITLE + b"0.1 < \\xzz\n", r":2: .*escape"),
        (TITLE + "٣.٥ < a\n".encode(), r":2: .*SECONDS < LINE"),
        (TITLE + b"1_0.0 < a\n", ":2: "),
    ],
)
def test_a_recording_that_cannot_be_true_is_refused_by_line(tmp_path, text, where):
    path = tmp_path / "run.txt"
    path.write_bytes(text)
    with refused(where):
        load_stream(path)
