"""A robot of six or eight joints: the host follows what the greeting says of it."""

from __future__ import annotations

import math

import pytest
from refusals import refused
from robots import gait_in_deg
from serpenoid.model.bends import balanced_signs, joint_multiples
from serpenoid.robot import Robot
from serpenoid.robot.recording.stream import load_stream
from serpenoid.taking.board_run import board_gait

FRAME_US = {6: 20_000, 8: 22_500}
GAIT = gait_in_deg(30, 40, 5.0)


def test_gait_pose_and_recording_have_so_many_joints(joints, joints_link, tmp_path):
    lam = math.radians(7.5)
    with Robot("any", record=tmp_path / "run.txt") as robot:
        assert (robot.hello.joints, robot.hello.frame_us) == (joints, FRAME_US[joints])
        robot.zigzag(lam)
        *_, frame = robot.frames(2.0 + 0.1 * joints)
        assert frame.setpoint_rad == pytest.approx([2 * lam, -2 * lam] * (joints // 2), abs=2e-4)
        with refused(f"a pose has {joints} angles"):
            robot.pose([0.0] * (joints - 1))
        robot.pose([0.1 * j for j in range(joints)])
        robot.gait(GAIT)
        *_, frame = robot.frames(4.0)
        wave = [
            GAIT.alpha_rad * math.sin(frame.phase_rad + j * GAIT.beta_rad) for j in range(joints)
        ]
        assert frame.setpoint_rad == pytest.approx(wave, abs=3e-4)
        assert not robot.losses.missed_frames
    stream = load_stream(tmp_path / "run.txt")
    assert stream.setpoint_rad.shape == (len(stream.frame), joints)
    period_s = (stream.board_s[-1] - stream.board_s[0]) / (stream.frame[-1] - stream.frame[0])
    assert period_s == pytest.approx(FRAME_US[joints] * 1e-6, rel=1e-4)


def test_the_gait_that_a_board_really_drives(joints, joints_link):
    with Robot("any") as robot:
        gait = board_gait(robot, GAIT)
    assert gait.alpha_rad == pytest.approx(GAIT.alpha_rad, abs=1e-3)
    assert gait.beta_rad == pytest.approx(GAIT.beta_rad, abs=1e-3)


@pytest.mark.parametrize("number", range(3, 13))
def test_any_number_of_joints_takes_the_balanced_bend(number):
    with Robot(f"virtual:fast:joints={number}") as robot:
        assert robot.hello.joints == number
        robot.set("pose_speed", 360)
        robot.bent(0.2, -0.03)
        *_, frame = robot.frames(1.0 + 0.15 * number)
        bent = [0.2 * k - 0.03 for k in joint_multiples(balanced_signs(number + 1))]
        assert frame.setpoint_rad == pytest.approx(bent, abs=2e-4)


def test_three_links_have_no_balanced_bend():
    with Robot("virtual:joints=2:fast") as robot:
        with refused(r"3 links.*guide the robot"):
            robot.bent(0.1)
        robot.zigzag(0.1, 0.02)
        *_, frame = robot.frames(1.5)
        assert frame.setpoint_rad == pytest.approx([0.22, -0.18], abs=2e-4)


@pytest.mark.parametrize("port", ["virtual:joints=13", "virtual:joints=", "virtual:quick"])
def test_no_such_virtual_board(port):
    with refused("2 to 12 joints"), Robot(port):
        pass
