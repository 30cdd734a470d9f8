"""What the remade study says of the paper, held against runs in time."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from serpenoid import Scene, simulate
from serpenoid.paper import study


def test_claims_of_optima_follow_from_the_front() -> None:
    """A front at the paper's own optimum agrees; one that leaves it does so in part or differs."""
    front = study.papers_front()

    def verdicts(alpha_deg: list[float], beta_deg: list[float]) -> dict[str, str]:
        moved = [
            replace(b, gait=replace(b.gait, alpha_rad=a * study.D, beta_rad=c * study.D))
            for b, a, c in zip(front, alpha_deg * 5, beta_deg * 5, strict=False)
        ]
        return {c.paper: c.verdict for c in study._optima(moved)}

    same, apart, off = (verdicts(*x) for x in (([30], [80]), ([30, 60], [80, 60]), ([80], [50])))
    for name in (
        "beta is 80 deg at every speed",
        "alpha is 30 deg at every speed",
        "1.3 waves on the body",
    ):
        assert (same[name], apart[name], off[name]) == ("agrees", "in part", "differs")
    assert same["for each speed one gait costs least"] == "agrees"
    assert off["for each speed one gait costs least"] == "differs"  # 80 deg is beyond the grid
    bent = [replace(b, gait=replace(b.gait, omega_rad_s=3.0)) for b in front]
    assert study._optima(bent)[1].verdict == "differs"


def test_dry_friction_along_the_links_is_no_small_matter():
    at = {frequency: speed for frequency, speed, _ in study.without_dry_friction_along()}
    gait = replace(study.EXPERIMENT, omega_rad_s=2 * math.pi)
    full, free = (
        simulate(
            Scene(study.OF_2005, ground, gait, dt_s=2e-3, duration_s=8.0, record_every=500)
        ).centre_m  # ends of eight whole periods
        for ground in (study.BINGHAM, replace(study.BINGHAM, ft0=0.0))
    )
    ratio = math.dist(free[-1], free[-2]) / math.dist(full[-1], full[-2])
    assert at[1.0] == pytest.approx(ratio - 1, abs=0.01)
    assert at[1.0] > 0.3
