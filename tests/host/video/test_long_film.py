"""A film of many periods: the same numbers, better known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from serpenoid.video.fitting.start import first_cameras
from serpenoid.video.instrument import follow, measure
from video.filming import Lens
from video.sighted import sighted
from video.worlds import LINK_M, SIDE_M, crawling


def test_a_long_film_is_measured_as_a_short_one() -> None:
    seconds = 21
    world = crawling(omega_rad_s=4.0, speed_m_s=0.2 / seconds, start_m=-0.1)
    s = sighted(world, np.arange(0, seconds, 1 / 30), Lens())
    found = measure(follow(s, SIDE_M, first_cameras(s, LINK_M, SIDE_M)))
    m, joints = found.fitted.motion, world.links - 1
    assert m.omega_rad_s == pytest.approx(world.omega_rad_s, abs=5 * found.sigmas[0])
    assert found.sigmas[0] < 1e-3 * world.omega_rad_s / seconds
    assert m.amplitude_rad == pytest.approx(world.amplitude_rad, abs=math.radians(0.1))
    assert m.speed_m_s == pytest.approx(world.speed_m_s, rel=0.003)
    assert found.sigmas[1 : 1 + joints].max() < math.radians(0.1)
