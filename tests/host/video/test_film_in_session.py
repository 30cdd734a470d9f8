"""A film in a session: kept whole, out of the fit, and in the comparison with its joints."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from command_line import serpenoid
from robots import NIRAKH_2005
from serpenoid import compare, fit_friction, load_session
from serpenoid.prediction.speeds import speed
from serpenoid.session.folder import read_session
from serpenoid.session.gait_run import FilmReading, GaitRun
from serpenoid.session.journal import Journal
from serpenoid.taking.new_session import create_session, default_setup

CELLS = {
    "alpha_deg": 50.0,
    "beta_deg": 80.0,
    "omega_rad_s": 3.0,
    "offset_deg": 0.2,
    "speed_m_s": 0.05,
    "speed_sigma_m_s": 2e-5,
    "gain_sigma": 0.001,
    "gains": "0.93,0.94,0.92,0.93,0.93",
    "shifts_deg": "0,1,-1,0.5,-0.5",
    "film_sha256": "ab" * 32,
}
PATH = [
    [0.0, 0, 0, 0, 0.1, 0.2],
    [0.1, 0.005, 0, 0.01, math.nan, 0.3],
    [0.2, 0.01, 0, 0.02, 0.2, 0.3],
]


@pytest.fixture
def folder(tmp_path):
    made = create_session(tmp_path / "session", default_setup("made up"))
    with Journal(made) as journal:
        assert journal.add("video", CELLS, comment="a.mp4", samples=PATH) == 1
    return made


def test_a_film_is_kept_with_its_joints_hash_and_track(folder) -> None:
    (film,) = read_session(folder).of("video")
    assert film.gait.joint_gain == (0.93, 0.94, 0.92, 0.93, 0.93)
    assert film.gait.joint_shift_rad[1] == pytest.approx(math.radians(1))
    assert film.commanded.joint_gain == ()
    assert film.mean_gain == pytest.approx(0.93)
    assert film.film_sha256 == "ab" * 32
    assert film.track.values == pytest.approx(np.array(PATH), nan_ok=True)
    assert film.track.columns[3:] == ("heading_rad", "joint1_rad", "joint2_rad")


def test_a_film_without_its_track_is_refused_before_a_line_is_written(folder) -> None:
    typed = [f"{name}={value}" for name, value in CELLS.items()]
    done = serpenoid(f"calibrate add {folder} video", *typed)
    assert done.returncode == 2
    assert "needs its track" in done.stderr
    assert len(read_session(folder).of("video")) == 1


def test_a_way_is_refused_where_there_is_no_line_of_pushes(folder) -> None:
    for more, words in (
        ([], "give a --session that has some"),
        (["--session", folder], "leave --way out"),
    ):
        done = serpenoid("video a.mp4 --way there", *more)
        assert done.returncode == 2
        assert words in done.stderr


@pytest.mark.parametrize(
    ("change", "rows"),
    [
        ({"gains": "0.9,x"}, PATH),
        ({"gains": "1,1"}, PATH),
        ({"speed_m_s": -1.0}, PATH),
        ({}, [[math.nan, 0, 0, 0, 1]] * 2),
        ({}, [[0, 0, 0, 0, math.inf]] * 2),
        ({}, [[0, 0, 0]] * 2),
    ],
)
def test_what_is_no_film_is_refused(folder, change, rows) -> None:
    with Journal(folder) as journal, pytest.raises(sn.BadInput):
        journal.add("video", CELLS | change, samples=rows)


def filmed(gain: float, speed_m_s: float) -> FilmReading:
    angles, gains = (math.radians(50), math.radians(80)), ",".join([str(gain)] * 5)
    joints = {"gain_sigma": 0.001, "gains": gains, "shifts_deg": "0,0,0,0,0"}
    return FilmReading(99, *angles, 3.0, speed_m_s, 1e-5, **joints, film_sha256="cd" * 32)


@pytest.fixture(scope="module")
def of_2005():
    session = load_session(NIRAKH_2005)
    return session, fit_friction(session)


def test_a_filmed_gait_is_predicted_with_its_joints_as_filmed(of_2005) -> None:
    (session, fit), gain = of_2005, 0.8
    made = speed(fit.robot, fit.ground, filmed(gain, 0.1).gait)
    with_film = session.with_reading(filmed(gain, made))
    found = compare(with_film, fit, samples=16, servo=None)
    assert found.verdict == "agrees"
    shown = f"Film 99 shows joints at {100 * gain:.1f} ± 0.1 % of the commanded amplitude"
    assert shown in found.verdict_text
    assert found.gaits[0].residual_m_s == pytest.approx(0.0, abs=1e-4)
    assert found.gaits[0].low_all_m_s == pytest.approx(found.gaits[0].low_m_s)


def test_films_and_timed_runs_of_one_command_are_one_gait(of_2005) -> None:
    """The table has the gait once, with the mean speed that the verdict has, too."""
    session, fit = of_2005
    made = speed(fit.robot, fit.ground, filmed(0.9, 0.1).gait)
    films = [
        replace(filmed(0.88, 1.01 * made), number=7, omega_rad_s=3.005),
        replace(filmed(0.92, 0.99 * made), number=8),
    ]
    commanded = films[1].commanded
    timed = GaitRun(9, commanded.alpha_rad, commanded.beta_rad, 3.0, made, 1e-5)
    both = session.with_reading(timed)
    for film in films:
        both = both.with_reading(film)
    found = compare(both, fit, samples=16, servo=None, gaits=[commanded])
    (row,) = found.gaits
    assert sorted(row.runs) == [7, 8, 9]
    assert row.exact_m_s == pytest.approx(made, rel=0.01)  # with the mean of the filmed joints
    assert "Films 7 and 8 show joints at 90.0 ± 0.1 %" in found.verdict_text
    assert row.measured_m_s == pytest.approx(made, rel=0.01)


def test_the_fit_keeps_films_out_and_a_voided_one_counts_for_nothing(of_2005) -> None:
    session, fit = of_2005
    again = fit_friction(session.with_reading(filmed(0.8, 0.01)))
    assert again.whole_snake == pytest.approx(fit.whole_snake)
    assert session.with_reading(replace(filmed(0.8, 0.1), voided=True)).kept_films == ()
