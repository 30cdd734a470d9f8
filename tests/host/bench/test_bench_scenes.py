"""The ladder of scenes: every rung is a scene that runs, and is counted."""

from __future__ import annotations

import shutil

import pytest
from serpenoid.bench import scenes


@pytest.mark.parametrize("formulation", scenes.FORMULATIONS)
def test_every_rung_runs(formulation: str) -> None:
    for rung in scenes.ladder(formulation, 10):
        scenes.run_rung(formulation, rung, 10)


@pytest.mark.slow  # valgrind runs all of Python's start
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind is not installed")
def test_instructions_are_counted() -> None:
    assert scenes.count("explicit", "viscous, level", 20_000) > 20_000 * 2000
