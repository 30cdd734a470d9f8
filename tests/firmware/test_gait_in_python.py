"""The firmware's gait, as compiled into the package, compared with the formula."""

from __future__ import annotations

import binascii

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from serpenoid._core import firmware


def setpoint_errors(
    alpha_deg: float, beta_deg: float, omega: float, offset_deg: float = 0.0
) -> np.ndarray:
    """Return the setpoints of a settled gait minus the formula, deg, (frames, joints)."""
    frames, joints = 4000, 5
    alpha, beta, offset = np.radians([alpha_deg, beta_deg, offset_deg])
    setpoints = firmware.gait_setpoints_rad(
        alpha, beta, omega, offset_rad=offset, frames=frames, joints=joints
    )
    time_s = firmware.FRAME_S * np.arange(frames)[:, None]
    return np.degrees(
        setpoints - offset - alpha * np.sin(omega * time_s + beta * np.arange(joints))
    )


def test_the_settled_gait_follows_the_formula() -> None:
    """Errors: sine 7e-5 of 90 deg, 0.0063 deg; three roundings to half of 0.0035 deg."""
    rng = np.random.default_rng(2005)
    for _ in range(100):
        alpha, beta, omega = rng.uniform([0, -180, 0.01], [90, 180, 30])
        errors = setpoint_errors(alpha, beta, omega, rng.uniform(alpha - 90, 90 - alpha))
        assert np.abs(errors).max() < 0.0116
    for alpha, beta, omega in ((90, 75, 5.0), (30, 80, 1.7987), (70, -20, 20.0)):
        errors = setpoint_errors(alpha, beta, omega)
        assert np.abs(errors).max() < 0.0116
        assert np.abs(errors.mean(axis=0)).max() < 1e-4  # 9e-4 if values are cut instead of rounded


@given(st.binary(max_size=300))
def test_crc_equals_that_of_the_standard_library(data: bytes) -> None:
    assert firmware.crc16(data) == binascii.crc_hqx(data, 0xFFFF)
