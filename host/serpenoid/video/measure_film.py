"""One call from a film file to its numbers: watch, refuse, measure, tell."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..base.checks import check_number
from ..base.errors import BadInput
from ..model.gait import Gait
from .checks import run_checks, widened_sigmas
from .fitting.camera import Camera
from .fitting.start import first_cameras, tag_poses
from .instrument import follow, measure
from .result import FilmMeasurement, Remark, filmed_run
from .seeing.film import Film
from .seeing.sightings import Sightings
from .seeing.tags import MOST_LINKS, tag_side_m
from .seeing.watch import Watched, watch


def measure_film(
    path: Path,
    links: int,
    link_m: float,
    side_m: float | None = None,
    gait: Gait | None = None,
    board_rate: bool = False,
    progress: Callable[[float], object] = lambda _: None,
    capture_fps: float | None = None,
) -> FilmMeasurement:
    """Measure what the robot of a film does.

    links, link_m: number and length (m) of its links. side_m: of a printed tag, without its white
    rim; that of the printed sheet unless given. gait: what was commanded. board_rate: its rate is
    the board's own (of a recording), and the film's times are scaled to it. capture_fps: pictures a
    second that the camera took, of slow motion whose file does not tell. Raises BadInput: no
    film, or one that cannot be measured; the message says why and what to do.
    """
    watched, side, starts, remarks_seen = seen_film(
        path, links, link_m, side_m, progress, capture_fps
    )
    scale = 1.0
    with refusals(path):
        followed = follow(watched.sightings, side, starts)
        run_checks("followed", followed[-1])
        measured = measure(*followed)
        if board_rate and gait is not None:
            scale = measured.motion.omega_rad_s / gait.omega_rad_s
            s = watched.sightings
            t_s = s.t_s[0] + (s.t_s - s.t_s[0]) * scale
            in_board_time = Sightings.from_corners(t_s, s.corners_px, s.image_px)
            measured = measure(*follow(in_board_time, side, starts))
        measured = replace(measured, sigmas=widened_sigmas(watched, measured))
        remarks = [
            *run_checks("moved", measured),
            *run_checks("fitted", measured.bundle),
            *remarks_seen,
        ]
        run = filmed_run(watched, measured, scale)
        run = replace(run, remarks=(*remarks, *run_checks("servos", (run, gait))))
        return FilmMeasurement(run, watched, measured, gait)


@contextmanager
def refusals(path: Path) -> Iterator[None]:
    """Tell what cannot be measured with the film's name."""
    try:
        yield
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error
    except np.linalg.LinAlgError as error:
        raise BadInput(
            f"{path}: the tags fit no camera ({error}); are they flat, matt and well lit, and is "
            "the whole robot in the picture?"
        ) from error


def seen_film(
    path: Path,
    links: int,
    link_m: float,
    side_m: float | None,
    progress: Callable[[float], object],
    capture_fps: float | None,
) -> tuple[Watched, float, list[Camera], list[Remark]]:
    """Return what a film shows, a tag's side (m), cameras to start from, and remarks.

    Arguments as of `measure_film`. Raises BadInput: it shows no robot.
    """
    check_number("links", links, 2, MOST_LINKS)
    side = tag_side_m(link_m) if side_m is None else check_number("side_m", side_m, 0.003, link_m)
    watched = watch(Film.open(path, capture_fps), links, progress)
    with refusals(path):
        remarks = run_checks("seen", watched)
        starts = first_cameras(watched.sightings, link_m, side)
        run_checks("placed", tag_poses(starts[0], watched.sightings)[0])
    return watched, side, starts, remarks
