"""Change of the speed, %, by 1 % of seven numbers: dimensions, finite differences, refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import BINGHAM, OF_2005, VISCOUS, gait_in_deg

DRY = sn.Ground(0.37, 1.2, 0.14, 0.42)
GAIT = gait_in_deg(60, 75, 4.0)


NUMBERS = ["mass", "length", "amplitude", "lag", "rate", "friction along", "friction across"]


def sensitivities(*parts: Any) -> Any:
    state = sn.steady_gait(*parts, sensitivities=True)
    return state.sensitivities


@pytest.mark.parametrize("ground", [DRY, VISCOUS], ids=["dry", "viscous"])
def test_the_speed_does_not_depend_on_the_unit_of_mass(ground: sn.Ground) -> None:
    result = sensitivities(OF_2005, ground, GAIT)
    percent = dict(zip(NUMBERS, result.percent, strict=True))
    together = percent["mass"] + percent["friction along"] + percent["friction across"]
    assert together == pytest.approx(0, abs=result.errors.sum())


def test_the_speed_on_viscous_ground_is_proportional_to_the_length() -> None:
    result = sensitivities(OF_2005, VISCOUS, GAIT)
    assert result.percent[NUMBERS.index("length")] == pytest.approx(1, abs=1e-3)
    assert not any(result.one_sided)


@pytest.mark.parametrize("seed", range(6))
def test_finite_differences_agree_within_the_errors(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = sn.Robot(int(rng.integers(3, 8)), rng.uniform(0.02, 0.3), rng.uniform(0.05, 0.15))
    along, dry_n = rng.uniform(0.02, 0.5), rng.uniform(0.02, 0.3)
    ground = sn.Ground(along, 6 * along, dry_n, 5 * dry_n)
    gait = sn.Gait(rng.uniform(0.4, 1.4), rng.uniform(0.8, 1.8), rng.uniform(1, 12))
    result = sensitivities(robot, ground, gait)
    amplitudes = [replace(gait, alpha_rad=gait.alpha_rad * k) for k in (0.999, 1.0, 1.001)]
    slow, middle, fast = (
        sn.steady_gait(robot, ground, changed, rtol=1e-7).speed_m_s for changed in amplitudes
    )
    percent = (fast - slow) / middle / 2e-3
    k = NUMBERS.index("amplitude")
    assert abs(result.percent[k] - percent) <= 2 * result.errors[k] + 1e-3


def test_one_sided_sensitivities_are_shown() -> None:
    gait = sn.Gait.degrees(70, 75, hertz=0.6)
    result = sensitivities(OF_2005, BINGHAM, gait)
    base, less = (
        sn.steady_gait(OF_2005, BINGHAM, replace(gait, alpha_rad=gait.alpha_rad * k)).speed_m_s
        for k in (1.0, 0.99)
    )
    amplitude = NUMBERS.index("amplitude")
    assert result.less[amplitude] == pytest.approx(100 * (1 - less / base), rel=1e-3)
    row = next(line for line in str(result).splitlines() if "amplitude" in line)
    assert "less +0.18, more -0.54" in row


def test_a_gait_without_speed_is_refused() -> None:
    with refused("has no speed"):
        sensitivities(OF_2005, DRY, replace(GAIT, alpha_rad=0.0))
