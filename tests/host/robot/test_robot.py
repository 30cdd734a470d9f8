"""A whole run on every board: what is commanded is what comes back."""

from __future__ import annotations

import itertools
import math

import pytest
from refusals import refused
from robot.boards import BOARDS
from robot.fake_board import GAIT
from robot.patience import LONG_S
from serpenoid import Gait
from serpenoid.base.errors import CommandRefused
from serpenoid.robot import RobotBoard


def test_a_run_from_opening_to_stop(any_port):
    with RobotBoard(any_port) as robot:
        assert robot.settings()["silence"] == 2.0
        robot.gait(GAIT)
        frames = list(itertools.islice(robot.frames(LONG_S), 25))
        numbers = [f.frame for f in frames]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        assert {f.state for f in frames} == {"gait"}
        with pytest.raises(CommandRefused, match="low=0 high=90") as error:
            robot.gait(Gait(2.0, 0.0, 1.0))
        assert error.value.word == "range"
        robot.stop()
        held = [f for f in itertools.islice(robot.frames(LONG_S), 20) if f.state == "hold"]
        assert len({f.setpoint_rad for f in held}) == 1
        status = robot.status()
        assert (status.state, status.moving) == ("hold", False)
        assert status.damaged == status.dropped == 0
        robot.idle()
        assert robot.losses.damaged_lines == robot.losses.missed_frames == 0


def test_the_gait_that_comes_is_the_one_asked_for(any_port):
    """Eq. 57, from the board's own phase; the lag is beyond half a turn and must come round."""
    gait = Gait(math.radians(25), beta_rad=-4.0, omega_rad_s=6.0, offset_rad=math.radians(-10))
    with RobotBoard(any_port) as robot:
        robot.set("angle_ramp", 360)
        robot.set("pose_speed", 360)
        robot.set("rate_ramp", 100)
        robot.gait(gait)
        settled = list(itertools.islice(robot.frames(LONG_S), 90, 120))
    for frame in settled:
        for joint, angle_rad in enumerate(frame.setpoint_rad):
            swing = math.sin(frame.phase_rad + joint * gait.beta_rad)
            # the board's fixed point and the wire's 0.01 degrees
            assert angle_rad == pytest.approx(
                gait.offset_rad + gait.alpha_rad * swing, abs=math.radians(0.02)
            )
    for before, after in itertools.pairwise(settled):
        turned = (after.phase_rad - before.phase_rad) % (2 * math.pi)
        frames = after.frame - before.frame
        assert turned == pytest.approx(0.02 * 6.0 * frames, abs=math.radians(0.01))


def test_poses_arrive_in_radians(any_port):
    with RobotBoard(any_port) as robot:
        robot.set("pose_speed", 360)
        for move, angles_rad in (
            (lambda: robot.pose([0.1, 0.2, -0.3, 0.0, 1e-9]), [0.1, 0.2, -0.3, 0.0, 0.0]),
            (robot.straight, [0.0] * 5),
        ):
            move()
            there = pytest.approx(angles_rad, abs=math.radians(0.02))
            frames = robot.frames(LONG_S)
            assert any(frame.setpoint_rad == there for frame in frames)
            assert all(frame.setpoint_rad == there for frame in itertools.islice(frames, 10))
        with refused("5 angles"):
            robot.pose([0.0] * 4)
        with refused("finite"):
            robot.pose([math.nan] * 5)


@pytest.mark.parametrize("board", BOARDS[:2])  # what a real one has saved is left alone
def test_settings_and_trims_are_kept_when_saved(board, request):
    if board == "simulated":
        request.getfixturevalue("simulated")
    with RobotBoard("virtual:fast") as robot:
        robot.trim(2, "centre", 1512)
        robot.trim(5, "low", -75.5)
        robot.set("silence", 3.5)
        robot.save()
        robot.command("defaults")
        assert robot.settings()["silence"] == 2.0
        robot.command("load")
        assert robot.settings()["silence"] == 3.5
        trims = robot.trims()
        assert (trims[1].joint, trims[1].centre_us, trims[4].low_deg) == (2, 1512, -75.5)
        for ask in (lambda: robot.set("speed", 1), lambda: robot.trim(6, "centre", 1500)):
            with pytest.raises(CommandRefused) as error:
                ask()
            assert error.value.word == "name"
        with refused("printable ASCII"):
            robot.set("silence 1\n#9 gait", 3)
    if board == "simulated":
        assert request.getfixturevalue("simulated").counts.eeprom_ignored == 0
