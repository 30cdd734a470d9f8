"""Per cents of speed for 1 % of seven numbers: dimensions, cold solutions, kinks, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from command_line import answer
from refusals import refused
from robots import BINGHAM, OF_2005, VISCOUS, gait_in_deg
from serpenoid.periodic.sensitivities import NUMBERS, Sensitivities

DRY = sn.Ground(0.37, 1.2, 0.14, 0.42)
GAIT = gait_in_deg(60, 75, 4.0)


def found_of(*parts) -> Sensitivities:
    state = sn.steady_gait(*parts, sensitivities=True)
    assert isinstance(state, sn.Steady)
    assert state.sensitivities is not None
    return state.sensitivities


@pytest.mark.parametrize("ground", [DRY, VISCOUS], ids=["dry", "viscous"])
def test_a_change_of_the_unit_of_mass_changes_no_speed(ground: sn.Ground) -> None:
    found = found_of(OF_2005, ground, GAIT)
    by = dict(zip(NUMBERS, found.percent, strict=True))
    together = by["mass"] + by["friction along"] + by["friction across"]
    assert together == pytest.approx(0, abs=found.errors.sum())


def test_on_viscous_ground_a_longer_robot_is_faster_by_its_length() -> None:
    found = found_of(OF_2005, VISCOUS, GAIT)
    assert found.percent[list(NUMBERS).index("length")] == pytest.approx(1, abs=1e-3)
    assert not any(found.one_sided)


@pytest.mark.parametrize("seed", range(6))
def test_cold_solutions_are_within_the_errors(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = sn.Robot(int(rng.integers(3, 8)), rng.uniform(0.02, 0.3), rng.uniform(0.05, 0.15))
    along, dry_n = rng.uniform(0.02, 0.5), rng.uniform(0.02, 0.3)
    ground = sn.Ground(along, 6 * along, dry_n, 5 * dry_n)
    gait = sn.Gait(rng.uniform(0.4, 1.4), rng.uniform(0.8, 1.8), rng.uniform(1, 12))
    found = found_of(robot, ground, gait)
    amplitudes = [replace(gait, alpha_rad=gait.alpha_rad * k) for k in (0.999, 1.0, 1.001)]
    slow, middle, fast = (
        sn.steady_gait(robot, ground, one, rtol=1e-7).speed_m_s for one in amplitudes
    )
    percent = (fast - slow) / middle / 2e-3
    k = list(NUMBERS).index("amplitude")
    assert abs(found.percent[k] - percent) <= 2 * found.errors[k] + 1e-3


def test_both_sides_of_a_kink_are_told() -> None:
    """A wheel just rests for a moment: less rate and more rate have slopes of their own."""
    robot = sn.Robot(4, 0.8959753194665062, 0.11449974952753592)
    ground = sn.Ground(
        0.03194286533884961, 2.3488956713548883, 0.7162086592020847, 3.275844670696158
    )
    gait = sn.Gait(1.223308166518118, 1.4531583908504635, 5.225083217087462, -0.12678797430575386)
    found = found_of(robot, ground, gait)
    rate = list(NUMBERS).index("rate")
    v = sn.steady_gait(robot, ground, gait, rtol=1e-7).speed_m_s
    for side, slope in ((found.less[rate], 0.03934), (found.more[rate], 0.03728)):
        assert side == pytest.approx(slope * gait.omega_rad_s / v, rel=0.05)
    assert not found.one_sided[rate]  # they differ by 5 %


def test_sides_that_differ_are_told_in_words() -> None:
    gait = sn.Gait.degrees(70, 75, hertz=0.6)
    found = found_of(OF_2005, BINGHAM, gait)
    base, less = (
        sn.steady_gait(OF_2005, BINGHAM, replace(gait, alpha_rad=gait.alpha_rad * k)).speed_m_s
        for k in (1.0, 0.99)
    )
    amplitude = list(NUMBERS).index("amplitude")
    assert found.less[amplitude] == pytest.approx(100 * (1 - less / base), rel=1e-3)
    row = next(line for line in str(found).splitlines() if "amplitude" in line)
    assert "less +0.18, more -0.54" in row


def test_the_command_has_all_seven() -> None:
    told = answer("steady --alpha-deg 60 --beta-deg 75 --omega-rad-s 4 --sensitivities")
    assert list(told["sensitivities"]) == [name.replace(" ", "_") for name in NUMBERS]
    assert told["sensitivities"]["friction_across"]["percent"] > 0


def test_a_gait_that_goes_nowhere_is_refused() -> None:
    with refused("has no speed"):
        found_of(OF_2005, DRY, replace(GAIT, alpha_rad=0.0))
