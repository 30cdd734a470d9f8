"""Films in a session: stored with joints and track, not used by the fit, used by `compare`."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import pytest
import serpenoid as sn
from command_line import serpenoid
from refusals import refused
from robots import NIRAKH_2005

FILM = NIRAKH_2005.with_name("demo-film") / "film.mp4"
GAIT = "alpha_deg=60 beta_deg=75 omega_rad_s=5.235988"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return the session of 2005 with the film of the demo as reading 12."""
    folder = tmp_path_factory.mktemp("film") / "session"
    shutil.copytree(NIRAKH_2005, folder)
    gait = "--alpha-deg 60 --beta-deg 75 --omega-rad-s 5.235988"
    result = serpenoid(f"video {FILM} {gait} --session {folder}", check=True)
    assert "reading 12" in result.stderr
    assert "is of this film already" in serpenoid(f"video {FILM} {gait} --session {folder}").stderr
    return folder


@pytest.fixture
def copy(folder, tmp_path) -> Path:
    return Path(shutil.copytree(folder, tmp_path / "copy"))


def test_a_film_is_stored_with_its_joints_and_its_track(folder) -> None:
    (film,) = sn.load_session(folder).kept_films
    assert film.commanded == sn.Gait(math.radians(60), math.radians(75), film.omega_rad_s)
    assert film.track.columns[3:5] == ("heading_rad", "joint1_rad")
    assert len(film.track.values) == 80
    assert len(film.film_sha256) == 64


def test_a_filmed_gait_is_predicted_with_the_filmed_joints(folder) -> None:
    session = sn.load_session(folder)
    fit = sn.fit_friction(session)
    found = sn.compare(session, fit, samples=16, servo=None)
    (film,), (gait,) = session.kept_films, found.gaits
    assert "Joints in film 12 reach 92.9% ± 0.1% of the commanded amplitude" in found.verdict_text
    filmed = sn.steady_gait(fit.robot, fit.ground, film.gait)
    assert gait.exact_m_s == pytest.approx(filmed.speed_m_s, rel=1e-5)
    assert gait.low_m_s == pytest.approx(gait.low_friction_m_s)  # the amplitude is known


def test_films_and_timed_runs_of_one_command_are_one_gait(copy) -> None:
    """The table lists the gait once, with the mean speed that the verdict uses."""
    serpenoid(f"calibrate add {copy} gait {GAIT} distance_m=2 duration_s=19.5", check=True)
    found = sn.compare(sn.load_session(copy), samples=16, servo=None)
    (row,) = found.gaits
    assert sorted(row.runs) == [12, 13]
    assert row.measured_m_s == pytest.approx(2 / 19.5, rel=0.01)


def test_the_fit_does_not_use_films_and_a_film_can_be_voided(copy) -> None:
    frictions = sn.fit_friction(sn.load_session(copy)).whole_snake
    assert frictions == sn.fit_friction(sn.load_session(NIRAKH_2005)).whole_snake
    serpenoid(f"calibrate void {copy} 12", check=True)
    assert sn.load_session(copy).kept_films == ()


@pytest.mark.parametrize(
    ("original", "changed", "message"),
    [
        ("gains=0.", "gains=x", "gains"),
        ("gains=0.93284,", "gains=", "gains"),
        (",0.1026", ",-0.1026", "speed_m_s"),
        ("track=tracks/0012.csv", "track=tracks/0013.csv", "0013.csv"),
    ],
)
def test_an_invalid_film_is_refused(copy, original, changed, message) -> None:
    path = copy / "readings.csv"
    text = path.read_text()
    assert original in text
    path.write_text(text.replace(original, changed))
    with refused(message):
        sn.load_session(copy)


def test_a_track_that_was_changed_is_refused(copy) -> None:
    track = copy / "tracks" / "0012.csv"
    track.write_text(track.read_text().replace("0", "1", 1))
    with refused("0012.csv"):
        sn.load_session(copy)


def test_a_film_without_its_track_is_refused_and_not_stored(copy) -> None:
    before = (copy / "readings.csv").read_bytes()
    result = serpenoid(f"calibrate add {copy} video {GAIT} speed_m_s=0.1 speed_sigma_m_s=0.001")
    assert result.returncode == 2
    assert (copy / "readings.csv").read_bytes() == before


def test_a_direction_needs_a_session() -> None:
    result = serpenoid("video a.mp4 --way there")
    assert result.returncode == 2
    assert "give --session" in result.stderr
