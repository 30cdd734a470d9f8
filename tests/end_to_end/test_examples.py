"""Every example runs and prints something."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import serpenoid

EXAMPLES_FOLDER = Path(__file__).resolve().parents[2] / "host" / "examples"
EXAMPLES, SCENES = sorted(EXAMPLES_FOLDER.glob("*.py")), sorted(EXAMPLES_FOLDER.glob("*.toml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example(path: Path, tmp_path) -> None:
    result = subprocess.run(
        [sys.executable, str(path)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip()


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_scene(path: Path) -> None:
    result = serpenoid("simulate", "--scene", path, "--json", check=True)
    assert json.loads(result.stdout)["displacement_m"] > 0.1
