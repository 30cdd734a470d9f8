"""The types of the compiled core are generated, and compared with those that are kept."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "host" / "serpenoid" / "_core"


def test_the_stubs_are_those_of_the_core(tmp_path):
    subprocess.run([sys.executable, ROOT / ".ci" / "stubs", tmp_path], check=True)
    generated = {path.name: path.read_text() for path in tmp_path.glob("*.pyi")}
    stored = {path.name: path.read_text() for path in KEPT.glob("*.pyi")}
    assert generated.keys() == stored.keys() == {"__init__.pyi", "firmware.pyi"}
    for name, text in generated.items():
        assert text == stored[name], f"renew it: .ci/stubs {KEPT.relative_to(ROOT)}"
