"""From pixels to numbers: films of known worlds, measured; each rendered once for all tests."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from command_line import serpenoid
from robots import NIRAKH_2005, gait_in_deg
from serpenoid.session.folder import read_session
from serpenoid.taking.new_session import create_session, default_setup
from serpenoid.video.fitting.start import first_cameras
from serpenoid.video.instrument import follow, measure
from serpenoid.video.measure_film import measure_film
from serpenoid.video.seeing.film import Film as File
from video.filming import Body, Lens, write
from video.sighted import sighted
from video.worlds import LINK_M, SIDE_M, crawling, errors, most_sigmas, shoot

DEMO = NIRAKH_2005.with_name("demo-film")


@pytest.fixture(scope="session")
def plain(tmp_path_factory):
    """A film of 2.3 periods whose truth is known: tags mounted askew, a real lens, slow rows."""
    rng = np.random.default_rng(5)
    world = crawling(omega_rad_s=8.0, speed_m_s=0.08, start_m=-0.07)
    body = Body(
        6,
        mount_m=rng.normal(size=(6, 3)) * [0.002, 0.002, 0.001],
        turn_rad=np.radians(1.5) * rng.normal(size=6),
        slope=0.02 * rng.normal(size=(6, 2)),
    )
    lens = Lens(k1=0.06, k2=-0.02, middle_px=(5.0, -3.0), rolling_s=0.015)
    path = tmp_path_factory.mktemp("film") / "plain.mp4"
    return shoot(world, path, lens, body, seconds=1.8, up=2), world, body, lens


@pytest.fixture(scope="session")
def measured(plain):
    path, world, *_ = plain
    return measure_film(path, 6, LINK_M), world


def test_speed_and_joints_are_found_within_sigmas_that_are_not_vain(measured) -> None:
    found, world = measured
    off = errors(found.run, world)
    assert most_sigmas(off) < 5
    speed, rate, *others = (float(np.abs(error).max()) for error, _ in off.values())
    assert speed < 0.003 * world.speed_m_s
    assert rate < 0.0005 * world.omega_rad_s
    assert np.degrees(others) == pytest.approx(0, abs=0.2)
    assert math.degrees(others[0]) < 0.05  # a second, of the turn
    assert found.run.speed_sigma_m_s < 0.005 * world.speed_m_s
    assert all(joint.amplitude_sigma_rad < math.radians(0.2) for joint in found.run.joints)


def test_centres_inside_are_known_well_and_those_of_the_ends_as_well_as_tags_lie(measured) -> None:
    found, world = measured
    ends = (0, len(found.run.joints) - 1)
    for i, joint in enumerate(found.run.joints):
        assert abs(joint.offset_rad - world.offset_rad[i]) < 4 * joint.offset_sigma_rad
        outer = joint.offset_sigma_rad > math.radians(1.0)
        assert outer == (i in ends)


def test_camera_and_mountings_are_those_of_the_renderer(measured, plain) -> None:
    _, _, body, lens = plain
    camera = measured[0].measured.bundle.camera
    assert measured[0].run.camera["readout_s"] == pytest.approx(lens.rolling_s, abs=0.002)
    assert measured[0].run.camera["focal_px"] == pytest.approx(lens.focal_px, rel=0.03)
    assert camera.side_m == pytest.approx(SIDE_M, rel=0.003)
    inner = slice(1, -1)
    assert camera.mounting[inner, :2] == pytest.approx(body.mount_m[inner, :2], abs=4e-4)
    assert camera.mounting[inner, 2] == pytest.approx(body.turn_rad[inner], abs=math.radians(0.3))


def slowing(seconds: float) -> np.ndarray:
    """Return the moments of a phone in dim light: from 30 to 15 frames/s, each off by a sixth."""
    gaps = np.linspace(1 / 30, 1 / 15, 60) * (1 + 0.16 * (-1.0) ** np.arange(60))
    t_s = np.cumsum(gaps)
    return t_s[t_s < seconds] - t_s[0]


def test_a_rate_that_varies_is_measured_by_the_files_own_times(tmp_path) -> None:
    """The file's times come through to a tick, and with them the numbers stay what they are."""
    t_s = slowing(2.0)
    blank = [np.full((64, 96), 10 + 3 * k, np.uint8) for k in range(len(t_s))]
    film = File.open(write(tmp_path / "film.mp4", blank, t_s))
    told_s = np.array([time_s for time_s, _ in film.frames()])
    assert told_s == pytest.approx(t_s, abs=2e-5)
    world = crawling(omega_rad_s=8.0, speed_m_s=0.08, start_m=-0.07)
    s = sighted(world, t_s, Lens(), told_s)
    m = measure(*follow(s, SIDE_M, first_cameras(s, LINK_M, SIDE_M))).fitted.motion
    assert m.speed_m_s == pytest.approx(world.speed_m_s, rel=0.003)  # 36 % off at 30 frames/s
    assert m.omega_rad_s == pytest.approx(world.omega_rad_s, rel=5e-4)
    assert m.amplitude_rad == pytest.approx(world.amplitude_rad, abs=math.radians(0.2))


