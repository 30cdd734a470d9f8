"""A page of one file that shows a snake crawling: a run, or a recording beside its twin."""

from __future__ import annotations

import html
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from .plot import along_travel

if TYPE_CHECKING:
    from ..robot.recording.stream import Stream
    from ..simulation.run import Run

Array = NDArray[np.float64]
FRAMES_A_SECOND, MOST_FRAMES = 50, 3000
STUCK_M_S = 1e-4  # slower than this a wheel on dry ground is shown as one that sticks
_STATE = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s")


def write_page(path: Path, title: str, about: str, shown: dict[str, Any]) -> None:
    """Write the page: it needs no other file and no network."""
    text = Path(__file__).with_name("view.html").read_text(encoding="utf-8")
    data = json.dumps(shown, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    for mark, value in (("TITLE", html.escape(title)), ("ABOUT", html.escape(about))):
        text = text.replace(f"@{mark}@", value)
    path.write_text(text.replace("@DATA@", data), encoding="utf-8")


def of_run(run: Run) -> dict[str, Any]:
    """Return what the page shows of a run: at most MOST_FRAMES times, evenly spaced."""
    duration = float(run.t_s[-1])
    count = max(2, min(MOST_FRAMES, run.t_s.size, math.ceil(duration * FRAMES_A_SECOND) + 1))
    return _shown(run, np.linspace(0.0, duration, count))


def of_recording(stream: Stream, robot: Robot, ground: Ground) -> tuple[Gait, dict[str, Any]]:
    """Return the recorded gait, and its set-points laid on what the model predicts of that gait.

    The twin is in the gait's periodic state from the start, at the phase that the board told.
    Raises BadInput for a recording without a gait, or of a robot of other links.
    """
    gait = recorded_gait(stream)
    kept = np.flatnonzero(stream.state == "gait")
    if kept.size < 2:
        raise BadInput("the recording holds no frames of a gait; drive one with --record")
    links = stream.setpoint_rad.shape[1] + 1
    if robot.links != links:
        raise BadInput(f"links is {robot.links}; the recording is of a robot of {links}")
    kept = kept[:: math.ceil(kept.size / MOST_FRAMES)]
    t_twin = np.unwrap(stream.phase_rad[kept]) / gait.omega_rad_s
    run = along_travel(simulate(twin(robot, ground, gait, float(t_twin[-1]))))
    shown = _shown(run, t_twin)
    board_s = stream.board_s[kept]
    shown["t_s"] = _rounded(board_s - board_s[0])
    return gait, shown | _set_points(run, t_twin, stream.setpoint_rad[kept])


def recorded_gait(stream: Stream) -> Gait:
    """Return the last gait that was sent to the board; raise BadInput if none was."""
    for _, line in reversed(stream.sent):
        words = line.partition("*")[0].split()
        if "gait" in words:
            numbers = [float(word) for word in words[words.index("gait") + 1 :]]
            alpha, beta, omega, offset = [*numbers, 0.0][:4]
            return Gait(math.radians(alpha), math.radians(beta), omega, math.radians(offset))
    raise BadInput("no gait was sent in this recording; drive one with --record")


def twin(robot: Robot, ground: Ground, gait: Gait, duration_s: float) -> Scene:
    """Return the scene of a gait in its periodic state, recorded finely enough to be drawn."""
    return Scene(
        robot, ground, gait, start="steady", dt_s=gait.period_s / 400, record_every=2,
        method="nonsmooth" if ground.dry else "rk4", duration_s=max(duration_s, gait.period_s / 50),
    )  # fmt: skip


def _shown(run: Run, t_s: Array) -> dict[str, Any]:
    x, y, theta, vx, vy = (_at(run, t_s, getattr(run, name)) for name in _STATE)
    slip = vy * np.cos(theta) - vx * np.sin(theta)
    dry = run.scene.ground.fn0 > 0
    return {
        "t_s": _rounded(t_s),
        "x_m": _rounded(x),
        "y_m": _rounded(y),
        "theta_rad": _rounded(theta),
        "slip_m_s": _rounded(slip),
        "most_slip_m_s": float(np.abs(slip).max()),
        "stuck": (dry & (np.abs(slip) < STUCK_M_S)).astype(int).tolist(),
        "joint_deg": _rounded(np.degrees(np.diff(theta, axis=1))),
        "link_length_m": run.scene.robot.link_length_m,
        "period_s": run.scene.gait.period_s,
        "dry": bool(dry),
    }


def _set_points(run: Run, t_s: Array, setpoint_rad: Array) -> dict[str, Any]:
    """Lay a chain with these joint angles on the model's centre of mass and mean heading."""
    theta = np.concatenate([np.zeros((t_s.size, 1)), np.cumsum(setpoint_rad, axis=1)], axis=1)
    theta += (_at(run, t_s, run.theta_rad) - theta).mean(axis=1, keepdims=True)
    half = run.scene.robot.link_length_m / 2
    centre = _at(run, t_s, run.centre_m)
    placed = {}
    for axis, (name, along) in enumerate((("set_x_m", np.cos(theta)), ("set_y_m", np.sin(theta)))):
        ends = half * (along[:, :-1] + along[:, 1:])
        place = np.concatenate([np.zeros((t_s.size, 1)), np.cumsum(ends, axis=1)], axis=1)
        placed[name] = _rounded(place + (centre[:, axis] - place.mean(axis=1))[:, None])
    degrees = _rounded(np.degrees(setpoint_rad))
    return placed | {"set_theta_rad": _rounded(theta), "set_joint_deg": degrees}


def _at(run: Run, t_s: Array, values: Array) -> Array:
    return np.stack([np.interp(t_s, run.t_s, column) for column in values.T], axis=1)


def _rounded(values: Array) -> Any:
    return np.round(values, 5).tolist()
