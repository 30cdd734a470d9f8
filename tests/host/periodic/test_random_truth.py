"""Random robots of 2 to 99 links on random ground, against integrations by other code."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn

TABLE = Path(__file__).parents[2] / "oracle" / "periodic_random.csv"


def rows() -> list[dict[str, float]]:
    with TABLE.open(newline="") as file:
        found = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    assert len(found) > 30
    return found


def solved(v: dict[str, float], rtol: float) -> sn.Steady:
    robot = sn.Robot(int(v["links"]), v["mass_kg"], 2 * v["half_length_m"])
    ground = sn.Ground((v["ct"], v["ct_back"]), v["cn"], (v["ft0"], v["ft0_back"]), v["fn0"])
    gait = sn.Gait(v["alpha_rad"], v["beta_rad"], v["omega_rad_s"], v["offset_rad"])
    return sn.steady_gait(robot, ground, gait, rtol=rtol)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_errors_are_within_their_claims(rtol: float) -> None:
    """None is off by more than it claims: 0.98 of it at most."""
    over = []
    for v in rows():
        s = solved(v, rtol)
        size = s.gait.omega_rad_s * s.robot.body_length_m
        # the table's own: its shortest steps (order one), and what its quadrature of powers misses
        missed = (3 * v["work_missed"] + 3e-7) * v["positive_power_w"]
        ratios = [
            (abs(s.speed_m_s - v["speed_m_s"]) - 1e-8 * size)
            / (s.error_estimate * max(v["speed_m_s"], 1e-4 * size)),
            (abs(s.power_w - v["power_w"]) - 1e-7 * v["power_w"]) / s.power_error_w,
            (abs(s.positive_power_w - v["positive_power_w"]) - missed) / s.positive_power_error_w,
        ]
        over.append(max(ratios))
        assert abs(s.turn_rad_per_cycle - v["turn_rad_per_cycle"]) <= s.turn_error_rad + 3e-7
        assert s.error_estimate <= max(rtol, rtol * 1e-4 * size / max(v["speed_m_s"], 1e-300))
    assert max(over) < 1.5
    assert np.mean(np.array(over) > 1) <= 0.02


def drawn(rng: np.random.Generator, kind: str) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    """Return a random robot; friction spans what outweighs inertia and what hardly counts."""

    def log(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    links, mass, omega = int(log(2, 20.99)), log(0.01, 1), log(0.2, 30)
    cn = mass * omega * log(0.05, 50)
    ct, fn0 = cn * log(0.003, 1), 9.81 * mass * log(0.02, 1)
    ft0 = fn0 * log(0.01, 1)
    ground = sn.Ground(ct, cn, ft0, fn0)
    if kind == "viscous":
        ground = sn.Ground(ct, cn)
    if kind == "ratchet":
        ground = sn.Ground((ct, ct * log(1, 100)), cn, (ft0, ft0 * log(1, 50)), fn0)
    offset = 0.0 if rng.random() < 0.5 else rng.uniform(-0.3, 0.3)
    gait = sn.Gait(rng.uniform(0.1, 1.4), rng.uniform(0.2, 2.6), omega, offset)
    return sn.Robot(links, mass, log(0.02, 0.3)), ground, gait


def claims_used(s: sn.Steady, fine: sn.Steady) -> dict[str, float]:
    """Return how much of its claim each figure is off from a finer state's."""
    size = 1e-4 * s.gait.omega_rad_s * s.robot.body_length_m

    def speed(state: sn.Steady) -> float:
        return state.error_estimate * max(state.speed_m_s, size)

    pairs = {
        "speed_m_s": speed(s) + speed(fine),
        "settling_time_s": s.settling_error * s.settling_time_s
        + fine.settling_error * fine.settling_time_s,
        "turn_rad_per_cycle": s.turn_error_rad + fine.turn_error_rad,
    }
    for name in ("power_w", "abs_power_w", "positive_power_w"):
        error = name.removesuffix("_w") + "_error_w"
        pairs[name] = getattr(s, error) + getattr(fine, error)
    if s.radius_error_m < np.inf and fine.radius_error_m < np.inf and s.gait.offset_rad:
        pairs["radius_m"] = s.radius_error_m + fine.radius_error_m
    return {
        name: abs(getattr(s, name) - getattr(fine, name)) / (claim + 1e-300)
        for name, claim in pairs.items()
    }


@pytest.mark.parametrize(("kind", "seed"), [("viscous", 41), ("dry", 42), ("ratchet", 43)])
def test_states_of_loose_tolerances_are_as_near_as_they_claim_to_tight_ones(
    kind: str, seed: int
) -> None:
    """Before claims saw what they see now, a state in forty was out, by up to 400 times."""
    rng = np.random.default_rng(seed)
    used = []
    for _ in range(40):
        robot, ground, gait = drawn(rng, kind)
        try:
            fine = sn.steady_gait(robot, ground, gait, rtol=1e-10 if ground.smooth else 1e-7)
            states = [sn.steady_gait(robot, ground, gait, rtol=r) for r in (1e-2, 1e-4)]
        except sn.NotConverged:
            continue
        used += [claims_used(s, fine) for s in states]
    assert len(used) > 60
    most = [max(one.values()) for one in used]
    assert max(most) < 3, used[int(np.argmax(most))]
    assert np.mean(np.array(most) > 1) <= 0.04  # seven figures each, a state in a hundred or less
