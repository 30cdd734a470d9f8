"""Every example runs and prints something."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import serpenoid

FOLDER = Path(__file__).resolve().parents[2] / "host" / "examples"
EXAMPLES, SCENES = sorted(FOLDER.glob("*.py")), sorted(FOLDER.glob("*.toml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example(path: Path, tmp_path) -> None:
    done = subprocess.run(
        [sys.executable, str(path)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_scene(path: Path) -> None:
    done = serpenoid("simulate", "--scene", path, "--json", check=True)
    assert json.loads(done.stdout)["displacement_m"] > 0.1
