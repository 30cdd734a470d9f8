"""What random runs say of their own error, held against the truth."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from serpenoid.bench.errors import KINDS, Judged, coverage_rows, judge_class
from serpenoid.commands.main import cli

SEED = 20261121


def misses(count: int) -> list[Judged]:
    """Return the runs that are further off than three times what they say, without a warning."""
    return [run for run in judge_class(count, SEED, lambda _: None) if not run.kept]


def test_random_runs_know_how_far_they_are_off() -> None:
    """Three of every kind: of so few none may miss."""
    assert misses(3) == []


@pytest.mark.slow
def test_many_random_runs_know_how_far_they_are_off() -> None:
    assert len(misses(100)) <= 0.01 * 100 * len(KINDS)


def test_a_miss_is_counted_unless_warned_of() -> None:
    (one, *_) = judge_class(1, SEED, lambda _: None)
    low = replace(one, true=1.0, estimate=0.1, settled=True)
    assert not low.kept
    assert replace(low, settled=False).kept
    assert replace(low, estimate=0.4).kept
    assert not replace(low, true=math.nan).kept
    row = coverage_rows([low, replace(low, settled=False)])[-1]
    assert (row["unwarned_misses"], row["warned"], row["within_3"]) == (1, 1, 0.0)


def test_the_command_publishes_the_coverage(tmp_path: Path) -> None:
    done = CliRunner().invoke(cli, ["bench", "errors", "--runs", "1", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    lines = (tmp_path / "errors.csv").read_text().splitlines()
    assert lines[0].startswith("kind,runs,within_estimate,within_3")
    assert lines[-1].startswith(f"all,{len(KINDS)},")
