"""The truth that is kept beside the demo's film is what the lab finds today."""

from __future__ import annotations

import json

import pytest
from demo_film import FOLDER, truth, world


def test_the_kept_truth_is_the_labs() -> None:
    stored = json.loads((FOLDER / "truth.json").read_text())
    drawn_truth = truth(world())
    assert drawn_truth.keys() == stored.keys()
    for name, value in drawn_truth.items():
        assert stored[name] == pytest.approx(value, rel=1e-4, abs=1e-5), name
