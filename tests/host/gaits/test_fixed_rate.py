"""Least power at a rate that is given, against the finest of one table of shapes."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn
from robots import OF_2005, PAPER, VISCOUS

D = math.pi / 180
CASES = {
    "viscous": (PAPER, VISCOUS, 0.3, 5.0, "power"),
    "dry, where two amplitudes that give the speed meet": (
        OF_2005,
        sn.Ground.whole_body(6, 0.083459, 1.192, 0.1344398, 0.2558096),
        0.05,
        2.0,
        "power",
    ),
}


def least_of_a_table(
    robot: sn.Robot, ground: sn.Ground, speed: float, rate: float, cost: str
) -> float:
    """Return the least cost where lines of one lag cross the speed."""
    if ground.dry:  # where a wide table has it
        alpha, beta = np.linspace(60, 90, 31) * D, np.linspace(80, 92, 25) * D
    else:
        alpha, beta = np.linspace(2, 110, 109) * D, np.linspace(20, 170, 76) * D
    table = sn.sweep(robot, ground, alpha_rad=alpha, beta_rad=beta, omega_rad_s=[rate], rtol=1e-4)
    v, watts = table.speed_m_s[:, :, 0], getattr(table, f"{cost}_w")[:, :, 0]
    i, j = np.nonzero((v[1:] < speed) != (v[:-1] < speed))
    part = (speed - v[i, j]) / (v[i + 1, j] - v[i, j])
    return float((watts[i, j] * (1 - part) + watts[i + 1, j] * part).min())


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_pinned_rate_has_its_optimum(case: str) -> None:
    robot, ground, speed, rate, cost = CASES[case]
    limits = sn.GaitLimits(omega_low_rad_s=rate, omega_high_rad_s=rate)
    best = sn.least_power_gait(robot, ground, speed_m_s=speed, cost=cost, limits=limits)
    truth = least_of_a_table(robot, ground, speed, rate, cost)
    assert best.gait.omega_rad_s == pytest.approx(rate, rel=1e-4)
    assert best.speed_m_s == pytest.approx(speed, rel=1e-4)
    assert best.power_w < truth * 1.001
    assert truth < best.power_w * 1.01  # the table is no finer
    assert {"lowest rate", "highest rate"} <= set(best.active)


def test_a_rate_too_low_for_the_speed_is_refused() -> None:
    limits = sn.GaitLimits(omega_low_rad_s=0.1, omega_high_rad_s=0.1)
    with pytest.raises(sn.NotConverged, match=r"no gait reaches 0\.3 m/s"):
        sn.least_power_gait(*CASES["viscous"][:2], speed_m_s=0.3, limits=limits)
