"""`bench floor`: sessions of pushes by the whole chain, counted."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner
from serpenoid.commands.main import cli


@pytest.mark.slow
def test_intervals_of_a_few_sessions_mostly_hold(tmp_path) -> None:
    """Twenty sessions of each kind: fewer than half would be no interval of 95 %."""
    asked = ["bench", "floor", "--sessions", "20", "--out", str(tmp_path)]
    done = CliRunner().invoke(cli, asked)
    assert done.exit_code == 0, done.output
    rows = json.loads((tmp_path / "floor.json").read_text())
    assert len(rows) == 3
    for row in rows:
        assert row["sessions"] + row["refused"] == 20
        assert min(row[name] for name in ("ct", "cn", "ft0", "fn0", "speed")) > 0.6
        assert row["minutes"] < 30
