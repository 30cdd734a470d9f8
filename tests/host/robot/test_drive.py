"""The command `drive`: what it tells, what it records, and how it is left."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest
from command_line import answer, serpenoid
from robot.fake_board import GAIT_TYPED as GAIT
from robot.fake_board import FakeBoard, FastBoard, change_greeting, eeprom_after
from serpenoid.robot.recording.stream import load_stream


def test_a_run_on_every_board(any_port, tmp_path):
    file = tmp_path / "run.wire"
    args = f"--port {any_port} --duration-s 2 --record {file} --json"
    status, said, _ = serpenoid(f"drive {GAIT} {args}")
    assert status == 0
    found = json.loads(said)
    assert found["gait"]["beta_deg"] == pytest.approx(80)
    assert found["missed_frames"] == found["damaged_lines"] == 0
    stream = load_stream(file)
    pace = np.polyfit(stream.host_s, stream.board_s, 1)[0]
    assert pace == pytest.approx(1.0, abs=0.05)
    assert found["frequency_hz"] == pytest.approx(pace * 5 / (2 * math.pi), rel=0.03)
    assert found["frequency_sd_hz"] < 0.05
    assert stream.sent[-1][1].split()[1] == "bye"
    assert len(stream.frame) >= found["frames"] > 50


def test_the_boards_own_clock_gives_the_gaits_own_frequency():
    found = answer(f"drive {GAIT} --port virtual:fast --duration-s 60")
    assert found["frames"] == 3000
    assert found["duration_s"] == pytest.approx(59.98)
    assert found["frequency_hz"] == pytest.approx(5 / (2 * math.pi), rel=1e-5)  # 2 ms steps


def test_plain_lines_where_there_is_no_terminal():
    status, said, _ = serpenoid(f"drive {GAIT} --port virtual:fast --duration-s 3")
    lines = [line for line in said.splitlines() if " deg  late " in line]
    assert (status, len(lines)) == (0, 3)
    assert re.match(r" +1\.0 s  gait  ", lines[1])
    assert "true gait frequency" in said


def test_markup_in_a_path_and_in_a_greeting_is_text(tmp_path, monkeypatch):
    board, file = (
        FastBoard(change_greeting(rb"board=\S+", b"board=[/b]")),
        tmp_path / "[" / "b]run.wire",
    )
    file.parent.mkdir()
    monkeypatch.setattr("serpenoid.robot.robot.open_link", lambda _: board)
    status, said, errors = serpenoid(f"drive {GAIT} --port any --duration-s 0.3 --record {file}")
    assert (status, "Traceback" in errors) == (0, False), errors
    assert "[/b], firmware" in said


def test_a_board_that_tells_nothing_and_forgets_nobody_is_made_watchable():
    with FakeBoard(eeprom=eeprom_after("set every 0", "set silence off")) as fake:
        assert answer(f"drive {GAIT} --port {fake.port} --duration-s 0.5")["frames"] > 10
    assert b" set silence 2 *" in fake.received


@pytest.mark.parametrize(
    ("args", "status", "said"),
    [
        ("--alpha-deg 90 --beta-deg 80 --omega-rad-s 20", 1, "servo_speed"),
        ("--alpha-deg 300 --beta-deg 80 --omega-rad-s 5", 2, "alpha_deg is 300"),
        ("--alpha-deg 30 --beta-deg 80", 2, "one of --frequency-hz"),
        (f"{GAIT} --duration-s 0", 2, "duration-s"),
        (f"{GAIT} --robot 2005 --record {__file__}", 2, "another name"),
    ],
)
def test_refusals(args, status, said):
    found = serpenoid(f"drive {args} --port virtual:fast")
    assert found[:2] == (status, "")  # without a prediction first
    assert said in found[2]
