"""What no file tells of itself: two tags of a number, lamps that flicker."""

from __future__ import annotations

import cv2
import numpy as np
from refusals import refused
from serpenoid.video.checks import SEEN, run_checks
from serpenoid.video.seeing.film import Film as File
from serpenoid.video.seeing.watch import watch
from video.filming import Body, Film, Lens, write
from video.worlds import crawling

OMEGA = 6.0
CAMERA = [check for check in SEEN if check.name == "camera"]
LIGHT = (1.0, 0.7, 1.2, 0.8, 1.1)
WORLD = crawling(omega_rad_s=OMEGA, speed_m_s=0.05, start_m=-0.06)
STEP_S = 1 / 30


def pictures(count: int, step_s: float = 0.3) -> tuple[list[np.ndarray], np.ndarray]:
    film, times = Film(Lens(), Body(), WORLD.pose, up=2), np.arange(count) * step_s
    return [film.frame(t) for t in times], times


def test_a_number_that_is_seen_twice_counts_for_neither(tmp_path) -> None:
    frames, _ = pictures(5)
    two = [np.concatenate([frame, frame[::-1, ::-1]]) for frame in frames] * 2
    seen = watch(File.open(write(tmp_path / "film.mp4", two, np.arange(10) * 0.3)), 6)
    assert not seen.sightings.seen.any()
    with refused(r"same number .* \(numbers 1, 2, 3, 4, 5, 6\): another"):
        run_checks(SEEN, seen)


def test_a_lamp_that_flickers_does_not_move_the_camera(tmp_path) -> None:
    frames, times = pictures(5, 0.55)
    lit = [cv2.convertScaleAbs(f, alpha=gain) for f, gain in zip(frames, LIGHT, strict=True)]
    seen = watch(File.open(write(tmp_path / "film.mp4", lit, times)), 6)
    assert len(seen.shifts) == 4
    assert run_checks(CAMERA, seen) == []
