"""What is wrong with a film is told in words, or the film is refused; nothing hangs."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import av
import cv2
import numpy as np
import pytest
import serpenoid as sn
from command_line import serpenoid
from refusals import refused
from robots import gait_in_deg
from serpenoid.robot import Robot
from serpenoid.robot.recording.run_gait import recorded_gait
from serpenoid.video.checks import SEEN, SERVOS, run_checks
from serpenoid.video.made_gait import reading_doubt
from serpenoid.video.measure_film import measure_film
from serpenoid.video.result import Joint
from serpenoid.video.seeing.film import Film as File
from serpenoid.video.seeing.watch import watch
from video.filming import Body, Film, Lens, write
from video.worlds import LINK_M, SIDE_M, crawling, errors, most_sigmas

QUICK = crawling(seed=2, omega_rad_s=8.0, alpha_deg=40, speed_m_s=0.08, start_m=-0.06)
TIMES = np.arange(0, 1.7, 1 / 30)
GAIT = gait_in_deg(40, 80, 8.0)
LEFT = np.arange(640) < 320  # columns of a picture in which the tail stays


def drawn(body: Body | None = None, lens: Lens | None = None, times=TIMES, world=QUICK, **more):
    film = Film(lens or Lens(), body or Body(), world.pose, up=2, **more)
    return [film.frame(t) for t in times]


@pytest.fixture(scope="module")
def frames():
    """Two periods, drawn once; faults are made of these pictures."""
    return drawn()


@pytest.fixture
def told(tmp_path):
    """Measure pictures; return the run and its remarks by name."""

    def measured(pictures, times=TIMES, name="film.mp4", codec="libx264", **how):
        path = write(tmp_path / name, pictures, np.asarray(times[: len(pictures)]), codec)
        run = measure_film(path, how.pop("links", 6), how.pop("link_m", LINK_M), **how).run
        return run, {r.name: r.text for r in run.remarks}

    return measured


def shifted(picture, x: float = 0.0, y: float = 0.0, angle_deg: float = 0.0):
    size = picture.shape[::-1]
    move = cv2.getRotationMatrix2D((size[0] / 2, size[1] / 2), angle_deg, 1.0)
    move[:, 2] += x, y
    return cv2.warpAffine(picture, move, size, borderMode=cv2.BORDER_REPLICATE)


def test_a_good_film_has_nothing_to_tell(frames, told) -> None:
    run, remarks = told(frames[::2], TIMES[::2])
    assert run.speed_m_s == pytest.approx(QUICK.speed_m_s, rel=0.005)
    assert not set(remarks) - {"centre"}


def test_a_knock_is_told_and_widens_the_sigmas_and_a_push_is_refused(frames, told) -> None:
    def knocked(x, y):
        moved = [shifted(f, x * (k > 13), y * (k > 13)) for k, f in enumerate(frames[::2])]
        return told(moved, TIMES[::2])

    run, remarks = knocked(0.9, 0)
    assert "moved by 0.9 px, from 1." in remarks["camera"]
    assert abs(run.speed_m_s / QUICK.speed_m_s - 1) > 0.003
    assert most_sigmas(errors(run, QUICK)) < 4
    with refused(r"moved by 7\.\d px, from 1\.\d s on; .* Put the phone on a tripod"):
        knocked(7.0, 2)


@pytest.mark.parametrize(
    "moved",
    [
        lambda f, k: shifted(f, 6 * math.sin(0.2 * k), 5 * math.sin(0.15 * k)),  # held by hand
        lambda f, k: shifted(f, angle_deg=0.06 * k),  # stabilised: about the picture's middle
    ],
)
def test_a_picture_that_moves_all_the_time_is_refused(frames, tmp_path, moved) -> None:
    some = [moved(f, 3 * k) for k, f in enumerate(frames[::3])]
    path = write(tmp_path / "film.mp4", some, TIMES[::3])
    with refused(r"the camera moved by .* switch stabilisation off"):
        run_checks(SEEN, watch(File.open(path), 6))


@pytest.mark.parametrize(
    ("spoil", "words", "how"),
    [
        (lambda f: f[:32:2], r"shows 1\.\d\d periods .* film longer", {"times": TIMES[:32:2]}),
        (
            lambda f: f[::3],
            r"tags are \d\d\.\d mm wide, not 34.0 mm",
            {"times": TIMES[::3], "link_m": 0.09, "side_m": SIDE_M},
        ),
        (lambda f: f[:12], "shows tags 5, 6, but the robot has 4 links", {"links": 4}),
        (lambda f: [np.ascontiguousarray(one[:, ::-1]) for one in f[:12]], "selfie cameras", {}),
        (lambda _: [np.full((540, 960), 120, np.uint8)] * 12, "no tag is seen in 12 frames", {}),
        (lambda f: f[:1] * 12, "no joint moves|periods", {}),
        (lambda f: f[:1], "has 1 of 10 frames", {}),
        (
            lambda f: [f[0], *(np.where(LEFT, one, 200) for one in f[1:30:2])],
            "hidden or out of the picture",
            {"times": TIMES[:32:2]},
        ),
    ],
    ids=["short", "links", "robot", "mirrored", "floor", "rest", "picture", "leaves"],
)
def test_what_cannot_be_measured_is_refused(frames, told, spoil, words, how) -> None:
    with refused(words):
        told(spoil(frames), **how)


def grey_with(numbers: list[int]) -> np.ndarray:
    """Return a grey picture with some of our tags in it."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    picture = np.full((540, 960), 200, np.uint8)
    for number in numbers:
        picture[240:300, 100:160] = cv2.aruco.generateImageMarker(family, number, 60)
    return picture


