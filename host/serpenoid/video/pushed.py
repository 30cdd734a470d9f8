"""A film of pushes: where a robot that holds its joints still is in each frame."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..base.errors import BadInput
from .arrays import Array, Mask
from .checks import run_checks
from .fitting.camera import LENS
from .fitting.chain import joint_angles
from .instrument import fill_hidden, follow
from .measure_film import refusals, seen_film
from .result import Remark


def track_pushes(
    path: Path,
    links: int,
    link_m: float,
    side_m: float | None,
    progress: Callable[[float], object],
    capture_fps: float | None,
) -> tuple[Array, float, list[Remark]]:
    """Follow a robot whose joints are locked through a film of one push or more.

    Parameters
    ----------
    path
        The film.
    links, link_m
        Number and length (m) of the robot's links.
    side_m
        Of a printed tag, without its white rim; that of the printed sheet unless given.
    progress
        Called with the share of the film that is read.
    capture_fps
        Pictures a second that the camera took, of slow motion whose file does not tell.

    Returns
    -------
    rows
        Time s, and place x, y m of the mean of the links' centres in the plane of the tags, (K, 3):
        all pushes, the rests between them, and gaps where a hand hides the tags.
    scale_sigma
        Relative standard deviation of all lengths.
    remarks
        What to know about the film.

    Raises
    ------
    BadInput
        No film, one that cannot be measured, or joints that move; the message says what to do.
    """
    watched, side, starts, remarks = seen_film(path, links, link_m, side_m, progress, capture_fps)
    with refusals(path):
        fit, tagged, track = follow(watched.sightings, side, starts, rigid=True)
        # A hidden link stands to its neighbours as it always does.
        phi = still_joints(joint_angles(track.states), tagged.visible)
        track = fill_hidden(fit, tagged, track, phi)
        # A frame whose place is known to more than 3 mm says nothing: a hand hides the tags.
        clear = track.place_variance < 0.003**2
        rows = np.column_stack([track.t_s, track.states[:, :2]])[clear]
        if len(rows) <= 1:
            raise BadInput("no frame shows where the robot is; are the tags hidden?")
        remarks = [*run_checks("fitted", fit), *remarks]
    # Joints that do not move tell the link length only as well as tags lie on the links: all
    # lengths are known as the tags' printed side is.
    row = LENS.index("log_side")
    scale_sigma = math.hypot(fit.covariance[row, row] ** 0.5, fit.scale_off)
    return rows, scale_sigma, remarks


def still_joints(phi: Array, visible: Mask) -> Array:
    """Return the angles at which joints are held, (joints,), rad. Raises BadInput: they move."""
    angle = np.ma.array(phi, mask=~(visible[:, 1:] & visible[:, :-1]))
    held_rad = np.ma.median(angle, axis=0)
    moved_deg = np.ma.filled(np.degrees(1.4826 * np.ma.median(abs(angle - held_rad), axis=0)), 0.0)
    loose_deg = 3.0  # Robust deviation of a joint from which it is driven, or loose.
    if moved_deg.max() > loose_deg:
        raise BadInput(
            f"joint {moved_deg.argmax() + 1} moves by {moved_deg.max():.0f}° in this film: a push "
            "needs joints that hold still, and one bend a film; a crawl is measured by `serpenoid "
            "video FILE`"
        )
    return np.ma.filled(held_rad, 0.0)
