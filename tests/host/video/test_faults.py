"""Faults of a film are named in remarks, or the film is refused; no measurement hangs."""

from __future__ import annotations

import math
import re

import av
import cv2
import numpy as np
import pytest
from command_line import serpenoid
from refusals import refused
from video.answers import film_answer, remarks_of
from video.filming import Body, Film, Lens, write
from video.worlds import LINK_M, QUICK, SIDE_M, crawling, errors, max_sigmas

TIMES = np.arange(0, 1.7, 1 / 30)
LEFT = np.arange(640) < 320  # the left half of a picture, where the tail is


def drawn(body: Body | None = None, lens: Lens | None = None, times=TIMES, world=QUICK, **more):
    film = Film(lens or Lens(), body or Body(4), world.pose, up=2, **more)
    return [film.frame(t) for t in times]


@pytest.fixture(scope="module")
def frames():
    """Return the pictures of two periods, from which the faulty films are made."""
    return drawn()


@pytest.fixture
def measure(tmp_path):
    """Return a function that measures pictures and returns the run and its remarks by name."""

    def measured_pictures(pictures, times=TIMES, line="--set links=4"):
        path = write(tmp_path / "film.mp4", pictures, np.asarray(times[: len(pictures)]))
        run = film_answer(path, line)
        return run, remarks_of(run)

    return measured_pictures


def shifted(picture, x: float = 0.0, y: float = 0.0, angle_deg: float = 0.0):
    size = picture.shape[::-1]
    move = cv2.getRotationMatrix2D((size[0] / 2, size[1] / 2), angle_deg, 1.0)
    move[:, 2] += x, y
    return cv2.warpAffine(picture, move, size, borderMode=cv2.BORDER_REPLICATE)


