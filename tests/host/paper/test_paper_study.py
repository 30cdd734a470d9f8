"""The verdicts on claims of the paper, and the effect of dry friction, compared with runs."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from serpenoid import Scene, simulate
from serpenoid.paper import study


def test_claims_of_optima_follow_from_the_front() -> None:
    """A front at the paper's optimum agrees, others agree in part or differ."""
    front = study.optima(study.ROBOT, study.GROUND, 0.7)

    def verdicts(alpha_deg: list[float], beta_deg: list[float]) -> dict[str, str]:
        moved = [
            replace(b, gait=replace(b.gait, alpha_rad=a * study.D, beta_rad=c * study.D))
            for b, a, c in zip(front, alpha_deg * 5, beta_deg * 5, strict=False)
        ]
        return {c.paper: c.verdict for c in study._optima(moved)}

    same = verdicts([30], [80])
    partial = verdicts([30, 60], [80, 60])
    different = verdicts([80], [50])
    for name in (
        "beta is 80 deg at every speed",
        "alpha is 30 deg at every speed",
        "1.3 waves on the body",
    ):
        assert (same[name], partial[name], different[name]) == ("agrees", "in part", "differs")
    assert same["for each speed one gait costs least"] == "agrees"
    # 80 deg is outside the grid.
    assert different["for each speed one gait costs least"] == "differs"
    constant_rate = [replace(b, gait=replace(b.gait, omega_rad_s=3.0)) for b in front]
    assert study._optima(constant_rate)[1].verdict == "differs"


def test_dry_friction_along_the_links_reduces_the_speed():
    change = {frequency: speed for frequency, speed, _ in study.without_dry_friction_along()}
    gait = replace(study.EXPERIMENT, omega_rad_s=2 * math.pi)
    full, free = (
        simulate(
            Scene(study.OF_2005, ground, gait, dt_s=2e-3, duration_s=8.0, record_every=500)
        ).centre_m  # at the ends of eight periods
        for ground in (study.BINGHAM, replace(study.BINGHAM, ft0=0.0))
    )
    ratio = math.dist(free[-1], free[-2]) / math.dist(full[-1], full[-2])
    assert change[1.0] == pytest.approx(ratio - 1, abs=0.01)
    assert change[1.0] > 0.3
