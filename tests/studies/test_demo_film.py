"""The truth that is kept beside the demo's film is what the lab finds today."""

from __future__ import annotations

import json

import pytest
from demo_film import FOLDER, truth, world


def test_the_kept_truth_is_the_labs() -> None:
    kept = json.loads((FOLDER / "truth.json").read_text())
    found = truth(world())
    assert found.keys() == kept.keys()
    for name, value in found.items():
        assert kept[name] == pytest.approx(value, rel=1e-4, abs=1e-5), name
