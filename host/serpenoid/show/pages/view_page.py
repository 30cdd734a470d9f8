"""A page that shows a snake crawling, a run or the twin of a recording, in one file."""

from __future__ import annotations

import html
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.errors import BadInput
from ...base.files import write_text
from ...base.rows import two_digits
from ...model.gait import Gait, joint_motion
from ...model.ground import Ground
from ...model.robot import Robot
from ...robot.recording.run_gait import longest_gait
from ...robot.recording.stream import Stream
from ...simulation.run import Run
from .twin import Motion, Twin

Array = NDArray[np.float64]
FRAMES_A_SECOND, MOST_FRAMES = 50, 3000
STUCK_M_S = 1e-4  # slower than this a wheel on dry ground is shown as one that sticks


def write_page(path: Path, title: str, about: str, shown: dict[str, Any]) -> None:
    """Write the page: it needs no other file and no network."""
    text = Path(__file__).with_name("view.html").read_text(encoding="utf-8")
    data = json.dumps(shown, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    slip = two_digits(shown["most_slip_m_s"])
    wheels = [
        _key("bar", "rolls", "wheel rolls straight"),
        _key("bar", "slides", f"slides sideways at {slip} m/s"),
        _key("bar", "stuck", "grips (framed)") if shown["dry"] else "",
        _key("line", "path", "path of the centre of mass"),
    ]
    joints = range(min(8, len(shown["joint_deg"][0])))
    curves = [_key("line", f"j{j % 7}", f"{j + 1}{'' if j else ' (tail)'}") for j in joints]
    if "asked_deg" in shown:
        curves.append(_key("dashed", "soft", "dashed: the gait asked for; the robot ramps into it"))
    marks = {
        "TITLE": html.escape(title),
        "ABOUT": html.escape(about),
        "KEY": "".join(wheels),
        "JOINTS": "".join(curves),
        "DATA": data,
    }
    for mark, value in marks.items():
        text = text.replace(f"@{mark}@", value)
    write_text(path, text)


def _key(kind: str, colour: str, words: str) -> str:
    """Return one entry of a key: a bar, a line or dashes in a colour of the page, and words."""
    return f'<span><i class="{kind}" style="color:var(--{colour})"></i>{words}</span>'


def of_run(run: Run) -> dict[str, Any]:
    """Return what the page shows of a run: at most MOST_FRAMES times, evenly spaced."""
    duration = float(run.t_s[-1])
    count = max(2, min(MOST_FRAMES, run.t_s.size, math.ceil(duration * FRAMES_A_SECOND) + 1))
    t_s = np.linspace(0.0, duration, count)
    tables = (run.x_m, run.y_m, run.theta_rad, run.vx_m_s, run.vy_m_s)
    motion = Motion(*(_columns(t_s, run.t_s, table) for table in tables))
    s = run.scene
    slope = {"uphill_rad": s.incline_direction_rad} if s.incline_rad else {}
    sizes = constants(s.robot, s.ground, s.gait, motion)
    return {"t_s": rounded(t_s)} | sizes | slope | rows(s.ground, motion)


def of_recording(stream: Stream, robot: Robot, ground: Ground) -> tuple[Gait, dict[str, Any]]:
    """Return the recorded gait, and how a twin moves whose joints follow the recorded set-points.

    Where frames did not arrive the joints go straight to the next set-points.
    Raises BadInput for a recording without a gait, or of a robot of other links.
    """
    gait = longest_gait(stream)
    kept = np.flatnonzero(stream.state == "gait")
    links = stream.setpoint_rad.shape[1] + 1
    if robot.links != links:
        raise BadInput(f"links is {robot.links}; what is shown is of a robot of {links}")
    kept = np.arange(kept[0], kept[-1] + 1)
    setpoint_rad, board_s = stream.setpoint_rad[kept], stream.board_s[kept]
    twin = Twin(robot, ground, setpoint_rad[0])
    every = math.ceil(kept.size / MOST_FRAMES)
    motion = twin.follow(setpoint_rad[1:], np.diff(board_s), every).along_x()
    t_s, phase = board_s[1::every] - board_s[0], stream.phase_rad[kept][1::every]
    asked = joint_motion(gait, robot.links - 1, phase / gait.omega_rad_s).angle_rad
    return gait, (
        {"t_s": rounded(t_s), "asked_deg": rounded(np.degrees(asked))}
        | constants(robot, ground, gait, motion)
        | rows(ground, motion)
    )


def constants(robot: Robot, ground: Ground, gait: Gait, motion: Motion) -> dict[str, Any]:
    """Return what the page needs once: sizes, and the fastest slip."""
    return {
        "most_slip_m_s": float(np.abs(motion.slip_m_s).max()),
        "link_length_m": robot.link_length_m,
        "period_s": gait.period_s,
        "dry": bool(ground.fn0 > 0),
    }


def rows(ground: Ground, motion: Motion) -> dict[str, Any]:
    """Return what the page draws of the model at each moment."""
    slip = motion.slip_m_s
    stuck = (ground.fn0 > 0) & (np.abs(slip) < STUCK_M_S)
    return {
        "x_m": rounded(motion.x_m),
        "y_m": rounded(motion.y_m),
        "theta_rad": rounded(motion.theta_rad),
        "slip_m_s": rounded(slip),
        "stuck": stuck.astype(int).tolist(),
        "joint_deg": rounded(np.degrees(np.diff(motion.theta_rad, axis=1))),
    }


def rounded(values: Array) -> Any:
    """Return numbers as the page holds them, to 10 µm and 10 µrad."""
    return np.round(values, 5).tolist()


def _columns(at: Array, x: Array, values: Array) -> Array:
    """Interpolate each column (N, m), given at x (N,), at other places."""
    return np.stack([np.interp(at, x, column) for column in values.T], axis=1)
