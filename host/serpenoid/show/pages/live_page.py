"""The page beside a robot that is driven: its telemetry as it comes, over its predicted twin."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from ...model.ground import Ground
from ...model.robot import Robot
from .server import Page
from .twin import Twin
from .view_page import constants, page_text, rounded, rows, set_points

if TYPE_CHECKING:
    from ...robot.tools.driven_run import DrivenRun
    from ...robot.wire.protocol import Telemetry

EVERY_S = 1 / 30  # between two states that are sent to the page


class LivePage:
    """Serve a run while it is driven: `with LivePage(...) as page:`, page.show after every frame.

    The twin is the gait's periodic state at the phase that the board tells; the board's ramp from
    rest is not in it.
    """

    def __init__(self, run: DrivenRun, robot: Robot, ground: Ground, whose: str):
        self._run, self._twin = run, Twin(robot, ground, run.gait)
        self._phase_rad: float | None = None
        self._shown_s = 0.0
        cycle = self._twin.at(np.linspace(0.0, 2 * math.pi, 100))
        start = self._twin.at(np.zeros(1))
        straight = np.zeros((1, robot.links - 1))
        shown = {"t_s": [0.0], "live": True} | constants(self._twin.scene, cycle)
        shown |= rows(self._twin.scene, start) | set_points(robot, start, straight)
        gait = run.gait
        about = (
            f"α = {math.degrees(gait.alpha_rad):.3g}°, β = {math.degrees(gait.beta_rad):.3g}°, "
            f"ω = {gait.omega_rad_s:.3g} rad/s; the path is predicted for the {whose}, the "
            "set-points are the robot's own telemetry"
        )
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
        self._count(frame)
        if time.monotonic() - self._shown_s >= EVERY_S:
            self._shown_s = time.monotonic()
            self._page.publish(self._state(frame))

    def _stop(self) -> None:
        """Stop the robot for the page; the run that is watched ends."""
        self._run.halt()

    def _count(self, frame: Telemetry) -> None:
        """Count the phase on over the cycles."""
        last = frame.phase_rad if self._phase_rad is None else self._phase_rad
        on = math.remainder(frame.phase_rad - last, 2 * math.pi)
        self._phase_rad = last + on

    def _state(self, frame: Telemetry) -> dict[str, Any]:
        run, losses = self._run, self._run.robot.losses
        told = f"{frame.state}; {run.frames} frames, {losses.missed_frames} missed"
        if run.clipped_frames:
            told += f"; {run.clipped_frames} clipped: the robot misses its gait"
        motion = self._twin.at(np.array([self._phase_rad]))
        shown = rows(self._twin.scene, motion) | set_points(
            self._twin.scene.robot, motion, np.array([frame.setpoint_rad])
        )
        return {
            "told": told,
            "t_s": rounded(np.array([run.elapsed_s]))[0],
            "row": {name: table[0] for name, table in shown.items()},
        }
