"""A run on disk: what came is read back, cut off or not, and a full disk stops the robot."""

from __future__ import annotations

import math
import signal
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from robot.fake_board import FakeBoard
from robot.test_leaving import drive
from serpenoid import Gait
from serpenoid.model.errors import BadInput, NoAnswer, RecordingFailed
from serpenoid.robot import Robot
from serpenoid.robot.wire.record import Recorder, load_stream

GAIT = Gait(alpha_rad=math.radians(30), beta_rad=math.radians(80), omega_rad_s=5.0)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "run.txt"
    with Robot("virtual:fast", record=path) as robot:
        robot.gait(GAIT)
        frames = list(robot.frames(1.0))
    return path, frames


def test_frames_read_back_as_they_came(recorded):
    path, frames = recorded
    stream = load_stream(path)
    first = int(np.flatnonzero(stream.frame == frames[0].frame)[0])
    mine = slice(first, first + len(frames))
    assert stream.frame[mine].tolist() == [f.frame for f in frames]
    assert stream.setpoint_rad[mine].tolist() == [list(f.setpoint_rad) for f in frames]
    assert stream.pulse_us[mine].tolist() == [list(f.pulse_us) for f in frames]
    assert stream.phase_rad[mine].tolist() == [f.phase_rad for f in frames]
    assert stream.state[mine].tolist() == [f.state for f in frames]
    np.testing.assert_allclose(np.diff(stream.board_s), 0.02, atol=1e-4)
    np.testing.assert_allclose(np.diff(stream.host_s), 0.02, atol=0.003)
    assert (stream.damaged, stream.end) == (0, "closed")
    assert any(" gait 30 80 5 0 *" in text for _, text in stream.sent)
    assert [t for _, t in stream.said if t.startswith("state: gait why=command")]


def test_any_cut_leaves_every_whole_line(recorded, tmp_path):
    path, _ = recorded
    whole, cut = path.read_bytes(), tmp_path / "cut.txt"
    header = whole.index(b"\n") + 1
    for end in [*range(header, header + 140), *range(len(whole) - 140, len(whole) - 10)]:
        cut.write_bytes(whole[:end])
        stream = load_stream(cut)
        assert len(stream.frame) == whole[:end].rpartition(b"\n")[0].count(b" < t:")
        assert stream.end is None
    assert load_stream(path).end == "closed"


def test_damage_is_kept_as_it_came_and_counted(tmp_path):
    path = tmp_path / "run.txt"
    with FakeBoard() as fake, Robot(fake.port, record=path) as robot:
        fake.to_host = lambda line: b"\xff\x00\\" + line if line.startswith(b"t:") else line
        time.sleep(0.2)
        robot.status()
    assert load_stream(path).damaged >= 5
    assert b" < \\xff\\x00\\\\t:" in path.read_bytes()


def test_a_run_that_never_began_leaves_its_name_free(tmp_path):
    path = tmp_path / "run.txt"
    with FakeBoard(lambda _: b"") as fake:
        for _ in range(2):
            with pytest.raises(NoAnswer), Robot(fake.port, record=path, timeout_s=0.2):
                pass
    assert not path.exists()


def test_what_holds_data_is_not_overwritten_and_what_is_no_recording_is_refused(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("thesis\n")
    with pytest.raises(BadInput, match="another name"), Robot("virtual:fast", record=path):
        pass
    assert path.read_text() == "thesis\n"
    with pytest.raises(BadInput, match="no recording"):
        load_stream(path)
    path.write_text("# serpenoid wire 1, begun 2026\nx < t:1\n")
    with pytest.raises(BadInput, match="SECONDS"):
        load_stream(path)
    with pytest.raises(RecordingFailed, match="cannot read"):
        load_stream(tmp_path / "missing.txt")


@pytest.mark.skipif(
    not Path("/dev/full").exists(), reason="needs /dev/full, the full disk of Linux"
)
def test_a_disk_that_is_full_from_the_start_is_told_before_anything_moves():
    with FakeBoard() as fake:
        with pytest.raises(RecordingFailed, match=r"No space left.*another disk"):
            with Robot(fake.port, record=Path("/dev/full")) as robot:
                robot.gait(GAIT)
        assert fake.state == "idle"


FILLING = """
import math, resource, signal, sys, time
from pathlib import Path
from serpenoid import Gait
from serpenoid.robot import Robot
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
with Robot(sys.argv[1], record=Path(sys.argv[2])) as robot:
    resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))
    robot.gait(Gait(math.radians(30), math.radians(80), 5.0))
    print("open", flush=True)
    sys.stdin.read()
    robot.straight()
"""


def test_a_disk_that_fills_up_stops_the_robot_and_keeps_the_data(tmp_path):
    path = tmp_path / "run.txt"
    with FakeBoard() as fake:
        child = drive(fake.port, FILLING.replace("sys.argv[2]", repr(str(path))))
        assert fake.await_state("hold", 5.0)
        said = child.communicate("", timeout=10)[1]
        assert child.returncode == 1
        assert "RecordingFailed: recording to" in said
        assert b"pose straight" not in fake.received
    assert len(load_stream(path).frame) > 30


def test_a_row_that_was_written_in_part_ends_the_recording(tmp_path):
    recorder = Recorder(tmp_path / "run.txt", 0.0)
    recorder._file = SimpleNamespace(write=lambda row: len(row) - 1)
    with pytest.raises(RecordingFailed, match="part of a line"):
        recorder.line(0.0, "<", b"t:1")


def test_a_killed_program_loses_at_most_the_last_line(tmp_path):
    path = tmp_path / "run.txt"
    program = (
        "import sys\nfrom serpenoid.robot import Robot\n"
        f"with Robot(sys.argv[1], record={str(path)!r}) as robot:\n"
        "    print('open', flush=True)\n"
        "    for frame in robot.frames(): print(frame.frame, flush=True)\n"
    )
    with FakeBoard() as fake:
        child = drive(fake.port, program)
        time.sleep(0.4)
        child.send_signal(signal.SIGKILL)
        seen = [int(n) for n in child.communicate(timeout=10)[0].split()]
    frames = load_stream(path).frame.tolist()
    assert len(seen) > 5
    assert set(seen) <= set(frames)
