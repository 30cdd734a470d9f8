"""Drive one gait on a robot, watch every frame, and summarise the run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import FramesMissing
from ..robot import RobotBoard
from ..wire.inbox import Losses
from ..wire.protocol import Telemetry

if TYPE_CHECKING:
    from ...model.gait import Gait


@dataclass(kw_only=True)
class Summary(Losses):
    """The summary of a run, with its losses of data.

    duration_s: the board's time from the first frame to the last. frames: number of received
    frames. latest_us: largest delay of a frame. clipped_frames: number of frames in which a limit
    of a joint or of the servos' speed held a joint back from the gait. drift_ppm, drift_sd_ppm:
    drift of the board's clock against this computer's, and its standard deviation. frequency_hz,
    frequency_sd_hz: frequency of the settled gait in this computer's seconds, and its standard
    deviation; None if the board's clock is implausible. recording: its file, None without one.
    """

    board: str
    firmware: str
    duration_s: float
    frames: int
    latest_us: int
    clipped_frames: int
    drift_ppm: float
    drift_sd_ppm: float
    frequency_hz: float | None
    frequency_sd_hz: float | None
    recording: str | None


class DrivenRun:
    """One gait on one robot: run() drives it, and summary() works even if run() has raised.

    port: as of RobotBoard. record: file of the recording, None for none. joints: number of joints
    that the robot must have, None for any.
    """

    def __init__(self, gait: Gait, port: str | None, record: Path | None, joints: int | None):
        self.gait = gait
        # The robot stops if a call of watch takes longer than 2 s, as on a halted terminal.
        self.robot = RobotBoard(port, joints=joints, record=record, unattended_s=2.0)
        self.first: Telemetry | None = None
        self.last: Telemetry | None = None
        self.frames = 0
        self.latest_us = 0
        self.clipped_frames = 0
        self._record = record

    def run(self, duration_s: float | None, watch: Callable[[DrivenRun], None]) -> None:
        """Drive for duration_s, or without end if it is None; watch is called after every frame.

        The robot is stopped before any error is raised: those of RobotBoard, FramesMissing if many
        frames were lost, ClockWrong if the board's clock is implausible.
        """
        with self.robot as robot:
            robot.set("every", 1)  # Like silence, until the board's next reset: it is not saved.
            if not robot.settings()["silence"]:
                robot.set("silence", 2.0)  # The board stops if this program dies.
            robot.gait(self.gait)
            for frame in robot.frames(duration_s):
                self._count(frame)
                watch(self)
        self._check_frames(duration_s or 0.0)
        self.robot.clock.check()

    @property
    def elapsed_s(self) -> float:
        """Return the board's time from the first frame to the last, s."""
        if self.first is None or self.last is None:
            return 0.0
        count = (self.last.frame - self.first.frame) & 0xFFFFFFFF
        return 1e-6 * self.robot.hello.frame_us * count

    def frequency(self) -> tuple[float, float] | tuple[None, None]:
        """Return the settled gait's frequency, Hz, by this computer's clock, and its sigma.

        Both are None if the board's clock is implausible.
        """
        drift = self.robot.clock
        if not drift.believable:
            return None, None
        rate, sd = drift.true_rate(self.gait.omega_rad_s)
        return rate / math.tau, sd / math.tau

    def summary(self) -> Summary | None:
        """Return the summary of the frames so far; None if there is none."""
        if self.last is None:
            return None
        hello, drift = self.robot.hello, self.robot.clock
        frequency_hz, frequency_sd_hz = self.frequency()
        return Summary(
            **vars(self.robot.losses),
            board=hello.board,
            firmware=hello.firmware,
            duration_s=self.elapsed_s,
            frames=self.frames,
            latest_us=self.latest_us,
            clipped_frames=self.clipped_frames,
            drift_ppm=drift.ppm,
            drift_sd_ppm=drift.sd_ppm,
            frequency_hz=frequency_hz,
            frequency_sd_hz=frequency_sd_hz,
            recording=self._record and str(self._record),
        )

    def _check_frames(self, duration_s: float) -> None:
        """Raise FramesMissing if more than a tenth of the frames of a duration were lost."""
        # A busy computer may not have read the frames of the last 0.3 s yet.
        due = (duration_s - 0.3) * 1e6 / self.robot.hello.frame_us
        came = self.frames + self.robot.losses.unread_frames
        missed = max(self.robot.losses.missed_frames, math.ceil(due) - came)
        if missed >= 0.1 * (came + missed):
            raise FramesMissing(
                f"{came} frames came and {missed} did not; use a shorter or better USB "
                "cable, and no hub; `serpenoid doctor` counts what is lost"
            )

    def _count(self, frame: Telemetry) -> None:
        self.first = self.first or frame
        self.last = frame
        self.frames += 1
        self.latest_us = max(self.latest_us, frame.late_us)
        self.clipped_frames += frame.clipped > 0
