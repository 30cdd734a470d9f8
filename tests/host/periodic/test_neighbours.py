"""Draws of one band, begun from one another and mostly with rough servos: as solved each alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import OF_2005
from serpenoid.periodic.servo_steady import drawn_servo_speeds, servo_speed
from serpenoid.periodic.steady import drawn_states

# robot, ground, gait and kind of servo: dry, at the cliff (some draws stick, some run), viscous
CASES = {
    "dry": (OF_2005, (0.014, 0.2, 0.0233, 0.045), sn.Gait(1.22, 1.31, math.pi), "hobby"),
    "cliff": (OF_2005, (0.014, 0.2, 0.0233, 0.045), sn.Gait(0.7, 1.05, math.pi), "hobby"),
    "viscous": (sn.Robot(5, 0.06, 0.06), (0.04, 0.8), sn.Gait(0.9, 1.1, 4.0), "MG996R"),
}


def drawn(name: str, count: int = 32) -> tuple:
    robot, friction, gait, kind = CASES[name]
    rng = np.random.default_rng(5)
    grounds = friction * np.exp(0.1 * rng.normal(size=(count, len(friction))))
    alphas = gait.alpha_rad * (1 + 0.03 * rng.normal(size=count))
    draws = [
        (sn.Ground(*row), sn.Gait(alpha, gait.beta_rad, gait.omega_rad_s))
        for row, alpha in zip(grounds.tolist(), alphas.tolist(), strict=True)
    ]
    return robot, (sn.Ground(*friction), gait), draws, sn.servo(kind).draws(count, 3)


@pytest.mark.parametrize("name", CASES)
def test_draws_and_their_servos_have_the_speeds_of_each_alone(name: str) -> None:
    """Ends of a band to a tenth of the half band: 32 draws leave each end twice that in doubt."""
    robot, near, draws, servos = drawn(name)
    alone = [sn.steady_gait(robot, *draw, rtol=1e-6, powers=False).speed_m_s for draw in draws]
    states = drawn_states(robot, near, draws)
    # 1e-3 is asked for, and a slow gait's error is relative to a ten-thousandth of a body length
    assert [s.speed_m_s for s in states] == pytest.approx(alone, rel=1e-3, abs=2e-7)
    speeds = drawn_servo_speeds(states, servos)
    true = [servo_speed(*pair) for pair in zip(states, servos, strict=True)]
    shares = [0.025, 0.16, 0.5, 0.84, 0.975]
    there, here = (np.quantile(v, shares, method="weibull") for v in (true, speeds))
    assert np.abs(there - here).max() < 0.05 * (there[-1] - there[0])
    assert np.corrcoef(true, speeds)[0, 1] > 0.99  # each draw, too: verdicts hang on them


def test_servos_that_differ_by_less_than_rough_states_err_are_told_apart() -> None:
    """A servo known to half a per cent: its band is no artefact of rough states."""
    robot, near, draws, servos = drawn("dry", 1)
    states = drawn_states(robot, near, draws) * 24
    alone = servo_speed(states[0], servos[0])
    assert drawn_servo_speeds(states, servos * 24) == pytest.approx([alone] * 24, rel=1e-9)


def test_ground_without_friction_is_refused() -> None:
    robot, near, draws, _ = drawn("viscous", 2)
    with refused("no friction"):
        drawn_states(robot, near, [*draws, (sn.Ground(0.0, 0.0), near[1])])
