"""From pixels to numbers: films of known worlds, measured; each rendered once for all tests."""

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
from video.worlds import SIDE_M, crawling, errors, most_sigmas, shoot

DEMO = NIRAKH_2005.with_name("demo-film")
LENS = Lens(k1=0.06, k2=-0.02, middle_px=(5.0, -3.0), rolling_s=0.015)
WORLD = crawling(omega_rad_s=8.0, speed_m_s=0.08, start_m=-0.07)


def slowing(seconds: float) -> np.ndarray:
    """Return the moments of a phone in dim light: from 30 to 15 frames/s, each off by a sixth."""
    gaps = np.linspace(1 / 30, 1 / 15, 60) * (1 + 0.16 * (-1.0) ** np.arange(60))
    t_s = np.cumsum(gaps)
    return t_s[t_s < seconds] - t_s[0]


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    """A film of 2.3 periods: tags mounted askew, a real lens, slow rows, a rate that falls."""
    rng = np.random.default_rng(5)
    body = Body(
        6,
        mount_m=rng.normal(size=(6, 3)) * [0.002, 0.002, 0.001],
        turn_rad=np.radians(1.5) * rng.normal(size=6),
        slope=0.02 * rng.normal(size=(6, 2)),
    )
    path = tmp_path_factory.mktemp("film") / "plain.mp4"
    return film_answer(shoot(WORLD, path, LENS, body, times_s=slowing(1.9), up=2))


def test_speed_and_joints_are_found_within_sigmas_that_are_not_vain(run) -> None:
    off = errors(run, WORLD)
    assert most_sigmas(off) < 5
    speed, rate, *others = (float(np.abs(error).max()) for error, _ in off.values())
    assert speed < 0.003 * WORLD.speed_m_s
    assert rate < 0.0005 * WORLD.omega_rad_s
    assert np.degrees(others) == pytest.approx(0, abs=0.2)
    assert math.degrees(others[0]) < 0.05  # a second, of the turn
    assert run.speed_sigma_m_s < 0.005 * WORLD.speed_m_s
    assert all(joint.amplitude_sigma_rad < math.radians(0.2) for joint in run.joints)


def test_centres_inside_are_known_well_and_those_of_the_ends_as_well_as_tags_lie(run) -> None:
    ends = (0, len(run.joints) - 1)
    for i, joint in enumerate(run.joints):
        assert abs(joint.offset_rad - WORLD.offset_rad[i]) < 4 * joint.offset_sigma_rad
        outer = joint.offset_sigma_rad > math.radians(1.0)
        assert outer == (i in ends)


def test_the_camera_is_that_of_the_renderer(run) -> None:
    assert run.camera.readout_s == pytest.approx(LENS.rolling_s, abs=0.002)
    assert run.camera.focal_px == pytest.approx(LENS.focal_px, rel=0.03)
    assert run.camera.tag_side_m == pytest.approx(SIDE_M, rel=0.003)


def test_the_demos_film_is_a_reading_that_says_what_the_lab_knows(tmp_path) -> None:
    """The firmware moved the robot, the lab's floor carried it, and a lens saw it."""
    truth = json.loads((DEMO / "truth.json").read_text())
    folder = tmp_path / "session"
    serpenoid(f"calibrate new {folder} --defaults", check=True)
    gait = "--alpha-deg 60 --beta-deg 75 --omega-rad-s 5.235988"
    files = tmp_path / "track.csv", tmp_path / "film.png"
    typed = f"{gait} --track {files[0]} --plot {files[1]} --session {folder}"
    told = film_answer(DEMO / "film.mp4", typed)
    assert all(file.stat().st_size > 5000 for file in files)
    rows = np.genfromtxt(files[0], delimiter=",", names=True)
    assert len(rows) == told.film.frames
    assert np.ptp(rows["joint3_rad"]) == pytest.approx(2 * truth["amplitude_rad"][2], rel=0.03)
    assert told.speed_m_s == pytest.approx(truth["speed_m_s"], rel=0.005)
    assert abs(told.speed_m_s - truth["speed_m_s"]) < 4 * told.speed_sigma_m_s
    assert told.turn_rad_s == pytest.approx(truth["turn_rad_s"], abs=math.radians(0.1))
    for name in ("amplitude_rad", "phase_rad"):
        found = np.array([getattr(joint, name) for joint in told.joints])
        off = np.angle(np.exp(1j * (found - truth[name])))
        assert np.degrees(off) == pytest.approx(0, abs=0.25)
    (reading,) = sn.load_session(folder).kept_films
    made = np.array(truth["amplitude_rad"]) / truth["alpha_rad"]
    assert reading.gait.joint_gain == pytest.approx(made, abs=0.006)
    assert reading.track.columns[-1] == "joint5_rad"


def test_a_recording_gives_the_gait_and_ties_the_film_to_the_boards_time(tmp_path) -> None:
    record = tmp_path / "run.wire"
    gait = "--alpha-deg 60 --beta-deg 75 --omega-rad-s 5.1 --duration-s 4"
    serpenoid(f"drive --port virtual:fast {gait} --record {record}", check=True)
    run = film_answer(DEMO / "film.mp4", f"--recording {record}")
    assert run.omega_rad_s == pytest.approx(5.1, rel=1e-3)
    assert run.time_scale == pytest.approx(5.235988 / 5.1, rel=1e-3)
    assert run.path_m == pytest.approx(0.1026 * 2.2 * 1.2, rel=0.02)
    with pytest.raises(sn.BadInput, match="has 5 joints; the robot has 3"):
        film_answer(DEMO / "film.mp4", f"--recording {record} --set links=4")
