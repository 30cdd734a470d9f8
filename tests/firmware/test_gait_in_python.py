"""The firmware's gait as compiled into the package, held to the formula."""

from __future__ import annotations

import binascii

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from serpenoid._core import firmware


def test_the_settled_gait_is_the_formula() -> None:
    """The bound is derived in test_gait.cpp: sine 0.0063°, three roundings of 0.0018°."""
    frames, joints = 4000, 5
    for alpha_deg, beta_deg, omega in ((90, 75, 5.0), (30, 80, 1.7987), (70, -20, 20.0)):
        alpha, beta = np.radians([alpha_deg, beta_deg])
        got = firmware.gait_setpoints_rad(alpha, beta, omega, frames=frames, joints=joints)
        time_s = firmware.FRAME_S * np.arange(frames)[:, None]
        truth = alpha * np.sin(omega * time_s + beta * np.arange(joints))
        assert np.degrees(np.abs(got - truth).max()) < 0.0116
        mean = np.degrees((got - truth).mean(axis=0))  # cut in place of rounded, it is 9e-4
        assert np.abs(mean).max() < 1e-4


@given(st.binary(max_size=300))
def test_crc_is_the_standard_librarys(data: bytes) -> None:
    assert firmware.crc16(data) == binascii.crc_hqx(data, 0xFFFF)


@pytest.mark.parametrize(
    "bad", [{"alpha_rad": 1.6}, {"beta_rad": 3.2}, {"omega_rad_s": -1.0}, {"omega_rad_s": np.nan}]
)
def test_values_the_board_cannot_hold_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"at (most|least)"):
        firmware.gait_setpoints_rad(
            **{"alpha_rad": 0.5, "beta_rad": 1.0, "omega_rad_s": 5.0, **bad}
        )