def test_a_long_film_is_measured_as_a_short_one() -> None:
    seconds = 21
    world = crawling(omega_rad_s=4.0, speed_m_s=0.2 / seconds, start_m=-0.1)
    s = sighted(world, np.arange(0, seconds, 1 / 30), Lens())
    found = measure(*follow(s, SIDE_M, first_cameras(s, LINK_M, SIDE_M)))
    m = found.fitted.motion
    assert m.omega_rad_s == pytest.approx(world.omega_rad_s, abs=5 * found.sigmas[0])
    assert found.sigmas[0] < 1e-3 * world.omega_rad_s / seconds
    assert m.amplitude_rad == pytest.approx(world.amplitude_rad, abs=math.radians(0.1))
    assert m.speed_m_s == pytest.approx(world.speed_m_s, rel=0.003)
    assert found.sigmas[1 : world.links].max() < math.radians(0.1)


def test_the_demos_film_is_a_reading_that_says_what_the_lab_knows(tmp_path) -> None:
    """The firmware moved the robot, the lab's floor carried it, and a lens saw it."""
    truth = json.loads((DEMO / "truth.json").read_text())
    folder = create_session(tmp_path / "session", default_setup("filmed"))
    gait = "--alpha-deg 60 --beta-deg 75 --omega-rad-s 5.235988"
    files = tmp_path / "track.csv", tmp_path / "film.png"
    typed = f"video {DEMO / 'film.mp4'} {gait} --track {files[0]} --plot {files[1]}"
    done = serpenoid(f"{typed} --session {folder} --json", check=True)
    assert all(file.stat().st_size > 5000 for file in files)
    told = json.loads(done.stdout)
    rows = np.genfromtxt(files[0], delimiter=",", names=True)
    assert len(rows) == told["film"]["frames"]
    assert np.ptp(rows["joint3_rad"]) == pytest.approx(2 * truth["amplitude_rad"][2], rel=0.03)
    assert told["speed_m_s"] == pytest.approx(truth["speed_m_s"], rel=0.005)
    assert abs(told["speed_m_s"] - truth["speed_m_s"]) < 4 * told["speed_sigma_m_s"]
    assert told["turn_rad_s"] == pytest.approx(truth["turn_rad_s"], abs=math.radians(0.1))
    for name in ("amplitude_rad", "phase_rad"):
        found = np.array([joint[name] for joint in told["joints"]])
        off = np.angle(np.exp(1j * (found - truth[name])))
        assert np.degrees(off) == pytest.approx(0, abs=0.25)
    (reading,) = read_session(folder).of("video")
    made = np.array(truth["amplitude_rad"]) / truth["alpha_rad"]
    assert reading.gait.joint_gain == pytest.approx(made, abs=0.006)
    assert reading.track.columns[-1] == "joint5_rad"


def test_a_recording_ties_the_film_to_the_boards_time() -> None:
    board = gait_in_deg(60, 75, 5.1)
    film = DEMO / "film.mp4"
    run = measure_film(film, 6, LINK_M, gait=board, board_rate=True).run
    assert run.omega_rad_s == pytest.approx(board.omega_rad_s, rel=1e-6)
    assert run.time_scale == pytest.approx(5.235988 / 5.1, rel=1e-3)
    assert run.path_m == pytest.approx(0.1026 * 2.2 * 1.2, rel=0.02)
