"""What the remade study says of the paper, held against runs in time."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from serpenoid.gaits import paper_study as study
from serpenoid.simulation.scene import Scene
from serpenoid.simulation.simulate import simulate


def test_a_finer_step_changes_next_to_nothing():
    assert study.finer_step((5.0,)) < 1e-6


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


def test_a_claim_follows_from_its_numbers():
    said = {c.paper: c.verdict for c in study._experiment([(0.2, 0.01, 0.04), (2.0, 0.2, 0.3)])}
    assert said["doubt about the normal friction is amplified at higher frequencies"] == "in part"
    said = {c.paper: c.verdict for c in study._experiment([(0.2, 0.01, 0.04), (2.0, 0.2, 0.21)])}
    assert said["doubt about the normal friction is amplified at higher frequencies"] == "differs"
