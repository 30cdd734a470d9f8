"""The floor study: sessions of pushes by the whole chain, counted."""

from __future__ import annotations

import json

import numpy as np
import pytest
from calibration_study import main
from coverage_floor import CASES


@pytest.mark.slow
def test_intervals_of_a_few_sessions_mostly_hold(tmp_path, monkeypatch) -> None:
    """One session of each kind: fewer than 80 % of all would be no intervals of 95 %."""
    command = ["calibration_study.py", "floor", "--sessions", "1", "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", command)
    main()
    rows = json.loads((tmp_path / "floor.json").read_text())
    assert len(rows) == len(CASES)
    for row in rows:
        assert row["sessions"] + row["refused"] == 1
    flags = [row[name] for row in rows[:-1] for name in ("ct", "cn", "ft0", "fn0", "speed")]
    assert np.mean(flags) > 0.8
