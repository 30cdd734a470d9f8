"""Measurements of rendered films whose motion is known; each film is rendered once."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import serpenoid as sn
from command_line import serpenoid
from robots import NIRAKH_2005
from video.answers import film_answer
from video.filming import Body, Lens
from video.worlds import SIDE_M, crawling, errors, max_sigmas, shoot

DEMO = NIRAKH_2005.with_name("demo-film")
LENS = Lens(k1=0.06, k2=-0.02, middle_px=(5.0, -3.0), rolling_s=0.015)
WORLD = crawling(omega_rad_s=8.0, speed_m_s=0.08, start_m=-0.07)


def slowing_times(seconds: float) -> np.ndarray:
    """Return times of a phone in dim light, s: 30 to 15 frames/s, every interval wrong by 16 %."""
    gaps_s = np.linspace(1 / 30, 1 / 15, 60) * (1 + 0.16 * (-1.0) ** np.arange(60))
    t_s = np.cumsum(gaps_s)
    return t_s[t_s < seconds] - t_s[0]


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    """Measure 2.3 periods: tags mounted askew, lens distortion, rolling shutter, falling rate."""
    rng = np.random.default_rng(5)
    body = Body(
        6,
        mount_m=rng.normal(size=(6, 3)) * [0.002, 0.002, 0.001],
        turn_rad=np.radians(1.5) * rng.normal(size=6),
        slope=0.02 * rng.normal(size=(6, 2)),
    )
    path = tmp_path_factory.mktemp("film") / "plain.mp4"
    return film_answer(shoot(WORLD, path, LENS, body, times_s=slowing_times(1.9), up=2))


def test_errors_of_speed_and_joints_agree_with_small_sigmas(run) -> None:
    found = errors(run, WORLD)
    assert max_sigmas(found) < 5
    speed, rate, turn, *angles = (float(np.abs(error).max()) for error, _ in found.values())
    assert speed < 0.003 * WORLD.speed_m_s
    assert rate < 0.0005 * WORLD.omega_rad_s
    assert math.degrees(turn) < 0.05  # deg/s
    assert np.degrees(angles) == pytest.approx(0, abs=0.2)
    assert run.speed_sigma_m_s < 0.005 * WORLD.speed_m_s
    assert all(joint.amplitude_sigma_rad < math.radians(0.2) for joint in run.joints)


def test_offsets_of_end_joints_depend_on_the_mounting_of_tags(run) -> None:
    ends = (0, len(run.joints) - 1)
    for i, joint in enumerate(run.joints):
        assert abs(joint.offset_rad - WORLD.offset_rad[i]) < 4 * joint.offset_sigma_rad
        outer = joint.offset_sigma_rad > math.radians(1.0)
        assert outer == (i in ends)


def test_the_camera_of_the_renderer_is_found(run) -> None:
    assert run.camera.readout_s == pytest.approx(LENS.rolling_s, abs=0.002)
    assert run.camera.focal_px == pytest.approx(LENS.focal_px, rel=0.03)
    assert run.camera.tag_side_m == pytest.approx(SIDE_M, rel=0.003)


def test_the_film_of_the_demo_gives_the_true_motion(tmp_path) -> None:
    """The firmware moved the robot on the lab's floor, and a rendered camera filmed it."""
    truth = json.loads((DEMO / "truth.json").read_text())
    folder = tmp_path / "session"
    serpenoid(f"calibrate new {folder} --defaults", check=True)
    gait = "--alpha-deg 60 --beta-deg 75 --omega-rad-s 5.235988"
    files = tmp_path / "track.csv", tmp_path / "film.png"
    typed = f"{gait} --track {files[0]} --plot {files[1]} --session {folder}"
    answer = film_answer(DEMO / "film.mp4", typed)
    assert all(file.stat().st_size > 5000 for file in files)
    rows = np.genfromtxt(files[0], delimiter=",", names=True)
    assert len(rows) == answer.film.frames
    assert np.ptp(rows["joint3_rad"]) == pytest.approx(2 * truth["amplitude_rad"][2], rel=0.03)
    assert answer.speed_m_s == pytest.approx(truth["speed_m_s"], rel=0.005)
    assert abs(answer.speed_m_s - truth["speed_m_s"]) < 4 * answer.speed_sigma_m_s
    assert answer.turn_rad_s == pytest.approx(truth["turn_rad_s"], abs=math.radians(0.1))
    for name in ("amplitude_rad", "phase_rad"):
        found = np.array([getattr(joint, name) for joint in answer.joints])
        error = np.angle(np.exp(1j * (found - truth[name])))
        assert np.degrees(error) == pytest.approx(0, abs=0.25)
    (reading,) = sn.load_session(folder).kept_films
    gain = np.array(truth["amplitude_rad"]) / truth["alpha_rad"]
    assert reading.gait.joint_gain == pytest.approx(gain, abs=0.006)
    assert reading.track.columns[-1] == "joint5_rad"


def test_a_recording_gives_the_gait_and_the_time_scale_of_the_film(tmp_path) -> None:
    record = tmp_path / "run.wire"
    gait = "--alpha-deg 60 --beta-deg 75 --omega-rad-s 5.1 --duration-s 4"
    serpenoid(f"drive --port virtual:fast {gait} --record {record}", check=True)
    run = film_answer(DEMO / "film.mp4", f"--recording {record}")
    assert run.omega_rad_s == pytest.approx(5.1, rel=1e-3)
    assert run.time_scale == pytest.approx(5.235988 / 5.1, rel=1e-3)
    assert run.path_m == pytest.approx(0.1026 * 2.2 * 1.2, rel=0.02)
    with pytest.raises(sn.BadInput, match="has 5 joints; the robot has 3"):
        film_answer(DEMO / "film.mp4", f"--recording {record} --set links=4")
