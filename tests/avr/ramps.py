"""Setpoints through changes of gait, in floating point, from the rules in firmware/PROTOCOL.md."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from avr.dialogue import JOINTS
from avr.truth import CENTRE_US, FRAME_US, SCALE_US_RAD

FRAME_S = FRAME_US * 1e-6


def approach(now: float, target: float, step: float) -> float:
    """Move by at most one step."""
    return target if abs(target - now) <= step else now + math.copysign(step, target - now)


@dataclass
class RampedGait:
    """The slow truth: one frame at a time, everything in radians and seconds.

    In a frame the phase first moves at the rate reached in the frame before; then amplitude, lag,
    rate and the joints' base angles each move one step, and the servo speed limit comes last.
    """

    angle_ramp_rad_s: float = math.radians(60)
    rate_ramp_rad_s2: float = 5.0
    pose_speed_rad_s: float = math.radians(45)
    servo_speed_rad_s: float = math.radians(500)
    phase_rad: float = 0.0
    now: dict[str, float] = field(default_factory=dict)
    target: dict[str, float] = field(default_factory=dict)
    base_rad: np.ndarray = field(default_factory=lambda: np.zeros(JOINTS))
    base_target_rad: np.ndarray = field(default_factory=lambda: np.zeros(JOINTS))
    setpoint_rad: np.ndarray = field(default_factory=lambda: np.zeros(JOINTS))

    def gait(self, alpha_deg: float, beta_deg: float, omega_rad_s: float, steer_deg: float = 0.0):
        """Ask for a gait; from rest, lag and rate are taken at once."""
        self.target = {
            "alpha": math.radians(alpha_deg),
            "beta": math.radians(beta_deg),
            "omega": omega_rad_s,
        }
        self.base_target_rad = np.full(JOINTS, math.radians(steer_deg))
        if not self.now:
            self.now = {**self.target, "alpha": 0.0}

    def pose(self, *angles_deg: float) -> None:
        """Ask for a pose: the amplitude fades while the base angles move."""
        self.base_target_rad = np.radians(np.array(angles_deg))
        self.target = {**self.target, "alpha": 0.0}

    def frame(self) -> np.ndarray:
        """Advance one frame and return the exact pulse widths in microseconds, (5,)."""
        if self.now:
            self.phase_rad += self.now["omega"] * FRAME_S
            steps = {
                "alpha": self.angle_ramp_rad_s,
                "beta": self.angle_ramp_rad_s,
                "omega": self.rate_ramp_rad_s2,
            }
            for name, rate in steps.items():
                self.now[name] = approach(self.now[name], self.target[name], rate * FRAME_S)
        step = self.pose_speed_rad_s * FRAME_S
        self.base_rad = self.base_rad + np.clip(self.base_target_rad - self.base_rad, -step, step)
        swing = np.zeros(JOINTS)
        if self.now:
            lag = np.arange(JOINTS) * self.now["beta"]
            swing = self.now["alpha"] * np.sin(self.phase_rad + lag)
        most = self.servo_speed_rad_s * FRAME_S
        if self.now and self.now["alpha"] == self.target["alpha"] == 0.0:
            self.now = {}  # at rest: the phase stands still
        wanted = self.base_rad + swing
        self.setpoint_rad = self.setpoint_rad + np.clip(wanted - self.setpoint_rad, -most, most)
        return CENTRE_US + SCALE_US_RAD * self.setpoint_rad


@dataclass(frozen=True)
class Table:
    """Exact pulse widths of consecutive frames, (N, 5), from a first frame number on."""

    first_frame: int
    width_us: np.ndarray

    def pulse_us(self, frame: np.ndarray, joint: int) -> np.ndarray:
        """Return the exact pulse width of a joint at whole frame numbers."""
        return self.width_us[frame - self.first_frame, joint]
