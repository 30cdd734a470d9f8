"""Slow motion is measured in real time; the film is the first stream that moves."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from command_line import serpenoid
from refusals import refused
from serpenoid import load_session
from video import answers
from video.answers import remarks_of
from video.worlds import QUICK, shoot


@pytest.fixture(scope="module")
def film(tmp_path_factory) -> Path:
    return shoot(QUICK, tmp_path_factory.mktemp("film") / "film.mp4", seconds=1.7, up=2)


def film_answer(path: Path, line: str = "") -> Any:
    return answers.film_answer(path, f"--set links=4 {line}")


def copied(film, path, *, slower=1, tags=None, cover=False):
    """Copy a film without coding it again: slower, tagged, behind a cover."""
    options = {"movflags": "use_metadata_tags"}
    with av.open(str(film)) as old, av.open(str(path), "w", options=options) as new:
        if cover:
            picture = new.add_stream("mjpeg", rate=1)
            picture.width, picture.height, picture.pix_fmt = 320, 240, "yuvj420p"
            still = av.VideoFrame.from_ndarray(np.zeros((240, 320), np.uint8), format="gray")
            encoded = [*picture.encode(still.reformat(format="yuvj420p")), *picture.encode()]
        stream = new.add_stream_from_template(old.streams.video[0])
        new.metadata.update(tags or {})
        for packet in encoded if cover else []:
            new.mux(packet)
        for packet in old.demux(video=0):
            if packet.size:
                packet.pts, packet.dts = packet.pts * slower, packet.dts * slower
                packet.stream = stream
                new.mux(packet)
    return path


@pytest.fixture(scope="module")
def true_m_s(film):
    return film_answer(film).speed_m_s


def tagged(fps: str) -> dict[str, str]:
    return {"com.android.capture.fps": fps}


def test_a_phones_slow_motion_is_measured_in_real_time_and_says_so(
    film, tmp_path, true_m_s
) -> None:
    slow = copied(film, tmp_path / "slow.mp4", slower=8, tags=tagged("240.000000"))
    told = film_answer(slow)
    assert told.speed_m_s == pytest.approx(true_m_s, rel=1e-9)
    assert told.time_scale == 1 / 8
    assert told.film.capture_fps == 240.0
    words = remarks_of(told)["slow motion"]
    assert "com.android.capture.fps says that the camera took 240 pictures a second" in words
    assert "divided by 8" in words
    typed = f"video {slow} --set links=4 --capture-fps 120 --track {tmp_path / 't.csv'}"
    assert re.search(r"time scale +│ +0.25", serpenoid(typed, check=True).stdout)
    times = np.loadtxt(tmp_path / "t.csv", delimiter=",", skiprows=1, usecols=0)
    assert np.ptp(times) == pytest.approx(2 * told.film.duration_s, rel=1e-6)


def test_rates_of_a_file_and_its_camera(film, tmp_path, true_m_s) -> None:
    """Each second picture of 30 was left out; the camera's rate is by a phone's clock."""
    told = film_answer(copied(film, tmp_path / "film.mp4", slower=2, tags=tagged("119.88")))
    assert told.time_scale == pytest.approx(1 / 4, rel=1e-12)
    assert told.speed_m_s == pytest.approx(2 * true_m_s, rel=1e-6)


@pytest.mark.parametrize(("fps", "words"), [("2", "a time lapse"), ("0", "between 1 and")])
def test_a_rate_that_cannot_be_is_refused(film, tmp_path, fps, words) -> None:
    with refused(words):
        film_answer(copied(film, tmp_path / "film.mp4", tags=tagged(fps)))


def test_the_film_is_the_first_stream_that_moves(film, tmp_path, true_m_s) -> None:
    run = film_answer(copied(film, tmp_path / "cover.mkv", cover=True))
    assert run.film.width_px == 640
    assert run.speed_m_s == pytest.approx(true_m_s, rel=2e-3)  # times to a whole millisecond


def test_a_track_made_of_slow_motion_is_taken_in_real_time(tmp_path) -> None:
    t_s = np.arange(90) / 30
    rolls_s = np.clip(t_s - 0.5, 0.0, 1.5)  # between two rests
    rows = np.column_stack([8 * t_s, 0.75 * rolls_s - 0.25 * rolls_s**2, 0 * t_s])
    np.savetxt(tmp_path / "push.csv", rows, delimiter=",", header="t,x,y", comments="")
    folder = tmp_path / "session"
    serpenoid(f"calibrate new {folder} --defaults --on floor", check=True)
    typed = f"calibrate push {folder} {tmp_path / 'push.csv'} --unit m"
    assert "3.75 places a second, and films have 24 or more" in serpenoid(typed).stdout
    shown = serpenoid(f"{typed} --capture-fps 240", check=True).stdout
    assert "its times are divided by 8" in shown
    (push,) = load_session(folder).kept_pushes
    t_s, x_m, y_m = push.counted
    speed_m_s = np.hypot(x_m[6] - x_m[0], y_m[6] - y_m[0]) / (t_s[6] - t_s[0])
    assert speed_m_s == pytest.approx(0.7, abs=0.1)


def test_a_film_far_slower_than_its_gait_names_the_rate_and_is_no_reading(film, tmp_path) -> None:
    slow, folder = copied(film, tmp_path / "slow.mov", slower=8), tmp_path / "s"
    serpenoid(f"calibrate new {folder} --defaults", check=True)
    gait = "--set links=4 --alpha-deg 40 --beta-deg 80 --omega-rad-s 8"
    done = serpenoid(f"video {slow} --session {folder} {gait}", check=True)
    told = re.sub(r"\s+", " ", done.stderr)
    assert "no reading: slow.mov: the film shows" in told
    assert "is it slow motion, 8 times? Then give the camera's pictures a second, some 240" in told