def test_one_stray_hit_in_fifty_frames_starts_no_advice(told) -> None:
    frames = [grey_with([])] * 50
    frames[20] = grey_with([42])
    with refused("no tag is seen in 50 frames; print ours"):
        told(frames)
    frames[20:32] = [grey_with([42])] * 12
    with refused("tags 43, but the robot has 6 links"):
        told(frames)


def test_links_that_tags_contradict_widen_the_sigma_of_lengths_and_speed(frames, told) -> None:
    run, remarks = told(frames[::3], TIMES[::3], link_m=1.04 * LINK_M, side_m=SIDE_M)
    assert "σ of all lengths and speeds" in remarks["scale"]
    assert run.scale_sigma == pytest.approx(0.04, abs=0.005)
    assert run.speed_sigma_m_s > abs(run.speed_m_s - QUICK.speed_m_s) / 1.2


def test_a_number_that_is_seen_twice_counts_for_neither(frames, told) -> None:
    two = [np.concatenate([frame, frame[::-1, ::-1]]) for frame in frames[::4]]
    with refused("numbers that are seen twice in a picture do not count"):
        told(two, TIMES[::4])


def test_a_lamp_that_flickers_does_not_move_the_camera(frames, tmp_path) -> None:
    gains = (1.0, 0.7, 1.2, 0.8)
    lit = [cv2.convertScaleAbs(f, alpha=gain) for f, gain in zip(frames[::16], gains, strict=True)]
    seen = watch(File.open(write(tmp_path / "film.mp4", lit, TIMES[::16])), 6)
    assert len(seen.shifts) == 3
    assert run_checks([check for check in SEEN if check.name == "camera"], seen) == []


def test_swapped_tags_are_refused(told) -> None:
    with refused(r"tag [24] and the next one are no neighbours"):
        told(drawn(Body(ids=(0, 1, 3, 2, 4, 5)), times=TIMES[::4]), times=TIMES[::4])


@pytest.mark.slow
def test_blur_is_named(told) -> None:
    run, remarks = told(drawn(lens=Lens(exposure_s=1 / 25), steps=6))
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
        measure_film(path, 6, LINK_M)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("words.mp4", b"no film at all" * 99, "cannot be read as a film"),
        ("none.mp4", None, "No such file"),
        ("", None, "this is a folder"),
    ],
)
def test_what_is_no_film_is_named(tmp_path, name, content, words) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with refused(words):
        measure_film(tmp_path / name, 6, LINK_M)


def servo_remarks(run, gait=GAIT):
    return run_checks(SERVOS, (run, gait))


