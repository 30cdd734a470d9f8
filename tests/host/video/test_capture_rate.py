"""Slow motion is measured in real time; the film is the first stream that moves."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest
from calibration.floor_sessions import TRUTH, push_track
from command_line import serpenoid
from refusals import refused
from serpenoid import Gait, _core, load_session
from serpenoid.model.capture_rate import capture_rate
from serpenoid.taking.new_session import create_session, default_setup
from serpenoid.video.measure_film import measure_film
from serpenoid.video.seeing.film import Film

DEMO_FILM = Path(_core.__file__).parent / "calibration_data" / "demo-film" / "film.mp4"
LINK_M = 0.076


def copied(path, *, slower=1, tags=None, cover=False):
    """Copy the demo's film without coding it again: slower, tagged, behind a cover."""
    options = {"movflags": "use_metadata_tags"}
    with av.open(str(DEMO_FILM)) as old, av.open(str(path), "w", options=options) as new:
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


ANDROID = {"com.android.capture.fps": "240.000000"}


@pytest.fixture(scope="module")
def true_m_s():
    return measure_film(DEMO_FILM, 6, LINK_M).run.speed_m_s


def test_a_phones_slow_motion_is_measured_in_real_time_and_says_so(tmp_path, true_m_s) -> None:
    film = copied(tmp_path / "slow.mp4", slower=8, tags=ANDROID)
    told = json.loads(serpenoid(f"video {film} --json", check=True).stdout)
    assert told["speed_m_s"] == pytest.approx(true_m_s, rel=1e-9)
    assert told["time_scale"] == 1 / 8
    assert (told["film"]["capture_fps"], told["film"]["played_fps"]) == (240.0, 30.0)
    (words,) = (r["text"] for r in told["remarks"] if r["name"] == "slow motion")
    assert "com.android.capture.fps says that the camera took 240 pictures a second" in words
    assert "divided by 8" in words
    shown = serpenoid(f"video {film} --capture-fps 120 --track {tmp_path / 't.csv'}", check=True)
    assert re.search(r"time scale +│ +0.25", shown.stdout)
    times = np.loadtxt(tmp_path / "t.csv", delimiter=",", skiprows=1, usecols=0)
    assert np.ptp(times) == pytest.approx(2 * told["film"]["duration_s"], rel=1e-6)


def test_the_film_is_the_first_stream_that_moves(tmp_path, true_m_s) -> None:
    run = measure_film(copied(tmp_path / "cover.mkv", cover=True), 6, LINK_M).run
    assert run.film["codec"] == "h264"
    assert run.speed_m_s == pytest.approx(true_m_s, rel=2e-3)  # times to a whole millisecond


@pytest.mark.parametrize(
    ("rate_hz", "taken_hz", "scale"),
    [
        (30, 240, 1 / 8),
        (29.97, 119.88, 1 / 4),  # a phone's clock
        (240, 240, 1),  # stored in real time, for a player to slow down
        (15, 120, 1 / 4),  # each second picture of 30 was left out
        (18, 30, 1),  # dim light
        (25, 120, 25 / 120),
    ],
)
def test_rates_of_a_file_and_its_camera(rate_hz, taken_hz, scale) -> None:
    t_s = np.arange(40) / rate_hz
    assert capture_rate(t_s, taken_hz, "a tag").time_scale == pytest.approx(scale, rel=1e-12)


@pytest.mark.parametrize(("taken_hz", "words"), [(2.0, "a time lapse"), (0.0, "between 1 and")])
def test_a_rate_that_cannot_be_is_refused(taken_hz, words) -> None:
    with refused(words):
        capture_rate(np.arange(40) / 30, taken_hz, "the tag x.capture.fps")


def test_a_track_made_of_slow_motion_is_taken_in_real_time(tmp_path) -> None:
    rows = push_track(0.8, TRUTH, np.random.default_rng(1))
    rows[:, 0] *= 8
    np.savetxt(tmp_path / "push.csv", rows, delimiter=",", header="t,x,y", comments="")
    folder = create_session(tmp_path / "session", default_setup("slow"))
    typed = f"calibrate push {folder} {tmp_path / 'push.csv'} --unit m"
    assert "3.75 places a second, and films have 24 or more" in serpenoid(typed).stdout
    shown = serpenoid(f"{typed} --capture-fps 240", check=True).stdout
    assert "its times are divided by 8" in shown
    (push,) = load_session(folder).kept_pushes
    t_s, x_m, y_m = push.counted
    assert np.hypot(x_m[6] - x_m[0], y_m[6] - y_m[0]) / (t_s[6] - t_s[0]) == pytest.approx(
        0.75, 0.1
    )


def test_a_film_far_slower_than_a_sessions_gait_names_the_rate_and_is_no_reading(tmp_path) -> None:
    film = copied(tmp_path / "slow.mov", slower=8)
    setup = default_setup("slow")
    plan = replace(setup.plan, gaits=(Gait.degrees(60, 75, hertz=0.8333),))
    folder = create_session(tmp_path / "s", replace(setup, plan=plan))
    done = serpenoid(f"video {film} --session {folder}", check=True)
    told = re.sub(r"\s+", " ", done.stderr)
    assert "no reading: slow.mov: the film shows" in told
    assert "is it slow motion, 8 times? Then give the camera's pictures a second, some 240" in told
    assert Film.open(film).time_scale == 1.0
    slow = Film.open(film, 240.0)
    assert slow.time_scale == 1 / 8
    assert slow.duration_s == pytest.approx(Film.open(film).duration_s / 8)
