"""The page beside a robot that is driven: its telemetry as it comes, over its predicted twin."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...robot.wire.protocol import frame_us
from ..plot import gait_title
from .server import Page
from .twin import Motion, Twin, gait_joints
from .view_page import constants, page_text, rounded, rows

if TYPE_CHECKING:
    from ...robot.tools.driven_run import DrivenRun
    from ...robot.wire.protocol import Telemetry

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
        shown |= constants(robot, ground, gait, _two_periods(robot, ground, gait))
        shown |= rows(ground, Twin(robot, ground, straight).now())
        told = f"predicted for the {whose} from the set-points that the robot tells"
        about = f"{gait_title(gait)}; {told}"
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
        told = f"{frame.state}; {run.frames} frames, {losses.missed_frames} missed"
        if run.clipped_frames:
            told += f"; {run.clipped_frames} clipped: the robot misses its gait"
        phase, joints = np.array([frame.phase_rad]), self._robot.links - 1
        asked = np.degrees(gait_joints(run.gait, phase, joints))
        shown = rows(self._ground, motion) | {"asked_deg": rounded(asked)}
        return {
            "told": told,
            "t_s": rounded(np.array([run.elapsed_s]))[0],
            "row": {name: table[0] for name, table in shown.items()},
        }


def _two_periods(robot: Robot, ground: Ground, gait: Gait) -> Motion:
    """Return a settling twin's motion, from which the page takes the fastest slip."""
    phase = np.linspace(0.0, 4 * math.pi, 101)
    told = gait_joints(gait, phase, robot.links - 1)
    return Twin(robot, ground, told[0]).follow(told[1:], np.full(100, gait.period_s / 50))
