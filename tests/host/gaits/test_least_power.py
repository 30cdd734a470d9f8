"""Least-power gaits: the published ones, those at a limit, refusals."""

from __future__ import annotations

import math

import pytest
import serpenoid as sn
from refusals import refused
from robots import OF_2005, PAPER, VISCOUS
from scipy.optimize import brentq, minimize_scalar
from serpenoid import steady_springs


@pytest.mark.parametrize(
    ("speed", "omega", "alpha_deg", "beta_deg", "watts"),
    [(0.10, 1.7987, 31.77, 83.70, 7.63769e-3), (0.50, 10.138, 25.48, 86.66, 0.22733)],
)
def test_published_gaits(speed, omega, alpha_deg, beta_deg, watts) -> None:
    best = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=speed)
    assert best.power_w == pytest.approx(watts, rel=2e-5)
    assert best.speed_m_s == pytest.approx(speed, rel=1e-8)
    # the valley is flat: the last digits of the gait are worth less than 1e-8 of the power
    assert best.gait.omega_rad_s == pytest.approx(omega, rel=1e-3)
    assert math.degrees(best.gait.alpha_rad) == pytest.approx(alpha_deg, abs=0.05)
    assert math.degrees(best.gait.beta_rad) == pytest.approx(beta_deg, abs=0.05)


@pytest.mark.slow
def test_an_optimum_on_soft_springs_is_theirs() -> None:
    """Springs so soft that the exact model's optimum is far from it."""
    robot, ground = sn.Robot(3, 0.4, 0.11), sn.Ground(0.06, 1.1)
    springs = {"joint_stiffness_n_m": 60.0, "joint_damping_n_s_m": 4.0}
    wish = {"speed_m_s": 0.06, "cost": "positive_power"}
    best = sn.least_power_gait(robot, ground, formulation="implicit", **springs, **wish)
    exact = sn.least_power_gait(robot, ground, **wish)
    assert abs(best.power_w / exact.power_w - 1) > 0.05
    state = steady_springs(robot, ground, best.gait, rtol=1e-5, **springs)
    assert state.positive_power_w == pytest.approx(best.power_w, rel=1e-3)
    assert state.speed_m_s == pytest.approx(0.06, rel=1e-3)


def test_a_speed_beyond_the_limits_names_the_fastest() -> None:
    limits = sn.GaitLimits(omega_high_rad_s=6.0)
    with pytest.raises(sn.NotConverged, match=r"reaches 5 m/s.*fastest found.*makes 0\.4"):
        sn.least_power_gait(PAPER, VISCOUS, speed_m_s=5.0, limits=limits)


def test_refusals() -> None:
    with refused("speed_m_s is 0"):
        sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.0)
    with refused("cost is 'heat'"):
        sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.1, cost="heat")
    with refused("different friction forwards and backwards"):
        sn.least_power_gait(PAPER, sn.Ground((0.1, 0.3), 1.0), speed_m_s=0.1)
    isotropic = sn.Ground(1.0, 1.0)  # no wheel grips better than another: nothing travels
    two = sn.Robot(2, 0.2, 0.14)  # rough states on dry ground seemed to travel
    for robot, ground in ((PAPER, isotropic), (two, sn.Ground(0.03, 0.5, 0.05, 0.3))):
        with pytest.raises(sn.NotConverged, match="no gait travels at all"):
            sn.least_power_gait(robot, ground, speed_m_s=0.05)
        assert sn.power_front(robot, ground, speeds_m_s=[0.03, 0.05]) == (None, None)


def test_wheels_on_rails_cost_less_the_less_they_bend() -> None:
    """So that there is no least: along a wave of little amplitude they roll at omega l / beta."""
    rails = sn.Ground(0.0, 0.2, 0.0, 0.045)
    watts = []
    for alpha in (0.04, 0.02):
        s = sn.steady_gait(OF_2005, rails, sn.Gait(alpha, 0.3, 0.2))
        assert s.speed_m_s == pytest.approx(0.2 * OF_2005.link_length_m / 0.3, rel=0.03)
        watts.append(s.abs_power_w)
    assert watts[1] < 0.5 * watts[0]
    with refused("less the joints bend, the less power"):
        sn.least_power_gait(OF_2005, rails, speed_m_s=0.05)


LONG = sn.Robot(8, 0.20014022388818312, 0.07228480910928739)
LONG_GROUND = sn.Ground(0.061499887826187066, 0.8105096797486241)


@pytest.mark.parametrize(
    ("robot", "ground", "most_rad", "speed", "cost"),
    [
        (PAPER, VISCOUS, math.radians(12), 0.5, "power"),
        (PAPER, VISCOUS, math.radians(20), 0.3, "power"),
        (PAPER, VISCOUS, math.radians(25), 0.1, "power"),
        (LONG, LONG_GROUND, 0.3536142042077465, 0.078187073177679, "abs_power"),
    ],
)
def test_at_a_limit_the_power_is_that_of_the_best_lag(
    robot: sn.Robot, ground: sn.Ground, most_rad: float, speed: float, cost: str
) -> None:
    """Brute force over the lag alone, the amplitude at its limit: it was up to 5e-5 less."""

    def watts(lag: float) -> float:
        def state(x: float) -> sn.Steady:
            return sn.steady_gait(robot, ground, sn.Gait(most_rad, lag, math.exp(x)), rtol=1e-10)

        log_rate = brentq(lambda x: state(x).speed_m_s / speed - 1, -3, 5, xtol=1e-12)
        return getattr(state(log_rate), f"{cost}_w")

    limits = sn.GaitLimits(joint_angle_rad=most_rad)
    best = sn.least_power_gait(robot, ground, speed_m_s=speed, cost=cost, limits=limits)
    waves = 2 * math.pi / robot.links
    found = minimize_scalar(
        watts, bounds=(0.5 * waves, 1.8 * waves), method="bounded", options={"xatol": 1e-7}
    )
    assert best.active == ("joint angle",)
    assert abs(best.power_w - found.fun) < best.power_error_w < 5e-7 * best.power_w
