"""A page of one file that shows a snake crawling: a run, or a recording beside its twin."""

from __future__ import annotations

import html
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...model.errors import BadInput
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ..whole_file import whole_file
from .twin import Motion, Twin

if TYPE_CHECKING:
    from ...robot.recording.stream import Stream
    from ...simulation.run import Run
    from ...simulation.scene import Scene

Array = NDArray[np.float64]
FRAMES_A_SECOND, MOST_FRAMES = 50, 3000
STUCK_M_S = 1e-4  # slower than this a wheel on dry ground is shown as one that sticks


def write_page(path: Path, title: str, about: str, shown: dict[str, Any]) -> None:
    """Write the page: it needs no other file and no network."""
    with whole_file(path) as part:
        part.write_text(page_text(title, about, shown).replace("@NONCE@", ""), encoding="utf-8")


def page_text(title: str, about: str, shown: dict[str, Any]) -> str:
    """Return the page, the nonce of its scripts still to be filled in."""
    text = Path(__file__).with_name("view.html").read_text(encoding="utf-8")
    data = json.dumps(shown, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    for mark, value in (("TITLE", html.escape(title)), ("ABOUT", html.escape(about))):
        text = text.replace(f"@{mark}@", value)
    return text.replace("@DATA@", data)


def of_run(run: Run) -> dict[str, Any]:
    """Return what the page shows of a run: at most MOST_FRAMES times, evenly spaced."""
    duration = float(run.t_s[-1])
    count = max(2, min(MOST_FRAMES, run.t_s.size, math.ceil(duration * FRAMES_A_SECOND) + 1))
    t_s = np.linspace(0.0, duration, count)
    tables = (run.x_m, run.y_m, run.theta_rad, run.vx_m_s, run.vy_m_s)
    motion = Motion(*(_at(run, t_s, table) for table in tables))
    return {"t_s": rounded(t_s)} | constants(run.scene, motion) | rows(run.scene, motion)


def of_recording(stream: Stream, robot: Robot, ground: Ground) -> tuple[Gait, dict[str, Any]]:
    """Return the recorded gait, and its set-points laid on what the model predicts of that gait.

    The twin is in the gait's periodic state from the start, at the phase that the board told.
    Raises BadInput for a recording without a gait, or of a robot of other links.
    """
    gait = recorded_gait(stream)
    kept = np.flatnonzero(stream.state == "gait")
    if kept.size < 2:
        raise BadInput("the recording holds no frames of a gait; drive one with --record")
    check_links(robot, stream.setpoint_rad.shape[1] + 1)
    kept = kept[:: math.ceil(kept.size / MOST_FRAMES)]
    twin = Twin(robot, ground, gait)
    motion = twin.at(np.unwrap(stream.phase_rad[kept]))
    board_s = stream.board_s[kept]
    shown = {"t_s": rounded(board_s - board_s[0])} | constants(twin.scene, motion)
    shown |= rows(twin.scene, motion)
    return gait, shown | set_points(robot, motion, stream.setpoint_rad[kept])


def check_links(robot: Robot, links: int) -> None:
    """Refuse a twin of other links than the robot that is driven."""
    if robot.links != links:
        raise BadInput(f"links is {robot.links}; what is shown is of a robot of {links}")


def recorded_gait(stream: Stream) -> Gait:
    """Return the last gait that was sent to the board; raise BadInput if none was."""
    for _, line in reversed(stream.sent):
        words = line.partition("*")[0].split()
        if "gait" in words:
            numbers = [float(word) for word in words[words.index("gait") + 1 :]]
            alpha, beta, omega, offset = [*numbers, 0.0][:4]
            return Gait(math.radians(alpha), math.radians(beta), omega, math.radians(offset))
    raise BadInput("no gait was sent in this recording; drive one with --record")


def constants(scene: Scene, motion: Motion) -> dict[str, Any]:
    """Return what the page needs once: sizes, and the fastest slip."""
    return {
        "most_slip_m_s": float(np.abs(motion.slip_m_s).max()),
        "link_length_m": scene.robot.link_length_m,
        "period_s": scene.gait.period_s,
        "dry": bool(scene.ground.fn0 > 0),
    } | ({"uphill_rad": scene.incline_direction_rad} if scene.incline_rad else {})


def rows(scene: Scene, motion: Motion) -> dict[str, Any]:
    """Return what the page draws of the model at each moment."""
    slip = motion.slip_m_s
    stuck = (scene.ground.fn0 > 0) & (np.abs(slip) < STUCK_M_S)
    return {
        "x_m": rounded(motion.x_m),
        "y_m": rounded(motion.y_m),
        "theta_rad": rounded(motion.theta_rad),
        "slip_m_s": rounded(slip),
        "stuck": stuck.astype(int).tolist(),
        "joint_deg": rounded(np.degrees(np.diff(motion.theta_rad, axis=1))),
    }


def set_points(robot: Robot, motion: Motion, setpoint_rad: Array) -> dict[str, Any]:
    """Lay a chain with these joint angles on the model's centre of mass and mean heading."""
    theta = np.cumsum(np.pad(setpoint_rad, ((0, 0), (1, 0))), axis=1)
    theta += (motion.theta_rad - theta).mean(axis=1, keepdims=True)
    placed = {}
    for name, along, centres in (
        ("set_x_m", np.cos(theta), motion.x_m),
        ("set_y_m", np.sin(theta), motion.y_m),
    ):
        ends = robot.link_length_m / 2 * (along[:, :-1] + along[:, 1:])
        place = np.cumsum(np.pad(ends, ((0, 0), (1, 0))), axis=1)
        placed[name] = rounded(place + (centres - place).mean(axis=1, keepdims=True))
    degrees = rounded(np.degrees(setpoint_rad))
    return placed | {"set_theta_rad": rounded(theta), "set_joint_deg": degrees}


def rounded(values: Array) -> Any:
    """Return numbers as the page holds them, to 10 µm and 10 µrad."""
    return np.round(values, 5).tolist()


def _at(run: Run, t_s: Array, values: Array) -> Array:
    return np.stack([np.interp(t_s, run.t_s, column) for column in values.T], axis=1)
