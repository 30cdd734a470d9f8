"""Derivatives of a periodic state: dimensions, symmetry, and differences of tight solutions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from command_line import answer
from refusals import refused
from robots import OF_2005, VISCOUS, gait_in_deg
from serpenoid.periodic.sensitivities import QUANTITIES, Sensitivities, differentiate

DRY = sn.Ground(0.37, 1.2, 0.14, 0.42)
RATCHET = sn.Ground((0.3, 0.9), 1.2, (0.05, 0.3), 0.42)
GAIT = gait_in_deg(60, 75, 4.0)


def by_name(found: Sensitivities, quantity: str = "speed_m_s") -> dict[str, float]:
    return dict(zip(found.names, found.elasticities(quantity).tolist(), strict=True))


@pytest.fixture(scope="module", params=[DRY, VISCOUS, RATCHET], ids=["dry", "viscous", "ratchet"])
def found(request) -> Sensitivities:
    return differentiate(OF_2005, request.param, GAIT)


def total(found: Sensitivities, powers: dict[str, float], quantity: str) -> float:
    """Return the elasticity for a change of unit: each name begun so counts by its power."""
    return sum(
        value * power
        for name, value in by_name(found, quantity).items()
        for start, power in powers.items()
        if name.startswith(start)
    )


@pytest.mark.parametrize(
    ("unit", "speed", "power"),
    [
        ({"ct": 1, "cn": 1, "ft0": 1, "fn0": 1, "link_mass": 1, "link_inertia": 1}, 0, 1),  # kg
        ({"omega": -1, "ct": -1, "cn": -1, "ft0": -2, "fn0": -2}, -1, -3),  # s
        ({"link_length": 1, "link_inertia": 2, "ft0": 1, "fn0": 1}, 1, 2),
    ],  # m
)
def test_a_change_of_unit_changes_what_its_dimension_says(found, unit, speed, power) -> None:
    for quantity, exponent in zip(QUANTITIES[:3], (speed, power, power), strict=True):
        assert total(found, unit, quantity) == pytest.approx(exponent, abs=2e-3)


def test_joints_together_are_the_gait(found) -> None:
    """Gains together are the amplitude, shifts together nothing, shifts in a row the lag."""
    by = dict(zip(found.names, found.derivatives, strict=True))
    errors = dict(zip(found.names, found.errors, strict=True))

    def summed(name: str, weights: list[int]) -> tuple[np.ndarray, np.ndarray]:
        each = [(w, f"{name}[{i}]") for i, w in enumerate(weights)]
        return sum(w * by[k] for w, k in each), sum(w * errors[k] for w, k in each)

    for name, weights, one, factor in (
        ("joint_gain", [1] * 5, "alpha_rad", GAIT.alpha_rad),
        ("joint_shift_rad", [1] * 5, "alpha_rad", 0.0),
        ("joint_shift_rad", [0, 1, 2, 3, 4], "beta_rad", 1.0),
    ):
        value, room = summed(name, weights)
        assert (abs(value - factor * by[one]) <= room + factor * errors[one] + 1e-6).all()
        assert room[0] < 0.02  # of the speed: the sum must say something


def test_a_bend_of_all_joints_steers_and_changes_no_speed(found) -> None:
    offset = found.derivatives[found.names.index("offset_rad")]
    assert offset[3] > 1
    assert abs(offset[:3]).max() < 1e-3


def elsewhere(robot: sn.Robot, ground: sn.Ground, gait: sn.Gait, name: str) -> np.ndarray:
    """Return the derivatives by other code: cold solutions at four points."""
    part = next(p for p in (robot, ground, gait) if hasattr(p, name))
    value = getattr(part, name)
    step = 3e-4 * max(abs(value), 1.0 if name.endswith("_rad") else 0.0)

    def at(k: int) -> np.ndarray:
        moved = [
            replace(p, **{name: value + k * step}) if p is part else p
            for p in (robot, ground, gait)
        ]
        s = sn.steady_gait(*moved, rtol=1e-7)  # type: ignore[arg-type]
        return np.array([getattr(s, quantity) for quantity in QUANTITIES])

    return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step)


def random_state(rng: np.random.Generator) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    robot = sn.Robot(int(rng.integers(3, 9)), between(0.02, 0.3), between(0.05, 0.15))
    along, dry = between(0.02, 0.5), between(0.02, 0.3) * (rng.random() < 0.8)
    ground = sn.Ground(along, along * between(2, 20), dry, dry * between(2, 10))
    gait = sn.Gait(
        rng.uniform(0.4, 1.4), rng.uniform(0.8, 1.8), between(1.0, 12.0), 0.2 * (rng.random() < 0.3)
    )
    return robot, ground, gait


def compare(seed: int, count: int) -> tuple[int, int]:
    """Return how many derivatives were held against others, and how many were off."""
    rng = np.random.default_rng(seed)
    held = off = 0
    for _ in range(count):
        parts = random_state(rng)
        try:
            found = differentiate(*parts)
        except sn.NotConverged:
            continue
        for name in ("alpha_rad", "omega_rad_s", "fn0", "ct"):
            if name not in found.names or found.kinks[found.names.index(name)]:
                continue
            k = found.names.index(name)
            try:
                other = elsewhere(*parts, name)
            except sn.NotConverged:  # one in thousands, at the least rtol
                continue
            room = 2 * found.errors[k] + 2e-3 * abs(other)
            held += 1
            off += bool((abs(found.derivatives[k, :3] - other[:3]) > room[:3]).any())
    return held, off


def test_random_states_agree_with_differences_of_cold_solutions() -> None:
    held, off = compare(seed=11, count=6)
    assert held > 15
    assert off <= 0.05 * held


@pytest.mark.parametrize("links", [3, 4, 6, 7])
def test_viscous_ground_has_no_kinks(links: int) -> None:
    """Noise of the state itself grows as the step is halved, as a jump's share does not."""
    gait = replace(GAIT, alpha_rad=math.radians(30), beta_rad=math.radians(80))
    found = differentiate(sn.Robot(links, 1.0, 0.12), VISCOUS, gait)
    assert not found.kinks.any()
    assert (found.sides == found.derivatives[..., None]).all()


