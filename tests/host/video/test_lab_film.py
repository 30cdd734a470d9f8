"""One world from firmware to pixels: a lab robot, filmed, measured beside the lab's own truth."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from command_line import serpenoid
from robots import OF_2005, gait_in_deg
from serpenoid import Ground
from serpenoid.lab.robot import LabRobot
from serpenoid.session.folder import read_session
from serpenoid.taking.new_session import create_session, default_setup, on_place
from video.filming import Lens
from video.lab_world import Servos, crawled, set_points
from video.worlds import errors, shoot

SETUP = default_setup("filmed")
ON_FLOOR = on_place(SETUP.plan, "floor")
GAIT = gait_in_deg(60, 75, math.tau / 1.2)
FRICTION = Ground(0.084, 1.2, 0.14, 0.27)
ROBOT = LabRobot.whole(OF_2005, FRICTION).drawn(np.random.default_rng(3), math.radians(1.5), 0.1)
LAG_S = np.array([0.02, 0.03, 0.025, 0.02, 0.03])
GAIN = np.array([0.95, 0.93, 0.96, 0.94, 0.92])
LENS = Lens((0.38, -0.35, 0.75), (0.315, 0, 0.045), 720, 400, 700, k1=0.05, rolling_s=0.015)


@pytest.fixture
def filmed(tmp_path):
    """Run the firmware, film the robot, and measure the film with the recording, in a session."""

    def measure(servos: Servos):
        wire, film = tmp_path / "run.wire", tmp_path / "film.mp4"
        world = crawled(ROBOT, servos, GAIT, set_points(GAIT, 8.0, wire))
        shoot(world, film, LENS, seconds=2.2 * GAIT.period_s, rate_hz=20, up=2)
        folder = create_session(tmp_path / "session", replace(SETUP, plan=ON_FLOOR))
        typed = f"video {film} --recording {wire} --session {folder} --way back --json"
        done = serpenoid(typed, check=True)
        return json.loads(done.stdout, object_hook=lambda d: SimpleNamespace(**d)), world, folder

    return measure


@pytest.mark.slow
def test_a_film_of_the_labs_robot_says_what_the_lab_knows(filmed) -> None:
    run, world, folder = filmed(Servos(LAG_S, GAIN))
    off = errors(run, world)
    assert run.speed_m_s == pytest.approx(world.speed_m_s, rel=0.005)
    assert abs(off["speed"][1]) < 4
    assert np.degrees([*off["amplitude"][0], *off["phase"][0]]) == pytest.approx(0, abs=0.25)
    centres = np.array([(j.offset_rad, j.offset_sigma_rad) for j in run.joints]).T
    assert (np.abs(centres[0] - world.offset_rad) < 4 * centres[1]).all()
    assert math.degrees(off["turn"][0]) == pytest.approx(0, abs=0.1)
    (reading,) = read_session(folder).of("video")
    made = world.amplitude_rad / GAIT.alpha_rad
    assert reading.gait.joint_gain == pytest.approx(made, abs=0.006)
    assert reading.track.columns[-1] == "joint5_rad"
    assert reading.gait_run.way == "back"
    assert reading.commanded.alpha_rad == pytest.approx(GAIT.alpha_rad, abs=math.radians(0.1))
