"""Dry gaits that once did not converge, and how many of random ones do not."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn


def test_wild_dry_robots_converge() -> None:
    """Links 3 to 12, friction over decades: at most one in a hundred without an answer."""
    rng = np.random.default_rng(11)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    lost = 0
    for _ in range(100):
        robot = sn.Robot(int(rng.integers(3, 13)), between(0.003, 3), between(0.02, 0.3))
        along, dry = between(1e-3, 3), robot.link_mass_kg * 9.81 * between(1e-3, 1)
        ground = sn.Ground(along, along * between(1e-2, 1e3), ft0=dry, fn0=dry * between(0.1, 30))
        gait = sn.Gait(rng.uniform(0.05, 1.5), rng.uniform(0.1, 1.7), between(0.1, 30))
        try:
            sn.steady_gait(robot, ground, gait)
        except sn.NotConverged:
            lost += 1
    assert lost <= 1


# robot (links, kg, m), ground (ct, cn, ft0, fn0), gait (alpha, beta, omega, offset); then speed,
# net and positive power by an integration of its own: extrapolated implicit Euler in Python, whose
# mode changes are found by halving steps to 1e-11 of a period (all its digits agree at two
# tolerances). Three wheels stick at once, hardly independent, which breaks tight pieces.
THREE_STUCK = [
    (
        (7, 0.3923105956797782, 0.08427617476184865),
        (0.047877268961768374, 0.07026086230986531, 0.07797135149543699, 0.33670297245883235),
        (0.6562093612987732, 0.930306891062755, 1.4684313596837932, 0.0),
        (0.1051711313, 0.0711148166, 0.0766914849),
    ),
    (
        (8, 0.07846689057337346, 0.053221884471477215),
        (0.03518527670713614, 0.10062916291724186, 0.026480993121816326, 0.09397698014907603),
        (0.5901683075605526, 1.2231554919108452, 0.9140098788169324, 0.0),
        (0.02482672685, 0.00749058481, 0.00998420889),
    ),
]


@pytest.mark.parametrize("case", THREE_STUCK, ids=lambda c: str(c[0][0]))
@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_three_wheels_stuck_at_once(case: tuple, rtol: float) -> None:
    robot, ground, gait, (speed, power, positive) = case
    try:
        s = sn.steady_gait(sn.Robot(*robot), sn.Ground(*ground), sn.Gait(*gait), rtol=rtol)
        assert s.error_estimate <= rtol
    except sn.NotConverged as error:  # it has the best state
        s, said = error.best, str(error)
        assert rtol < s.error_estimate < 10 * rtol
        assert "simulate" in said
    assert s.speed_m_s == pytest.approx(speed, rel=s.error_estimate + 1e-8)
    assert s.power_w == pytest.approx(power, rel=1e-7, abs=s.power_error_w)
    assert s.positive_power_w == pytest.approx(positive, rel=6e-4)  # spikes of sticking forces


def test_chattering_wheels_are_known_to_1e_7() -> None:
    """Smooth pieces break off at them at some tolerances, and claims hold at the others."""
    robot = sn.Robot(5, 0.7749911850922024, 0.040554207359343626)
    ground = sn.Ground(1.8010825256861138, 68.02709323785253, 4.3835170410651525, 11.40519629403444)
    gait = sn.Gait(1.2017761281416313, 1.6731097946154556, 14.705229722525305)
    s = sn.steady_gait(robot, ground, gait, rtol=1e-7)
    assert s.speed_m_s == pytest.approx(0.184637541, rel=s.error_estimate + 3e-9)
    assert s.positive_power_w == pytest.approx(8.61887095, abs=s.positive_power_error_w)


DOUBTFUL_POWER = [  # wheels that come so near to rest that their friction is not known
    (
        sn.Robot(4, 0.02074797589343744, 0.0887282084241381),
        sn.Ground(0.028839436652526796, 0, 0.7571929018097807, 0.1770174603820255),
        sn.Gait(0.5376777702018338, 2.597733954407644, 1.158456065137213),
    ),
    (
        sn.Robot(30, 0.0756, 0.076),
        sn.Ground(0.014, 0.2, 0.14 / 6, 0.045),
        sn.Gait(math.radians(40), math.radians(30), 2.0),
    ),
]


@pytest.mark.parametrize("case", DOUBTFUL_POWER, ids=["4 links", "30 links"])
def test_positive_power_in_doubt_refuses_no_state(case: tuple) -> None:
    """Speed and net power are known as asked; positive power has an error of its own."""
    s = sn.steady_gait(*case)
    assert s.error_estimate <= 1e-6
    assert s.power_error_w <= 1e-5 * s.power_w
    assert s.positive_power_error_w > 1e-3 * s.positive_power_w
    assert "the power without regeneration" in s.power_doubt_text()


def test_pairs_of_wheels_that_hardly_differ_leave_little_doubt() -> None:
    """A hair from a lag of 2 pi / 7 twelve links have wheels in pairs; their speeds are known."""
    robot = sn.Robot(12, 0.1, 0.08)
    gait = sn.Gait(0.5512654742976816, 0.897597793917269, 0.3710493231338987)
    ground = sn.Ground(0.0, 0.0, 0.01, 0.4)
    s, fine = (sn.steady_gait(robot, ground, gait, rtol=rtol) for rtol in (1e-6, 1e-7))
    assert s.positive_power_error_w < 5e-3 * s.positive_power_w
    assert abs(s.positive_power_w - fine.positive_power_w) < s.positive_power_error_w
