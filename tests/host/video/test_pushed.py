"""Pushes along a floor, filmed: one film through the real command gives a reading each."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from command_line import serpenoid
from robots import NIRAKH_2005
from serpenoid import Ground, Robot, load_session
from serpenoid.lab.floor import Floor, Push
from serpenoid.lab.robot import LabRobot
from video.filming import Body, Film, Lens, Pose, write
from video.worlds import LINK_M

STRAIGHT = (0.0,) * 5
RATE_HZ, REST_S = 15.0, 0.9
JOINT_RAD = np.radians([0.4, -0.3, 0.5, -0.6, 0.2])
BODY = Body(6, side_m=0.034, mount_m=np.random.default_rng(3).normal(size=(6, 3)) * 1e-3)
LENS = Lens((0.05, -0.5, 1.1), (0.05, 0.0, 0.045), 1100, 240, 820, k1=0.03)


def lab_pushes(speeds_m_s) -> tuple[Pose, float]:
    """Return a pose over pushes there and back with rests between, and the end, s."""
    robot = LabRobot.whole_body(Robot(6, 0.0756, LINK_M), Ground(0.084, 1.2, 0.14, 0.27))
    rows, at_m, begins = [], -0.35, 0.3
    for k, speed in enumerate(speeds_m_s):
        direction = math.pi * (k % 2)
        track = Floor(robot).push(STRAIGHT, Push(speed, direction))
        x = at_m + track.x_m - track.x_m[0]
        heading = track.heading_rad - track.heading_rad[0] + direction
        rows.append(np.column_stack([begins + track.t_s, x, track.y_m, heading]))
        rests = [REST_S - 0.3, 0, 0, 0]  # then it is turned round
        rows.append(np.add(rows[-1][-1:], rests))
        at_m, begins = x[-1], begins + track.t_s[-1] + REST_S
    whole = np.concatenate(rows)

    def pose(t: float) -> tuple[np.ndarray, np.ndarray]:
        x, y = (np.interp(t, whole[:, 0], whole[:, c]) for c in (1, 2))
        next_ = min(int(np.searchsorted(whole[:, 0], t)), len(whole) - 1)
        theta = np.concatenate([[0.0], np.cumsum(JOINT_RAD)])
        theta += whole[next_, 3] - theta.mean()
        half = LINK_M / 2 * np.exp(1j * theta)
        centre = np.concatenate([[0.0], np.cumsum(half[:-1] + half[1:])])
        centre += x + 1j * y - centre.mean()
        return np.column_stack([centre.real, centre.imag]), theta

    return pose, float(whole[-1, 0]) + REST_S


def test_a_film_of_two_pushes_gives_two_readings(tmp_path) -> None:
    pose, seconds = lab_pushes((0.75, 0.7))
    camera = Film(LENS, BODY, pose, up=2)
    times = np.arange(0, seconds, 1 / RATE_HZ)
    film = write(tmp_path / "pushes.mp4", [camera.frame(t) for t in times], times)
    folder = tmp_path / "session"
    serpenoid(f"calibrate new {folder} --defaults --on floor", check=True)
    typed = f"calibrate push {folder} {film}"
    serpenoid(typed, check=True)
    session = load_session(folder)
    pushes = session.kept_pushes
    (scale_sigma,) = {p.scale_sigma for p in pushes}
    assert 0.006 < scale_sigma < 0.0101  # joints that hold still: as the tags' print, or better
    assert [p.way for p in pushes] == ["there", "back"]
    for push in pushes:
        assert push.track is not None
        t = push.track.values[:, 0]
        t, x, y = push.track.values[(t >= push.start_s) & (t <= push.end_s)].T
        seen = np.hypot(x - x[0], y - y[0])
        true = np.abs([pose(at)[0][:, 0].mean() for at in t] - pose(t[0])[0][:, 0].mean())
        scale = (seen @ true) / (seen @ seen)
        assert scale == pytest.approx(1.0, abs=0.01)
        assert np.abs(scale * seen - true).max() < 1e-3
    assert "is of this file already" in serpenoid(typed).stderr


def test_a_crawl_is_no_push(tmp_path) -> None:
    folder, film = tmp_path / "session", NIRAKH_2005.with_name("demo-film") / "film.mp4"
    serpenoid(f"calibrate new {folder} --defaults --on floor", check=True)
    told = serpenoid(f"calibrate push {folder} {film}")
    words = " ".join((told.stdout + told.stderr).split())
    assert re.search("joint . moves by .* a crawl is measured by", words)