def test_a_good_film_with_a_flickering_lamp_has_no_remarks(frames, measure) -> None:
    gains = (1.0, 0.7, 1.2, 0.8)
    some = enumerate(frames[::2])
    lit = [cv2.convertScaleAbs(f, alpha=gains[k * 2 // 15 % 4]) for k, f in some]
    run, remarks = measure(lit, TIMES[::2])
    assert run.speed_m_s == pytest.approx(QUICK.speed_m_s, rel=0.005)
    assert not set(remarks) - {"centre"}


def test_a_small_move_of_the_camera_is_named_and_a_large_one_refused(frames, measure) -> None:
    def measure_moved(x, y):
        moved = [shifted(f, x * (k > 13), y * (k > 13)) for k, f in enumerate(frames[::2])]
        return measure(moved, TIMES[::2])

    run, remarks = measure_moved(0.9, 0)
    assert "moved by 0.9 px, from 1." in remarks["camera"]
    assert abs(run.speed_m_s / QUICK.speed_m_s - 1) > 0.003
    assert max_sigmas(errors(run, QUICK)) < 4
    with refused(r"moved by 7\.\d px, from 1\.\d s on; .* Put the phone on a tripod"):
        measure_moved(7.0, 2)


@pytest.mark.parametrize(
    "moved",
    [
        lambda f, k: shifted(f, 6 * math.sin(0.2 * k), 5 * math.sin(0.15 * k)),  # held by hand
        lambda f, k: shifted(f, angle_deg=0.06 * k),  # stabilised: about the picture's middle
    ],
)
def test_a_moving_camera_is_refused(frames, measure, moved) -> None:
    with refused(r"the camera moved by .* switch stabilisation off"):
        measure([moved(f, 3 * k) for k, f in enumerate(frames[::3])], TIMES[::3])


@pytest.mark.parametrize(
    ("damage", "every", "message", "line"),
    [
        (lambda f: f[:16], 2, r"shows 1\.\d\d periods .* film longer", ""),
        (
            lambda f: f,
            3,
            r"tags are \d\d\.\d mm wide, not 34.0 mm",
            f"--set links=4 --set link_length_m=0.09 --tag-mm {1e3 * SIDE_M}",
        ),
        (lambda f: f[:12], 1, "shows tag [34], but the robot has 2 links", "--set links=2"),
        (lambda f: [np.ascontiguousarray(one[:, ::-1]) for one in f[:12]], 1, "selfie cameras", ""),
        (lambda _: [np.full((540, 960), 120, np.uint8)] * 12, 1, "no tag is seen in 12 frames", ""),
        (lambda f: f[:1] * 12, 1, "no joint moves|periods", ""),
        (lambda f: f[:1], 1, "only 1 of 1 frames show two tags", ""),
        (
            lambda f: [f[0], *(np.where(LEFT, one, 200) for one in f[1:15])],
            2,
            "hidden or out of the picture",
            "",
        ),
        (
            lambda f: [np.concatenate([one, one[::-1, ::-1]]) for one in f],
            4,
            "numbers that are seen twice in a picture do not count",
            "",
        ),
    ],
    ids=["short", "links", "robot", "mirrored", "floor", "rest", "picture", "leaves", "twice"],
)
def test_films_that_cannot_be_measured_are_refused(
    frames, measure, damage, every, message, line
) -> None:
    with refused(message):
        measure(damage(frames[::every]), TIMES[::every], line or "--set links=4")


def grey_with(numbers: list[int]) -> np.ndarray:
    """Return a grey picture with tags of these numbers."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    picture = np.full((540, 960), 200, np.uint8)
    for number in numbers:
        picture[240:300, 100:160] = cv2.aruco.generateImageMarker(family, number, 60)
    return picture


def test_one_false_tag_in_fifty_frames_is_ignored(measure) -> None:
    frames = [grey_with([])] * 50
    frames[20] = grey_with([42])
    with refused("no tag is seen in 50 frames; print ours"):
        measure(frames)
    frames[20:32] = [grey_with([42])] * 12
    with refused("tag 43, but the robot has 4 links"):
        measure(frames)


def test_a_link_length_that_disagrees_with_the_tags_widens_the_sigmas(frames, measure) -> None:
    sizes = f"--set links=4 --set link_length_m={1.04 * LINK_M} --tag-mm {1e3 * SIDE_M}"
    run, remarks = measure(frames[::3], TIMES[::3], sizes)
    assert "σ of all lengths and speeds" in remarks["scale"]
    assert run.scale_sigma == pytest.approx(0.04, abs=0.005)
    assert run.speed_sigma_m_s > abs(run.speed_m_s - QUICK.speed_m_s) / 1.2


def test_swapped_tags_are_refused(measure) -> None:
    with refused(r"tag [13] and the next one are no neighbours"):
        measure(drawn(Body(4, ids=(0, 2, 1, 3)), times=TIMES[::4]), times=TIMES[::4])


@pytest.mark.slow
def test_blur_is_named(measure) -> None:
    run, remarks = measure(drawn(lens=Lens(exposure_s=1 / 25), steps=6))
    assert "shorten the exposure" in remarks["blur"]
    assert run.speed_m_s == pytest.approx(QUICK.speed_m_s, rel=0.01)


def test_a_damaged_film_is_refused(frames, tmp_path) -> None:
    path = write(tmp_path / "film.mkv", frames[:30], TIMES[:30], gop=10)
    broken = bytearray(path.read_bytes())
    with av.open(str(path)) as box:
        packets = [p for p in box.demux(video=0) if p.pts is not None]
    last = min(packets, key=lambda p: abs(float(p.pts * p.time_base) - 0.8))
    for place in range(last.pos + 40, last.pos + last.size):
        broken[place] ^= 0xFF
    path.write_bytes(broken)
    with refused(r"is damaged after 0\.7\d s: copy it from the phone again"):
        film_answer(path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("words.mp4", b"no film at all" * 99, "cannot be read as a film"),
        ("none.mp4", None, "No such file"),
        ("", None, "this is a folder"),
    ],
)
def test_files_without_a_film_are_refused(tmp_path, name, content, message) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with refused(message):
        film_answer(tmp_path / name)


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    """Return a film whose joint 3 turns the wrong way, and whose joint 2 has an offset."""
    world = crawling(2, 4, omega_rad_s=8.0, alpha_deg=40, start_m=-0.06, wrong_way=2)
    pictures = drawn(times=TIMES[::2], world=world)
    return write(tmp_path_factory.mktemp("film") / "faulty.mp4", pictures, TIMES[::2])


STATED_GAIT = "--set links=4 --alpha-deg 40 --beta-deg 80 --omega-rad-s"


def test_reversed_servos_and_wrong_trims_are_named(faulty) -> None:
    remarks = remarks_of(film_answer(faulty, f"{STATED_GAIT} 8"))
    assert "joint 3 is" in remarks["phase"]
    assert "does the servo turn the wrong way" in remarks["phase"]
    assert re.search(
        r"joint 2 swings about \+[23]\.\d° .* move its trim by -[23]", remarks["centre"]
    )


@pytest.mark.parametrize(
    ("gait", "message"),
    [
        (f"{STATED_GAIT} 8.3", "stated was"),
        (f"{STATED_GAIT} 32", "is it slow motion, 4 times"),
    ],
)
def test_a_film_of_another_gait_is_no_reading(frames, tmp_path, gait, message) -> None:
    folder, film = tmp_path / "session", tmp_path / "film.mp4"
    serpenoid(f"calibrate new {folder} --defaults", check=True)
    write(film, frames[::3], TIMES[::3])
    messages = serpenoid(f"video {film} {gait} --session {folder}", check=True).stderr
    assert "no reading" in messages
    assert message in messages


def test_without_opencv_the_message_names_the_extra(monkeypatch, tmp_path) -> None:
    monkeypatch.setattr("serpenoid.video.seeing.extra.find_spec", lambda name: None)
    for typed in (["film.mp4"], ["tags", "--out", tmp_path / "tags.pdf"]):
        assert "pip install 'serpenoid[video]'" in serpenoid("video", *typed).stderr