def test_the_steady_state_takes_them_along() -> None:
    s = sn.steady_gait(OF_2005, DRY, GAIT, sensitivities=True)
    assert isinstance(s, sn.Steady)
    assert s.sensitivities is not None
    asked = "steady --alpha-deg 60 --beta-deg 75 --omega-rad-s 4 --sensitivities --servo ideal"
    told = answer(asked)["sensitivities"]
    assert set(told) == set(s.sensitivities.names)
    assert told["fn0"]["speed_m_s"]["derivative"] > 0
    row = next(line for line in str(s.sensitivities).splitlines() if " fn0 " in line)
    assert f" {by_name(s.sensitivities)['fn0']:+.2g} " in row


def test_a_gait_that_goes_nowhere_has_derivatives() -> None:
    """States beside it have a speed of nothing, known to 1e-11 m/s and not to 1e-7 of itself."""
    three = replace(OF_2005, links=3)
    found = differentiate(three, DRY, replace(GAIT, alpha_rad=math.radians(30), beta_rad=0.0))
    by = dict(zip(found.names, found.derivatives, strict=True))
    assert abs(by["alpha_rad"][0]) < 1e-6
    assert by["alpha_rad"][1] > 0.05


def test_what_cannot_be_differentiated_is_named() -> None:
    with refused("does not move"):
        differentiate(OF_2005, DRY, replace(GAIT, alpha_rad=0.0))
    found = differentiate(OF_2005, VISCOUS, replace(GAIT, alpha_rad=math.pi))
    assert "alpha_rad" not in found.names
    assert "fn0" not in found.names


def test_derivatives_that_take_too_long_are_refused_with_a_way_out(monkeypatch) -> None:
    from serpenoid.base import long_calls

    monkeypatch.setattr(long_calls, "LIMIT_S", 0.0)
    with pytest.raises(sn.NotConverged, match="longer than 0 s; ask for the state without"):
        differentiate(OF_2005, DRY, GAIT)
