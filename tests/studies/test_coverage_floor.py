"""The floor study: sessions of pushes by the whole chain, counted."""

from __future__ import annotations

import json

import numpy as np
import pytest
from calibration_study import main
from coverage_floor import CASES, drawn_person
from coverage_treadmill import GAIT, WHOLE, DrivenTable
from serpenoid.calibration.speeds import AMPLITUDE_SIGMA, scaled
from serpenoid.calibration.taking.new_session import default_setup
from serpenoid.lab.crawl import crawl_speed
from serpenoid.periodic.servo_steady import band
from speed_table import SpeedTable

WITH_SERVOS = next(case for case in CASES if case.driven)


@pytest.mark.slow
def test_intervals_of_a_few_sessions_mostly_hold(tmp_path, monkeypatch) -> None:
    """One session of each kind: fewer than 80 % of all would be no intervals of 95 %."""
    asked = ["calibration_study.py", "floor", "--sessions", "1", "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", asked)
    main()
    rows = json.loads((tmp_path / "floor.json").read_text())
    assert len(rows) == len(CASES)
    for row in rows:
        assert row["sessions"] + row["refused"] == 1
        assert row["minutes"] < 35
    held = [row[name] for row in rows[:-1] for name in ("ct", "cn", "ft0", "fn0", "speed")]
    assert np.mean(held) > 0.8


@pytest.mark.slow
def test_the_driven_robot_and_its_band_have_the_same_servos() -> None:
    """Where friction is known exactly, the band of joints and servos holds drawn robots' speeds."""
    near = {"points": 64, "box": (0.9 * WHOLE, 1.1 * WHOLE), "kernel": "cubic"}
    robot = default_setup("band").robot
    driven = DrivenTable(robot, SpeedTable(robot, GAIT, **near), 256, **near)
    rng = np.random.default_rng(5)
    amplitudes = 1.0 + AMPLITUDE_SIGMA * rng.normal(size=256)
    low, high = band(driven(np.tile(WHOLE, (256, 1)), amplitudes, driven.shares))
    people = [drawn_person(WITH_SERVOS, np.random.default_rng([5, k])) for k in range(12)]
    speeds = [
        crawl_speed(p.robot, scaled(GAIT, a)) for p, a in zip(people, amplitudes, strict=False)
    ]
    held = [low <= v <= high for v in speeds]
    assert sum(held) >= 9
    assert np.std(speeds) > 0.15 * (high - low)  # and it is no wider than they scatter
