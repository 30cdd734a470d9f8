"""What no file tells of itself: cuts, held pictures, two of a number, tags that are not flat."""

from __future__ import annotations

import math
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from refusals import refused
from serpenoid.video.checks import FOLLOWED, MOVED, SEEN, run_checks
from serpenoid.video.fitting.frames import Track
from serpenoid.video.fitting.start import first_cameras
from serpenoid.video.instrument import follow
from serpenoid.video.motion import fit_motion
from serpenoid.video.seeing.film import Film as File
from serpenoid.video.seeing.sightings import Sightings
from serpenoid.video.seeing.watch import watch
from video.filming import Body, Film, Lens, write
from video.sighted import sighted
from video.worlds import LINK_M, SIDE_M, crawling

OMEGA = 6.0
CAMERA = [check for check in SEEN if check.name == "camera"]
JUMP = [check for check in MOVED if check.name == "jump"]
LIGHT = (1.0, 0.7, 1.2, 0.8, 1.1)
WORLD = crawling(omega_rad_s=OMEGA, speed_m_s=0.05, start_m=-0.06)
STEP_S, PERIOD_S = 1 / 30, math.tau / OMEGA


def followed(t_s: np.ndarray, told_s: np.ndarray) -> SimpleNamespace:
    """Return a measured film as far as cuts are looked for in it: the true chain with noise."""
    poses = [WORLD.pose(t) for t in t_s]
    states = np.array([[*centre.mean(axis=0), *theta] for centre, theta in poses])
    states += np.random.default_rng(1).normal(size=states.shape) * [1e-4, 1e-4, *[1e-3] * 6]
    joints, one = np.ones((len(t_s), 5)), np.ones(len(t_s))
    track = Track(told_s, states, one, joints, one)
    camera = SimpleNamespace(link_m=LINK_M)
    return SimpleNamespace(
        fitted=fit_motion(track, joints, one),
        track=track,
        held=joints > 0,
        bundle=SimpleNamespace(camera=camera),
    )


def cut_out(gone_s: float) -> np.ndarray:
    """Return the moments of 66 pictures, of which some seconds were cut out after a third."""
    return np.arange(66) * STEP_S + gone_s * (np.arange(66) >= 22)


@pytest.mark.parametrize("gone_s", [PERIOD_S, 0.2, STEP_S])
def test_a_film_that_was_cut_is_refused(gone_s) -> None:
    """After a whole period the joints go on as before, and only the robot's place jumps."""
    found = followed(cut_out(gone_s), np.arange(66) * STEP_S)
    with refused(r"^the robot jumps at 0\.7\d s: .* is cut there"):
        run_checks(JUMP, found)


def test_a_gap_that_the_times_tell_is_no_cut() -> None:
    assert not run_checks(JUMP, followed(cut_out(0.2), cut_out(0.2)))


def test_pictures_that_stand_still_for_a_while_are_refused() -> None:
    told = np.arange(66) * STEP_S
    held = np.where((told > 1.0) & (told < 1.25), 1.0, told)
    with refused(r"jumps at 1\.2\d s: .* pictures are missing"):
        run_checks(JUMP, followed(held, told))


def test_a_tag_that_peels_off_is_refused() -> None:
    t_s = np.arange(50) * STEP_S
    s = sighted(WORLD, t_s, Lens())
    corners = s.corners_px.copy()
    corners[:, 3, 1, 1] -= 3.0 + 2.0 * np.sin(5 * t_s)  # one of its corners stands up, and flaps
    spoiled = Sightings.of(t_s, corners, s.image_px)
    with refused("tag 4 is no flat square"):
        run_checks(FOLLOWED, follow(spoiled, SIDE_M, first_cameras(spoiled, LINK_M, SIDE_M)).track)


def pictures(count: int, step_s: float = 0.3) -> tuple[list[np.ndarray], np.ndarray]:
    film, times = Film(Lens(), Body(), WORLD.pose, up=2), np.arange(count) * step_s
    return [film.frame(t) for t in times], times


def test_a_number_that_is_seen_twice_counts_for_neither(tmp_path) -> None:
    frames, times = pictures(5)
    two = [np.concatenate([frame, frame[::-1, ::-1]]) for frame in frames]
    seen = watch(File.open(write(tmp_path / "film.mp4", two, times)), 6)
    assert not seen.sightings.seen.any()
    with refused(r"same number .* \(numbers 1, 2, 3, 4, 5, 6\): another"):
        run_checks(SEEN, seen)


def test_a_lamp_that_flickers_does_not_move_the_camera(tmp_path) -> None:
    frames, times = pictures(5, 0.55)
    lit = [cv2.convertScaleAbs(f, alpha=gain) for f, gain in zip(frames, LIGHT, strict=True)]
    seen = watch(File.open(write(tmp_path / "film.mp4", lit, times)), 6)
    assert len(seen.shifts) == 4
    assert run_checks(CAMERA, seen) == []
