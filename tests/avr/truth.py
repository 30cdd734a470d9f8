"""What the pulses of a gait must be: the formula, and which frame's setpoint each pulse carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from avr.board import F_CPU_HZ, Board, Pulses
from avr.dialogue import Telemetry

FRAME_US = 20_000
CENTRE_US, SCALE_US_RAD = 1500.0, 573.0  # the trims a board has before anybody sets them
CLOCK_SLACK_US = 20.0  # micros() counts in steps of 4 us, and its zero is measured to 10 us


@dataclass(frozen=True)
class Wave:
    """A settled gait: amplitude, lag, steering in radians, rate in rad/s, phase at frame 0."""

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    frame: int
    phase_rad: float
    steering_rad: float = 0.0

    def pulse_us(self, frame: np.ndarray, joint: int) -> np.ndarray:
        """Return the exact pulse width of a joint (0 is the tail) at whole frame numbers."""
        since = (frame - self.frame).astype(float) * FRAME_US * 1e-6
        phase = self.phase_rad + self.omega_rad_s * since + joint * self.beta_rad
        angle = self.steering_rad + self.alpha_rad * np.sin(phase)
        return CENTRE_US + SCALE_US_RAD * angle


def frame_grid(seen: Telemetry, offset_us: float) -> tuple[float, float]:
    """Return when frame 0 was due, and for how long after its due time a frame's write may come.

    Both in microseconds of the cycle stamps; offset_us is where micros() was 0 on that scale. As
    micros() runs over, the start of a frame is the last such moment before its line went out.
    """
    sent_us = seen.cycle * (1e6 / F_CPU_HZ)
    start_us = sent_us - np.mod(sent_us - seen.time_us - offset_us, 2.0**32)
    due_us = start_us - seen.late_us - seen.frame.astype(np.int64) * FRAME_US
    spread = float(np.max(due_us) - np.min(due_us))
    assert spread <= 8.1, f"frames are not on a grid: their due times scatter by {spread} us"
    window_us = float(np.max(seen.late_us + seen.exec_us)) + CLOCK_SLACK_US
    return float(np.min(due_us)) - CLOCK_SLACK_US / 2, window_us


def carried(board: Board, pulses: Pulses, seen: Telemetry, offset_us: float) -> np.ndarray:
    """Return the frame number that each pulse must carry, (N,).

    All pulses of a refresh carry the setpoints of one frame: the last one due before the refresh
    began, which is when the first servo's pin rose.
    """
    zero_us, _ = frame_grid(seen, offset_us)
    refreshes = board.pulses(0).rise_cycle
    begun = refreshes[np.searchsorted(refreshes, pulses.rise_cycle, side="right") - 1]
    return np.floor((begun * (1e6 / F_CPU_HZ) - zero_us) / FRAME_US).astype(np.int64)


def pulse_errors_us(board: Board, seen: Telemetry, wave: Wave) -> np.ndarray:
    """Return measured minus exact width of every pulse of all joints while telemetry was seen."""
    errors, offset_us = [], board.clock_offset_us()
    for joint in range(seen.pulse_us.shape[1]):
        pulses = between(board.pulses(joint), seen)
        frame = carried(board, pulses, seen, offset_us)
        errors.append(pulses.width_us - wave.pulse_us(frame, joint))
    return np.concatenate(errors)


def line_errors_us(board: Board, seen: Telemetry) -> np.ndarray:
    """Return measured width minus the width that the telemetry line of its frame announced."""
    errors, offset_us = [], board.clock_offset_us()
    rows = {int(f): i for i, f in enumerate(seen.frame)}
    for joint in range(seen.pulse_us.shape[1]):
        pulses = between(board.pulses(joint), seen)
        frames = carried(board, pulses, seen, offset_us)
        errors += [
            width - seen.pulse_us[rows[frame], joint]
            for width, frame in zip(pulses.width_us, frames, strict=True)
            if frame in rows
        ]
    return np.array(errors)


def between(pulses: Pulses, seen: Telemetry) -> Pulses:
    """Keep the pulses that rose while telemetry was seen, but for its first and last frame."""
    inside = (pulses.rise_cycle > seen.cycle[1]) & (pulses.rise_cycle < seen.cycle[-1])
    return Pulses(pulses.rise_cycle[inside], pulses.width_us[inside])
