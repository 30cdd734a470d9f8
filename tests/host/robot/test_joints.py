"""A robot of six or eight joints: the host follows what the greeting says of it."""

from __future__ import annotations

import math

import pytest
from refusals import refused
from robot.fake_board import sealed
from robots import gait_in_deg
from serpenoid.calibration.taking.board_run import board_gait
from serpenoid.model.bends import balanced_signs, joint_multiples
from serpenoid.robot import Robot
from serpenoid.robot.recording.stream import load_stream
from serpenoid.robot.tools.monitor import Monitor
from serpenoid.robot.wire.protocol import line_limit

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


def test_a_person_may_type_lines_as_long_as_the_board_takes(joints, joints_link):
    shown: list[str] = []
    talk = Monitor(joints_link(), shown.append, 1000)
    talk.open()
    angles = " ".join(f"-1{j % 10}.123456" for j in range(joints))
    longest = f"pose {angles}".ljust(line_limit(joints) - len("#1  *1234"), " ") + "0"
    for typed in (f"pose {angles}", longest):
        for key in (*typed, "enter"):
            talk.press(key)
        talk.step()
    talk.leave()
    assert any("ok: #1" in line for line in shown)
    assert any(f"at most {line_limit(joints)}" in line for line in shown)


def test_the_gait_that_a_board_really_drives(joints, joints_link):
    with Robot("any") as robot:
        gait = board_gait(robot, GAIT)
    assert gait.alpha_rad == pytest.approx(GAIT.alpha_rad, abs=1e-3)
    assert gait.beta_rad == pytest.approx(GAIT.beta_rad, abs=1e-3)


@pytest.mark.parametrize("greeted", [True, False])
def test_hours_without_a_line_do_not_confuse_a_recordings_clock(tmp_path, greeted):
    """At 22.5 ms a frame six hours differ by 40 minutes from what 20 ms would make of them."""
    frames = round(6 * 3600 / 0.0225)
    path = tmp_path / "run.txt"
    rows = [b"# serpenoid wire 1, begun 2020-01-01T00:00:00.000+00:00", b"# columns"]
    if greeted:
        rows.append(b"0.0 < " + HELLO.rstrip())
    for number in (0, frames):
        rows.append(f"{number * 0.0225:.6f} < ".encode() + telemetry(number).rstrip())
    path.write_bytes(b"\n".join(rows) + b"\n")
    assert load_stream(path).board_s[-1] == pytest.approx(frames * 0.0225)


HELLO = sealed(
    "hello: serpenoid fw=0.2.0 protocol=4 board=mega joints=8 frame_us=22500 boot=1 reset=power"
    " settings=ok silence=2"
)


def telemetry(frame: int) -> bytes:
    angles = " ".join(f"j{j}:0.00" for j in range(1, 9))
    pulses = ",".join(["1500"] * 8)
    board_us = frame * 22_500 % 2**32
    return sealed(
        f"t:{frame} {angles} board_us={board_us} ph=0.000 p={pulses} exec_us=1 late_us=0 clipped=0"
        " st=hold"
    )


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
