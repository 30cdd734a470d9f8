"""Six and eight joints through the commands: followed, or refused before anything moves."""

from __future__ import annotations

import json
import re

import pytest
from command_line import answer, serpenoid

GAIT = "--alpha-deg 60 --beta-deg 40 --omega-rad-s 3"


def test_drive_and_view_take_the_boards_joints(joints, joints_link, tmp_path):
    run, page = tmp_path / "run.wire", tmp_path / "run.html"
    told = answer(f"drive {GAIT} --port any --duration-s 5 --record {run}")
    assert told["missed_frames"] == 0
    assert told["duration_s"] == pytest.approx(5.0, abs=0.1)
    status, _, errors = serpenoid(f"view {run} --out {page}")
    assert status == 2
    assert f"of a robot of {joints + 1}" in errors
    assert serpenoid(f"view {run} --links {joints + 1} --out {page}")[0] == 0
    data = page.read_text().partition('type="application/json">')[2].partition("</script")[0]
    assert len(json.loads(data)["joint_deg"][0]) == joints


def session_of(tmp_path, links: int) -> str:
    """Begin a session of a robot of so many links; return its folder."""
    folder = tmp_path / f"session-of-{links}"
    serpenoid(f"calibrate new {folder} --surface belt --mass-kg 0.5 --defaults", check=True)
    about = folder / "session.toml"
    changed = re.sub(r"(?m)^links = \d+", f"links = {links}", about.read_text())
    about.write_text(changed)
    return str(folder)


def test_a_session_of_another_robot_is_refused_before_it_moves(joints, joints_link, tmp_path):
    folder = session_of(tmp_path, 6)
    status, _, errors = serpenoid(f"calibrate {folder} --port any")
    assert status == 2
    assert f"the session is of a robot of 6 links, but this board moves {joints + 1}" in errors
    assert "calibrate new" in errors


def test_a_session_of_this_robot_is_taken(joints, joints_link, tmp_path, monkeypatch):
    folder = session_of(tmp_path, joints + 1)
    answers = tmp_path / "answers"
    answers.write_text("0,1\n0.0\n\n\n\n2.0\n0.2\n\n\nkeep\nquit\n")
    with answers.open() as typed:
        monkeypatch.setattr("sys.stdin", typed)
        status, said, errors = serpenoid(f"calibrate {folder} --port any")
    assert status == 0, errors
    assert "kept as reading 2" in said


def test_a_gait_searched_for_another_robot_is_not_sent(joints, joints_link):
    asked = "optimize --robot paper --speed 0.05 --servo ideal --send --port any --duration-s 1"
    status, _, errors = serpenoid(asked)
    assert status == 2
    assert f"the gait is of a robot of 6 links, but this board moves {joints + 1}" in errors
    assert "--links" in errors
    status, said, errors = serpenoid(f"{asked} --links {joints + 1}")
    assert status == 0, errors
    assert "frames" in said
