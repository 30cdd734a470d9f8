"""Samples of a band, continued from each other with rough servos, against separate solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import OF_2005
from serpenoid.periodic.servo_steady import drawn_servo_speeds, servo_speed
from serpenoid.periodic.steady import drawn_states

# Robot, ground, gait and kind of servo: on dry ground, at a sharp drop of speed, on viscous ground.
CASES = {
    "dry": (OF_2005, (0.014, 0.2, 0.0233, 0.045), sn.Gait(1.22, 1.31, math.pi), "hobby"),
    "sharp drop": (OF_2005, (0.014, 0.2, 0.0233, 0.045), sn.Gait(0.7, 1.05, math.pi), "hobby"),
    "viscous": (sn.Robot(5, 0.06, 0.06), (0.04, 0.8), sn.Gait(0.9, 1.1, 4.0), "MG996R"),
}


def random_case(name: str, count: int = 32) -> tuple:
    robot, friction, gait, kind = CASES[name]
    rng = np.random.default_rng(5)
    grounds = friction * np.exp(0.1 * rng.normal(size=(count, len(friction))))
    alphas = gait.alpha_rad * (1 + 0.03 * rng.normal(size=count))
    samples = [
        (sn.Ground(*row), sn.Gait(alpha, gait.beta_rad, gait.omega_rad_s))
        for row, alpha in zip(grounds.tolist(), alphas.tolist(), strict=True)
    ]
    return robot, (sn.Ground(*friction), gait), samples, sn.servo(kind).draws(count, 3)


@pytest.mark.parametrize("name", CASES)
def test_samples_with_servos_have_the_speeds_of_separate_solutions(name: str) -> None:
    """The ends of a band agree to a tenth of its half; 32 samples leave twice that uncertainty."""
    robot, centre, samples, servos = random_case(name)
    separate = [
        sn.steady_gait(robot, *sample, rtol=1e-6, powers=False).speed_m_s for sample in samples
    ]
    states = drawn_states(robot, centre, samples)
    # The tolerance is 1e-3, for slow gaits relative to a ten-thousandth of a body length.
    assert [s.speed_m_s for s in states] == pytest.approx(separate, rel=1e-3, abs=2e-7)
    speeds = drawn_servo_speeds(states, servos)
    true = [servo_speed(*pair) for pair in zip(states, servos, strict=True)]
    shares = [0.025, 0.16, 0.5, 0.84, 0.975]
    exact, rough = (np.quantile(v, shares, method="weibull") for v in (true, speeds))
    assert np.abs(exact - rough).max() < 0.05 * (exact[-1] - exact[0])
    assert np.corrcoef(true, speeds)[0, 1] > 0.99  # verdicts depend on each sample


def test_equal_servos_have_equal_speeds() -> None:
    """The error of rough states must not widen the band of a servo that is known well."""
    robot, centre, samples, servos = random_case("dry", 1)
    states = drawn_states(robot, centre, samples) * 24
    separate = servo_speed(states[0], servos[0])
    assert drawn_servo_speeds(states, servos * 24) == pytest.approx([separate] * 24, rel=1e-9)


def test_ground_without_friction_is_refused() -> None:
    robot, centre, samples, _ = random_case("viscous", 2)
    with refused("no friction"):
        drawn_states(robot, centre, [*samples, (sn.Ground(0.0, 0.0), centre[1])])