def run_of(phase_deg: list[float], offset_deg: list[float] | None = None) -> SimpleNamespace:
    """Return what the joints of a film say, which is what servos are judged by."""
    offsets = offset_deg or [0.0] * len(phase_deg)
    joints = tuple(
        Joint(i + 1, math.radians(40), 1e-3, math.radians(p), 1e-3, math.radians(o), 1e-3, 1.0)
        for i, (p, o) in enumerate(zip(phase_deg, offsets, strict=True))
    )
    return SimpleNamespace(
        joints=joints,
        omega_rad_s=8.0,
        omega_sigma_rad_s=1e-3,
        time_scale=1.0,
        film={"frame_rate_hz": 30.0},
    )


EVEN = [0.0, 80, 160, 240, 320]  # of joints at 40 deg and 8 rad/s


@pytest.mark.parametrize("gait", [GAIT, None])
@pytest.mark.parametrize(
    ("phases_deg", "joint"), [((0, 80, 340, 240, 320), 3), ((0, 80, 240, 160, 320), 4)]
)
def test_a_servo_that_turns_the_wrong_way_and_swapped_plugs_are_named(
    gait, phases_deg, joint
) -> None:
    assert servo_remarks(run_of(EVEN), gait) == []
    (remark,) = servo_remarks(run_of(list(phases_deg)), gait)
    assert remark.name == "phase"
    assert f"joint {joint} is" in remark.text or gait is None


@pytest.mark.parametrize(
    ("alpha_deg", "beta_deg", "rate", "doubt"),
    [
        (40, 80, 8.0, ""),
        (60, 80, 8.0, ""),  # servos lose amplitude
        (30, 80, 8.0, "stated was"),
        (90, 80, 8.0, "stated was"),
        (40, 80, 8.3, "stated was"),
        (40, 120, 8.0, "stated was"),
        (40, 80, 32.0, "is it slow motion, 4 times"),
    ],
)
def test_a_film_of_another_gait_than_was_stated_is_no_reading(
    alpha_deg, beta_deg, rate, doubt
) -> None:
    gait = sn.Gait(math.radians(alpha_deg), math.radians(beta_deg), rate)
    words = reading_doubt(run_of(EVEN), gait, [])
    assert doubt in words
    assert bool(words) == bool(doubt)
    assert reading_doubt(run_of(EVEN), None, [gait]) == (words if "slow" in doubt else "")


def test_a_centre_that_is_off_asks_for_a_trim() -> None:
    run = run_of([0.0, 80, 160, 240, 320], [0.0, 0, 2.5, 0, 0])
    (remark,) = servo_remarks(run)
    assert "joint 3 swings about +2.5°" in remark.text
    assert remark.text.endswith("move its trim by -2.5°")
    (at_end,) = servo_remarks(run_of([0.0, 80, 160, 240, 320], [2.5, 0, 0, 0, 0]))
    assert "unless the tag at that end is glued on askew" in at_end.text
    assert servo_remarks(run, replace(GAIT, offset_rad=math.radians(2.5)))[0].name == "centre"


def test_a_recording_gives_the_gait_that_was_commanded(tmp_path) -> None:
    path = tmp_path / "run.wire"
    gait = gait_in_deg(30, 80, 5.0)
    with Robot("virtual:fast", record=path) as robot:
        robot.gait(gait)
        list(robot.frames(8.0))
    found = recorded_gait(path, 5)
    assert found.alpha_rad == pytest.approx(gait.alpha_rad, abs=math.radians(0.2))
    assert found.beta_rad == pytest.approx(gait.beta_rad, abs=math.radians(0.3))
    assert found.omega_rad_s == pytest.approx(gait.omega_rad_s, rel=0.01)
    with refused("has 5 joints; the robot has 3"):
        recorded_gait(path, 3)


def test_without_the_extra_the_way_to_it_is_told(monkeypatch, tmp_path) -> None:
    monkeypatch.setattr("serpenoid.video.seeing.extra.find_spec", lambda name: None)
    for typed in (["film.mp4"], ["tags", "--out", tmp_path / "tags.pdf"]):
        assert "pip install 'serpenoid[video]'" in serpenoid("video", *typed).stderr


def test_only_this_room_imports_the_extras_packages_and_only_when_used() -> None:
    package = Path(sn.__file__).parent
    for path in package.rglob("*.py"):
        found = re.findall(r"^( *)(?:import|from) (?:cv2|av)\b", path.read_text("utf-8"), re.M)
        assert not found or (path.is_relative_to(package / "video") and "" not in found), path
