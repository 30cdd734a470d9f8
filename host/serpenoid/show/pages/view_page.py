"""Write a page that animates the snake, of a run or of a recording, in one file."""

from __future__ import annotations

import html
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import BadInput
from ...base.files import write_text
from ...base.rows import two_digits
from ...base.vectors import Array
from ...lab.floor import Floor
from ...lab.robot import LabRobot
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...robot.recording.run_gait import longest_gait
from ...robot.recording.stream import Stream
from ...simulation.run import Run
from ...video.fitting.chain import link_centres

MAX_FRAMES = 3000  # Most frames of a page: one minute at 50 Hz.


def write_page(path: Path, title: str, about: str, shown: dict[str, Any]) -> None:
    """Write the page, which needs no other file and no network.

    about: a line below the title. shown: the data, as of `of_run`.
    """
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
    """Return the data of the page for a run: at most MAX_FRAMES of its rows, evenly spaced."""
    count = min(MAX_FRAMES, run.t_s.size, 2 + int(50 * run.t_s[-1]))
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
    """Return the gait of a recording, and the data of the page.

    The data are the motion of a model whose joints follow the recorded set-points, interpolated
    over lost frames. It is rotated so that its end lies on the x axis. Raises BadInput if the
    recording has no gait, or the robot another number of links.
    """
    gait, links = longest_gait(stream), stream.setpoint_rad.shape[1] + 1
    if robot.links != links:
        raise BadInput(
            f"links is {robot.links}; this is of a robot of {links}: give --set links={links}"
        )
    in_gait = np.flatnonzero(stream.state == "gait")
    gait_rows, frame_s = slice(in_gait[0], in_gait[-1] + 1), 0.02
    board_s = stream.board_s[gait_rows] - stream.board_s[in_gait[0]]
    t_s = np.arange(0.0, board_s[-1], frame_s)
    setpoints_rad = [np.interp(t_s, board_s, angle) for angle in stream.setpoint_rad[gait_rows].T]
    body = LabRobot(robot, (ground,))
    track, joint_rad = Floor(body).follow(np.transpose(setpoints_rad), frame_s)
    x_m, y_m = track.x_m - track.x_m[0], track.y_m - track.y_m[0]
    travel_rad = np.arctan2(y_m[-1], x_m[-1])
    centre = np.exp(-1j * travel_rad) * (x_m + 1j * y_m)
    bend = np.cumsum(np.insert(joint_rad, 0, track.heading_rad - travel_rad, axis=1), axis=1)
    theta = bend + bend[:, :1] - bend.mean(axis=1, keepdims=True)
    states = np.column_stack([centre.real, centre.imag, theta])
    centres = link_centres(states, robot.link_length_m) @ [1, 1j]
    # Mean slip velocity of each frame, across the mean direction of the link.
    directions = np.exp(-0.5j * (theta[1:] + theta[:-1]))
    slip_m_s = (directions * np.diff(centres, axis=0)).imag / frame_s
    shown = t_s, centres.real, centres.imag, theta, np.insert(slip_m_s, 0, 0.0, axis=0)
    stride = math.ceil(len(t_s) / MAX_FRAMES)
    t_s, *motion = (values[::stride] for values in shown)
    return gait, _shown(t_s, robot, ground, gait, *motion)


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
    """Return the data of the page at N times.

    x_m, y_m, theta_rad, slip_m_s: (N, links), the links' centres and angles, and their wheels' slip
    velocity across.
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
        # Size of the box that contains every posture, with a margin.
        "extent_m": [1.6 * robot.link_length_m + np.ptp(p, axis=1).max() for p in (x_m, y_m)],
        "dry": bool(ground.fn0 > 0),
        # Numbers are rounded to 10 µm and 10 µrad.
        **{name: np.round(values, 5).tolist() for name, values in tables.items()},
    }
