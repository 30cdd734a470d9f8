"""A page that shows a snake crawling, a run or the model of a recorded robot, in one file."""

from __future__ import annotations

import html
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.errors import BadInput, NotConverged
from ...base.files import write_text
from ...base.rows import two_digits
from ...lab.robot import LabRobot
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...robot.recording.run_gait import longest_gait
from ...robot.recording.stream import Stream
from ...simulation.run import Run
from ...video.fitting.chain import lever_matrix

Array = NDArray[np.float64]
MOST_FRAMES = 3000  # Rows that a page holds: a minute of 50 a second.


def write_page(path: Path, title: str, about: str, shown: dict[str, Any]) -> None:
    """Write the page: it needs no other file and no network."""
    text, snake = (
        Path(__file__).with_name(name).read_text(encoding="utf-8")
        for name in ("view.html", "snake.js")
    )
    data = json.dumps(shown, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    marks = {
        "TITLE": html.escape(title),
        "ABOUT": html.escape(about),
        "SLIP": two_digits(shown["most_slip_m_s"]),
        "SNAKE": snake,
        "DATA": data,
    }
    for mark, value in marks.items():
        text = text.replace(f"@{mark}@", value)
    write_text(path, text)


def of_run(run: Run) -> dict[str, Any]:
    """Return what the page shows of a run: at most MOST_FRAMES of its rows, evenly spaced."""
    count = min(MOST_FRAMES, run.t_s.size, 2 + int(50 * run.t_s[-1]))
    rows = np.linspace(0, run.t_s.size - 1, count).astype(int)
    x_m, y_m, theta, vx, vy = (
        table[rows] for table in (run.x_m, run.y_m, run.theta_rad, run.vx_m_s, run.vy_m_s)
    )
    slip_m_s = vy * np.cos(theta) - vx * np.sin(theta)
    scene = run.scene
    body = scene.robot, scene.ground, scene.gait
    shown = _shown(run.t_s[rows], *body, x_m, y_m, theta, slip_m_s)
    return shown | ({"uphill_rad": scene.incline_direction_rad} if scene.incline_rad else {})


def of_recording(stream: Stream, robot: Robot, ground: Ground) -> tuple[Gait, dict[str, Any]]:
    """Return the recorded gait, and how a model moves whose joints follow the recorded set-points.

    Where frames did not arrive the joints go straight to the next set-points.
    Raises BadInput for a recording without a gait, or of a robot of other links.
    """
    gait, links = longest_gait(stream), stream.setpoint_rad.shape[1] + 1
    if robot.links != links:
        raise BadInput(
            f"links is {robot.links}; this is of a robot of {links}: give --set links={links}"
        )
    in_gait = np.flatnonzero(stream.state == "gait")
    gait_rows = slice(in_gait[0], in_gait[-1] + 1)
    board_s = stream.board_s[gait_rows]
    stride = math.ceil(len(board_s) / MOST_FRAMES)
    motion = follow(robot, ground, stream.setpoint_rad[gait_rows], np.diff(board_s), stride)
    return gait, _shown(board_s[1::stride] - board_s[0], robot, ground, gait, *motion)


def follow(
    robot: Robot, ground: Ground, setpoint_rad: Array, lasts_s: Array, stride: int = 1
) -> list[Array]:
    """Return how a robot with ideal joints moves that is led through set-points, (N + 1, n - 1).

    It is at rest at the first, and goes to each next one within a time, (N,). stride: of so many
    moments the first counts. The way from start to end lies along x.
    """
    chain = LabRobot(robot, (ground,)).chain()
    rows = np.ascontiguousarray(setpoint_rad, dtype=np.float64)
    chain.set_joints(rows[0].tolist())
    chain.place(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    lasts_s = np.clip(lasts_s, 1e-3, 10.0)  # Nobody knows what a longer gap holds.
    states = []
    for k, duration_s in enumerate(lasts_s.tolist()):
        if not len(chain.follow(rows[k + 1 : k + 2], duration_s, 0.002)):
            raise NotConverged("the model came to no answer; are robot and friction sensible?")
        if k % stride == 0:
            states.append(chain.state[:6])
    rate = (np.diff(rows, axis=0) / lasts_s[:, None])[::stride]
    return _motion(robot, np.array(states), rows[1::stride], rate)


def _motion(robot: Robot, states: Array, joint_rad: Array, joint_rad_s: Array) -> list[Array]:
    """Return all links from centre of mass and link 1, (N, 6), and the joints, (N, n-1)."""
    x, y, theta, vx, vy, turning = np.split(states, 6, axis=1)
    angle = np.cumsum(np.hstack([theta, joint_rad]), axis=1)
    rate = np.cumsum(np.hstack([turning, joint_rad_s]), axis=1)
    levers = robot.link_length_m * lever_matrix(robot.links).T
    c, s = np.cos(angle), np.sin(angle)
    slip = (vy + c * rate @ levers) * c - (vx - s * rate @ levers) * s
    way = np.arctan2(y[-1] - y[0], x[-1] - x[0])
    place = np.exp(-1j * way) * (x + c @ levers + 1j * (y + s @ levers))
    return [place.real, place.imag, angle - way, slip]


def _shown(
    t_s: Array,
    robot: Robot,
    ground: Ground,
    gait: Gait,
    x_m: Array,
    y_m: Array,
    theta_rad: Array,
    slip_m_s: Array,
) -> dict[str, Any]:
    """Return what the page draws at N moments.

    (N, n) each: centres of the links, their angles, and their wheels' slip.
    """
    tables = {
        "t_s": t_s,
        "x_m": x_m,
        "y_m": y_m,
        "theta_rad": theta_rad,
        "slip_m_s": slip_m_s,
        "joint_deg": np.degrees(np.diff(theta_rad, axis=1)),
    }
    return {
        "most_slip_m_s": float(np.abs(slip_m_s).max()),
        "link_length_m": robot.link_length_m,
        "period_s": gait.period_s,
        "dry": bool(ground.fn0 > 0),
        # To 10 µm and 10 µrad.
        **{name: np.round(values, 5).tolist() for name, values in tables.items()},
    }
