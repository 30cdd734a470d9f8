"""A robot of any number of joints: followed by host and commands, or refused before it moves."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from command_line import answer, serpenoid
from refusals import refused
from robots import gait_in_deg
from serpenoid.robot import RobotBoard
from serpenoid.robot.recording.stream import load_stream

FRAME_US = {6: 20_000, 8: 22_500}
GAIT = gait_in_deg(30, 40, 5.0)
GAIT_TYPED = "--alpha-deg 60 --beta-deg 40 --omega-rad-s 3"


@pytest.mark.parametrize("joints", FRAME_US)
def test_gait_pose_and_recording_have_so_many_joints(joints, tmp_path):
    lam = math.radians(7.5)
    with RobotBoard(f"virtual:fast:joints={joints}", record=tmp_path / "run.txt") as robot:
        assert (robot.hello.joints, robot.hello.frame_us) == (joints, FRAME_US[joints])
        robot.pose([2 * lam, -2 * lam] * (joints // 2))
        *_, frame = robot.frames(2.0 + 0.1 * joints)
        assert frame.setpoint_rad == pytest.approx([2 * lam, -2 * lam] * (joints // 2), abs=2e-4)
        with refused(f"a pose has {joints} angles"):
            robot.pose([0.0] * (joints - 1))
        robot.gait(GAIT)
        *_, frame = robot.frames(6.0)
        phases_rad = frame.phase_rad + GAIT.beta_rad * np.arange(joints)
        assert frame.setpoint_rad == pytest.approx(GAIT.alpha_rad * np.sin(phases_rad), abs=2e-3)
        assert not robot.losses.missed_frames
    stream = load_stream(tmp_path / "run.txt")
    assert stream.setpoint_rad.shape == (len(stream.frame), joints)
    period_s = np.ptp(stream.board_s) / np.ptp(stream.frame)
    assert period_s == pytest.approx(FRAME_US[joints] * 1e-6, rel=1e-4)


def test_other_numbers_of_joints_have_no_board():
    for port in ("virtual:joints=13", "virtual:joints=", "virtual:quick"):
        with refused("2 to 12 joints"), RobotBoard(port):
            pass


def test_drive_and_view_take_the_boards_joints(tmp_path):
    run, page = tmp_path / "run.wire", tmp_path / "run.html"
    port = "virtual:fast:joints=8"
    told = answer(f"drive {GAIT_TYPED} --port {port} --duration-s 5 --record {run}")
    assert told["missed_frames"] == 0
    status, _, errors = serpenoid(f"view {run} --out {page}")
    assert (status, "of a robot of 9" in errors) == (2, True)
    serpenoid(f"view {run} --set links=9 --out {page}", check=True)
    data = page.read_text().partition('type="application/json">')[2].partition("</script")[0]
    assert len(json.loads(data)["joint_deg"][0]) == 8
