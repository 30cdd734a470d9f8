"""The exact pulses of a gait: the formula, and the frame whose setpoint each pulse carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from avr.board import F_CPU_HZ, Board, Pulses
from avr.dialogue import Telemetry

FRAME_US = 20_000
CENTRE_US, SCALE_US_RAD = 1500.0, 573.0  # default trims of a board
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
        time_s = (frame - self.frame).astype(float) * FRAME_US * 1e-6
        phase = self.phase_rad + self.omega_rad_s * time_s + joint * self.beta_rad
        angle = self.steering_rad + self.alpha_rad * np.sin(phase)
        return CENTRE_US + SCALE_US_RAD * angle


def frame_grid(telemetry: Telemetry, offset_us: float) -> tuple[float, float]:
    """Return the due time of frame 0, and the longest delay of a frame's pulses, both in us.

    Times are those of the cycle stamps; offset_us is the time at which micros() was 0. micros()
    overflows, so the start of a frame is the last matching time before its line was sent.
    """
    sent_us = telemetry.cycle * (1e6 / F_CPU_HZ)
    start_us = sent_us - np.mod(sent_us - telemetry.time_us - offset_us, 2.0**32)
    due_us = start_us - telemetry.late_us - telemetry.frame.astype(np.int64) * FRAME_US
    spread = float(np.max(due_us) - np.min(due_us))
    assert spread <= 8.1, f"frames are not on a grid: their due times scatter by {spread} us"
    window_us = float(np.max(telemetry.late_us + telemetry.exec_us)) + CLOCK_SLACK_US
    return float(np.min(due_us)) - CLOCK_SLACK_US / 2, window_us


def frame_of_pulses(
    board: Board, pulses: Pulses, telemetry: Telemetry, offset_us: float
) -> np.ndarray:
    """Return the frame number that each pulse must carry, (N,).

    All pulses of a refresh carry the setpoints of one frame: the last one due before the refresh
    began, which is when the first servo's pin rose.
    """
    zero_us, _ = frame_grid(telemetry, offset_us)
    refreshes = board.pulses(0).rise_cycle
    begun = refreshes[np.searchsorted(refreshes, pulses.rise_cycle, side="right") - 1]
    return np.floor((begun * (1e6 / F_CPU_HZ) - zero_us) / FRAME_US).astype(np.int64)


def pulse_errors_us(board: Board, telemetry: Telemetry, wave: Wave) -> np.ndarray:
    """Return measured minus exact width of every pulse of all joints during the telemetry."""
    errors, offset_us = [], board.clock_offset_us()
    for joint in range(telemetry.pulse_us.shape[1]):
        pulses = pulses_during(board.pulses(joint), telemetry)
        frame = frame_of_pulses(board, pulses, telemetry, offset_us)
        errors.append(pulses.width_us - wave.pulse_us(frame, joint))
    return np.concatenate(errors)


def line_errors_us(board: Board, telemetry: Telemetry) -> np.ndarray:
    """Return the measured width minus that in the telemetry line of the frame."""
    errors, offset_us = [], board.clock_offset_us()
    rows = {int(f): i for i, f in enumerate(telemetry.frame)}
    for joint in range(telemetry.pulse_us.shape[1]):
        pulses = pulses_during(board.pulses(joint), telemetry)
        frames = frame_of_pulses(board, pulses, telemetry, offset_us)
        errors += [
            width - telemetry.pulse_us[rows[frame], joint]
            for width, frame in zip(pulses.width_us, frames, strict=True)
            if frame in rows
        ]
    return np.array(errors)


def pulses_during(pulses: Pulses, telemetry: Telemetry) -> Pulses:
    """Return the pulses that rose during the telemetry, without its first and last frame."""
    inside = (pulses.rise_cycle > telemetry.cycle[1]) & (pulses.rise_cycle < telemetry.cycle[-1])
    return Pulses(pulses.rise_cycle[inside], pulses.width_us[inside])
