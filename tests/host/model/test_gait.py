"""A gait in degrees, and hints where degrees or grams were given for radians or kilograms."""

from __future__ import annotations

import math

import pytest
import serpenoid as sn
from refusals import refused
from robots import OF_2005, PAPER, VISCOUS


def test_a_gait_in_degrees_is_the_gait_in_radians() -> None:
    gait = sn.Gait.degrees(70, 75, hertz=0.5, offset_deg=-10)
    assert gait == sn.Gait(math.radians(70), math.radians(75), math.pi, math.radians(-10))
    with refused("alpha_deg is 181.0; it must be .* at most 180"):
        sn.Gait.degrees(181, 75, hertz=0.5)
    with refused("hertz is 0.0; it must be .* more than 0"):
        sn.Gait.degrees(70, 75, hertz=0)


def test_degrees_that_look_like_radians_get_a_hint() -> None:
    with pytest.warns(UserWarning, match="if radians were meant, they are 70 and 75 degrees"):
        sn.Gait.degrees(math.radians(70), math.radians(75), hertz=0.5)


@pytest.mark.parametrize(
    ("typed", "remark"),
    [
        ({"link_length_m": 3}, r"a link is 3 m long, .*0.3 m; .*give 0.03 \(cm\) or 0.0762 \(in\)"),
        ({"link_length_m": 76}, r"a link is 76 m long, .* give 0.076 \(mm\)$"),
        (
            {"link_mass_kg": 75.6},
            "a link has 75.6 kg, the whole robot 453.6 kg; .* divide by 1000$",
        ),
        ({"alpha_deg": 140}, "joints bend by up to 140 degrees, .*half of the swing"),
    ],
)
def test_numbers_that_no_snake_robot_has_get_a_remark(typed: dict, remark: str) -> None:
    values = {"alpha_deg": 70, "link_mass_kg": 0.0756, "link_length_m": 0.076} | typed
    gait = sn.Gait.degrees(values.pop("alpha_deg"), 75, hertz=0.5)
    with pytest.warns(UserWarning, match=remark):
        state = sn.steady_gait(sn.Robot(6, **values), VISCOUS, gait)
    assert state.gait == gait


def test_the_papers_robots_get_no_remark(recwarn) -> None:
    for robot in (PAPER, OF_2005):
        sn.Scene(robot, VISCOUS, sn.Gait.degrees(90, 75, hertz=0.5))
    assert not recwarn
