"""The option --joints: what the joints really do, as a session's latest film showed it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .declare import option
from .paths import FOLDER

if TYPE_CHECKING:
    from ..calibration.kinds.video import FilmReading
    from ..model.gait import Gait

_SAME_RAD, _SAME_RATE = 1e-3, 0.01
joints_option = option(
    "--joints",
    "Session with a film: its joints' gains and phases, in place of the commanded ones.",
    type=FOLDER,
    metavar="SESSION",
)


def latest_film(session: Path, links: int) -> FilmReading:
    """Return the latest film of a session. Raises BadInput: none, or of another robot."""
    from ..calibration.session_file import read_session
    from ..model.errors import BadInput

    films = read_session(session).kept_films
    if not films:
        raise BadInput(
            f"{session}: holds no film; measure one with `serpenoid video FILE --session {session}`"
        )
    joints = len(films[-1].gait.joint_gain)
    if joints != links - 1:
        raise BadInput(f"{session}: its film shows {joints} joints; the robot has {links - 1}")
    return films[-1]


def with_joints(gait: Gait, session: Path | None, links: int) -> Gait:
    """Return the gait as a session's film says that the joints make it."""
    if session is None:
        return gait
    seen = latest_film(session, links).gait
    return replace(gait, joint_gain=seen.joint_gain, joint_shift_rad=seen.joint_shift_rad)


def was_filmed(gait: Gait, session: Path, links: int) -> bool:
    """Tell whether a session's latest film shows this commanded gait; its board's clock errs."""
    seen = latest_film(session, links).commanded
    apart = abs(seen.alpha_rad - gait.alpha_rad), abs(seen.beta_rad - gait.beta_rad)
    return max(apart) < _SAME_RAD and abs(seen.omega_rad_s / gait.omega_rad_s - 1.0) < _SAME_RATE
