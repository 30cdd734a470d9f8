"""Pushes, slides and crawls in the lab against closed forms, and what is recorded of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn
from robots import OF_2005
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.floor import Floor, Push
from serpenoid.lab.robot import LabRobot, pose_of

WHOLE = sn.Ground(0.084, 1.2, 0.14, 0.27)
MASS, G = 6 * 0.0756, 9.81
BALANCED = (1, -1, 0, 0, -1, 1)


def coast(v0, a, b, inert):
    """Time and way to rest of v' = -(a v + b) / inert."""
    c, f = a / inert, b / inert
    stop = math.log(1 + c * v0 / f) / c
    return stop, (v0 + f / c) * (1 - math.exp(-c * stop)) / c - f * stop / c


def drag(bend_deg):
    """Friction along the axis of a balanced bend, link by link: slope and dry part."""
    bends = np.abs(BALANCED) * math.radians(bend_deg)
    c, s = np.cos(bends), np.sin(bends)
    along = (WHOLE.ct * c * c + WHOLE.cn * s * s).mean(), (WHOLE.ft0 * c + WHOLE.fn0 * s).mean()
    return float(along[0]), float(along[1])


@pytest.mark.parametrize("bend_deg", [0.0, 45.0])
@pytest.mark.parametrize(("slope_deg", "way"), [(0.0, 1), (0.2, 1), (0.2, -1)])
@pytest.mark.parametrize("wheels_kg", [0.0, 0.02])
def test_a_push_rolls_out_as_the_closed_form(bend_deg, slope_deg, way, wheels_kg):
    """Wheels that turn roll farther; bent ones turn less than the robot moves."""
    a, b = drag(bend_deg)
    pull = MASS * G * math.sin(math.radians(slope_deg)) * way
    robot = LabRobot.whole_body(OF_2005, WHOLE, rolling_kg=wheels_kg)
    bends = np.abs(BALANCED) * math.radians(bend_deg)
    inert = MASS + wheels_kg * float((np.cos(bends) ** 2).mean())
    track = Floor(robot, math.radians(slope_deg)).push(
        pose_of(BALANCED, math.radians(bend_deg)), Push(0.8, 0.0 if way > 0 else math.pi)
    )
    stop, far = coast(0.8, a, b - pull, inert)
    assert way * (track.x_m[-1] - track.x_m[0]) - 0.15 == pytest.approx(far, rel=3e-3)
    assert track.t_s[-1] - track.released_s == pytest.approx(stop, abs=0.02)
    assert np.ptp(track.heading_rad) < 1e-6


def test_a_crawl_is_measured_once_the_start_is_forgotten() -> None:
    """A fast gait on slippery wheels: three cycles are too few to forget the start."""
    gait = sn.Gait(0.6, 1.3, 4 * math.pi)
    steady = sn.steady_gait(OF_2005, sn.Ground(0.02, 0.5), gait)
    assert steady.settling_time_s > 1.5 * gait.period_s
    assert crawl_speed(LabRobot(OF_2005, (sn.Ground(0.02, 0.5),)), gait) == pytest.approx(
        steady.speed_m_s, rel=0.02
    )
