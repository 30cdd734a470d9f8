"""How many frames a second of a 1080p film are measured on one core, and where the time goes.

python studies/film_speed.py

Processor time, all in one thread: the decoder alone, with detection, with the fit of camera, chain
and motion. The fit costs the same some seconds for any film up to a minute.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
from films import larger, plain, shot
from serpenoid.video.fitting.start import first_cameras
from serpenoid.video.instrument import measure
from serpenoid.video.seeing.film import Damage, Film
from serpenoid.video.seeing.tags import tag_side_m
from serpenoid.video.seeing.watch import Watched, watch
from video.worlds import LINK_M


def film_of_1080p(folder: Path) -> Path:
    """Render two periods of a crawl in 1920 x 1080 px, with noise, as a phone would code it."""
    scene = larger(plain(np.random.default_rng([1, 0])), 1080 / 480)
    return shot(replace(scene, lens=replace(scene.lens, width=1920)), folder / "film.mp4", 0)


def seconds(call: Callable[[], object]) -> float:
    """Return the processor time of a call, s: the least of three."""
    taken = []
    for _ in range(3):
        begun = time.process_time()
        call()
        taken.append(time.process_time() - begun)
    return min(taken)


def fitted(watched: Watched) -> None:
    """Fit all that a film's numbers need."""
    side = tag_side_m(LINK_M)
    measure(watched.sightings, side, first_cameras(watched.sightings, LINK_M, side))


def main() -> None:
    """Render, measure, print."""
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        film = Film.open(film_of_1080p(Path(folder)))
        decode_s = seconds(lambda: sum(1 for _ in film.frames(Damage(), threads=1)))
        watch_s = seconds(lambda: watch(film, 6, threads=1))
        watched = watch(film, 6, threads=1)
        fit_s = seconds(lambda: fitted(watched))
    frames = len(watched.sightings.t_s)
    side = float(np.nanmedian(watched.sightings.side_px))
    print(f"{frames} frames of 1920 x 1080 px, tags of {side:.0f} px")
    print(f"decoder            {1e3 * decode_s / frames:5.1f} ms a frame")
    print(f"detection, floor   {1e3 * (watch_s - decode_s) / frames:5.1f} ms a frame")
    print(f"both               {frames / watch_s:5.0f} frames/s")
    print(f"fit                {fit_s:5.2f} s a film")
    print(f"all of this film   {frames / (watch_s + fit_s):5.0f} frames/s")


if __name__ == "__main__":
    main()
