"""A whole run on every board: what is commanded is what comes back."""

from __future__ import annotations

import math

import pytest
from serpenoid import Gait
from serpenoid.errors import CommandRefused, RobotClosed
from serpenoid.robot import Robot

GAIT = Gait(alpha_rad=math.radians(30), beta_rad=math.radians(80), omega_rad_s=5.0)


def test_a_run_from_opening_to_stop(any_port):
    with Robot(any_port) as robot:
        assert robot.hello.protocol == 1
        assert robot.settings()["silence"] == 2.0
        robot.gait(GAIT)
        frames = list(robot.frames(1.0))
        assert 25 <= len(frames) <= 75  # a loaded machine lets a simulated board lag and catch up
        numbers = [f.frame for f in frames]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        assert {f.state for f in frames} == {"gait"}
        with pytest.raises(CommandRefused, match="low=0 high=90") as refused:
            robot.gait(Gait(2.0, 0.0, 1.0))
        assert refused.value.word == "range"
        robot.stop()
        held = [f for f in robot.frames(0.3) if f.state == "hold"]
        assert len({f.setpoint_rad for f in held}) == 1
        status = robot.status()
        assert (status.state, status.moving, status.crc, status.dropped) == ("hold", False, 0, 0)
        robot.idle()
        assert robot.losses.damaged_lines == robot.losses.missed_frames == 0
    with pytest.raises(RobotClosed):
        robot.straight()
