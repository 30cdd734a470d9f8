"""The law of a partly bent robot against friction summed link by link; sessions of both bends."""

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import setup, stations

TRUTH = np.array([0.084, 1.2, 0.14, 0.27])
# Written down by hand: which links are bent, and to which side.
SIGNS = {4: "+--+", 5: "+-0-+", 6: "+-00-+", 7: "+-000-+", 8: "+--++--+", 9: "+--+0+--+"}


def along_n(truth, angles_rad, speed_m_s):
    """Return the friction along the belt, summed over links at these angles to it."""
    total = 0.0
    for angle in angles_rad:
        c, s = math.cos(angle), abs(math.sin(angle))
        total += (truth[0] * speed_m_s * c + truth[2]) * c + (
            truth[1] * speed_m_s * s + truth[3]
        ) * s
    return total / len(angles_rad)


def angles(links, lambda_rad, bend):
    if bend == "zigzag":
        return [lambda_rad * (-1) ** k for k in range(links)]
    return [{"+": 1, "-": -1, "0": 0}[sign] * lambda_rad for sign in SIGNS[links]]


def session_of(bend, links=6):
    """Take straight and bent stations where the sum over links balances the pull."""
    made = setup(15.0, 30.0)
    made = replace(made, robot_table=replace(made.robot_table, links=links))
    rows = []
    for lambda_rad in np.radians(made.plan.lambda_deg):
        shape = angles(links, lambda_rad, bend)
        for speed in np.linspace(0.1, 0.9, 6).tolist():
            pull_n = along_n(TRUTH, shape, speed)
            rows.append((lambda_rad, math.asin(pull_n / made.weight_n), speed))
    return stations(made, rows, bend=bend)


@pytest.mark.parametrize(
    ("bend", "links", "method"),
    [
        *(("balanced", links, "joint") for links in SIGNS),
        *((bend, 6, "naive") for bend in ("balanced", "zigzag")),
    ],
)
def test_a_fit_finds_the_frictions_again(bend, links, method):
    fit = sn.fit_friction(session_of(bend, links), method=method)
    assert list(fit.whole_snake.values()) == pytest.approx(TRUTH, rel=2e-3)
    assert any("Was it guided?" in note for note in fit.notes) == (bend == "zigzag")


def test_readings_that_could_each_be_the_wrong_one_are_all_named():
    """With one bend, any two of three straight readings are a line that agrees with it."""
    made = session_of("balanced")
    straight = [made.readings[k] for k in (0, 2, 5)]
    straight[1] = replace(straight[1], belt_speed_m_s=straight[1].belt_speed_m_s + 0.2)
    fit = sn.fit_friction(replace(made, readings=(*straight, *made.readings[12:])))
    assert "Without reading 1, 3 or 6 chi2 would be 0.0 or less: look there" in fit.alarms[0]
