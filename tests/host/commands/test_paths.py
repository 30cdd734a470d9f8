"""Paths to write to are refused before any work, and a figure is what its name says."""

from __future__ import annotations

import pytest
from command_line import serpenoid

GAIT = "--alpha-deg 30 --beta-deg 80 --omega-rad-s 5"
LONG = f"simulate --robot paper {GAIT} --duration-s 1e6 --no-error"  # would take minutes


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (f"{LONG} --out run.txt", "must end in .csv"),
        (f"{LONG} --plot absent/run.png", "'absent' is no folder"),
        (f"{LONG} --out folder.csv", "is a directory"),
        (f"{LONG} --out file/run.csv", "'file' is no folder"),
        (f"{LONG} --save-scene scene.json", "must end in .toml"),
        ("sweep --out absent/sweep.csv", "is no folder"),
        ("bench --out file", "file exists"),
        ("demo --out file/deeper", "not a directory"),
        ("sweep --out=", "must end in .csv or .npz"),
        ("fit ''", "session.toml"),
        (f"drive --port virtual {GAIT} --record absent/run.wire", "is no folder"),
    ],
)
def test_refused_before_any_work(line, said, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "file").write_text("")
    done = serpenoid(line)
    assert done.returncode in (1, 2)
    assert said in done.stderr
