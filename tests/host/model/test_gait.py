"""A gait in degrees, and hints where degrees or grams were given for radians or kilograms."""

from __future__ import annotations

import math

import pytest
import serpenoid as sn
from refusals import refused


def test_a_gait_in_degrees_is_the_gait_in_radians() -> None:
    gait = sn.Gait.degrees(70, 75, hertz=0.5, offset_deg=-10)
    assert gait == sn.Gait(math.radians(70), math.radians(75), math.pi, math.radians(-10))
    with refused("alpha_deg is 181.0; it must be .* at most 180"):
        sn.Gait.degrees(181, 75, hertz=0.5)
    with refused("hertz is 0.0; it must be .* more than 0"):
        sn.Gait.degrees(70, 75, hertz=0)


def test_degrees_that_look_like_radians_and_lengths_like_millimetres_get_a_hint() -> None:
    with pytest.warns(UserWarning, match="if radians were meant, they are 70 and 75 degrees"):
        sn.Gait.degrees(math.radians(70), math.radians(75), hertz=0.5)
    with pytest.warns(UserWarning, match="in millimetres"):
        sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=76)


def test_a_link_heavier_than_metal_gets_a_hint(recwarn) -> None:
    sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    assert not recwarn
    with pytest.warns(UserWarning, match="in grams"):
        sn.Robot(links=6, link_mass_kg=75.6, link_length_m=0.076)
