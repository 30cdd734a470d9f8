"""Pages that show a snake crawling: a run or the twin of a recording, in one file; a robot live.

Beside a robot that is driven its telemetry comes as it is told, over its predicted twin.
"""

from __future__ import annotations

import html
import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.errors import BadInput
from ...model.files import write_text
from ...model.gait import Gait, joint_motion
from ...model.ground import Ground
from ...model.robot import Robot
from ...model.rows import two_digits
from ...robot.recording.run_gait import longest_gait
from ...robot.recording.stream import Stream
from ...robot.tools.driven_run import DrivenRun
from ...robot.wire.protocol import Telemetry, frame_us
from ...simulation.run import Run
from ..plot import gait_title
from . import filled
from .server import Page
from .twin import Motion, Twin

Array = NDArray[np.float64]
FRAMES_A_SECOND, MOST_FRAMES = 50, 3000
STUCK_M_S = 1e-4  # slower than this a wheel on dry ground is shown as one that sticks


def write_page(path: Path, title: str, about: str, shown: dict[str, Any]) -> None:
    """Write the page: it needs no other file and no network."""
    write_text(path, page_text(title, about, shown).replace("@NONCE@", ""))


def page_text(title: str, about: str, shown: dict[str, Any]) -> str:
    """Return the page, the nonce of its scripts still to be filled in."""
    text = filled("@PAGE@", PAGE="view.html", STYLE="page.css", LIVE="live.js")
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
    return text


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
    check_links(robot, stream.setpoint_rad.shape[1] + 1)
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


def check_links(robot: Robot, links: int) -> None:
    """Refuse a twin of other links than the robot that is driven."""
    if robot.links != links:
        raise BadInput(f"links is {robot.links}; what is shown is of a robot of {links}")


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


EVERY_S = 1 / 30  # between two states that are sent to the page


class LivePage:
    """Serve a run while it is driven: `with LivePage(...) as page:`, page.show after every frame.

    The twin's joints follow the set-points that the board tells, from the first frame on.
    """

    def __init__(self, run: DrivenRun, robot: Robot, ground: Ground, whose: str):
        self._run, self._robot, self._ground = run, robot, ground
        self._twin: Twin | None = None
        self._last: Telemetry | None = None
        self._shown_s = 0.0
        gait, joints = run.gait, robot.links - 1
        straight = np.zeros(joints)
        shown = {"t_s": [0.0], "live": True, "asked_deg": [straight.tolist()]}
        # the fastest slip is that of a twin that settles for two periods
        led = joint_motion(gait, joints, np.linspace(0.0, 2 * gait.period_s, 101)).angle_rad
        lasts_s = np.full(100, gait.period_s / 50)
        settling = Twin(robot, ground, led[0]).follow(led[1:], lasts_s)
        shown |= constants(robot, ground, gait, settling)
        shown |= rows(ground, Twin(robot, ground, straight).now())
        label = f"predicted for the {whose} from the set-points that the robot tells"
        about = f"{gait_title(gait)}; {label}"
        self._page = Page(page_text("the robot, live", about, shown), self._stop)
        self.url = self._page.url

    def __enter__(self) -> LivePage:
        self._page.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        kind = error[0]
        ended = "the run has ended" if kind is None else "the run was ended by an error or Ctrl-C"
        self._page.publish({"ended": "stopped from here" if self._run.halted else ended})
        self._page.__exit__(*error)

    def show(self, run: DrivenRun) -> None:
        """Send the latest frame, thirty a second at most."""
        frame = run.last
        assert frame is not None  # shown after a frame
        motion = self._follow(frame)
        if time.monotonic() - self._shown_s >= EVERY_S:
            self._shown_s = time.monotonic()
            self._page.publish(self._state(frame, motion))

    def _stop(self) -> None:
        """Stop the robot for the page; the run that is watched ends."""
        self._run.halt()

    def _follow(self, frame: Telemetry) -> Motion:
        """Lead the twin to a frame's set-points, in the time since the frame before."""
        told, last = np.array([frame.setpoint_rad]), self._last
        self._last = frame
        if self._twin is None or last is None or frame.frame <= last.frame:
            self._twin = Twin(self._robot, self._ground, told[0])
            return self._twin.now()
        lasts_s = 1e-6 * frame_us(len(frame.setpoint_rad)) * (frame.frame - last.frame)
        return self._twin.follow(told, np.array([lasts_s]))

    def _state(self, frame: Telemetry, motion: Motion) -> dict[str, Any]:
        run, losses = self._run, self._run.robot.losses
        label = f"{frame.state}; {run.frames} frames, {losses.missed_frames} missed"
        if run.clipped_frames:
            label += f"; {run.clipped_frames} clipped: the robot misses its gait"
        t_s = frame.phase_rad / run.gait.omega_rad_s
        asked = joint_motion(run.gait, self._robot.links - 1, [t_s]).angle_rad
        shown = rows(self._ground, motion) | {"asked_deg": rounded(np.degrees(asked))}
        return {
            "told": label,
            "t_s": rounded(np.array([run.elapsed_s]))[0],
            "row": {name: table[0] for name, table in shown.items()},
        }
