"""Paths to write to are refused before any work, and a figure is what its name says."""

from __future__ import annotations

import pytest
from click.testing import CliRunner
from serpenoid.commands.main import cli

GAIT = ["--robot", "paper", "--alpha-deg", "30", "--beta-deg", "80", "--omega-rad-s", "5"]
LONG = ["simulate", *GAIT, "--duration-s", "1e6", "--no-error"]  # would take minutes


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([*LONG, "--out", "run.txt"], "must end in .csv"),
        ([*LONG, "--plot", "run.gif"], "must end in .png or .pdf or .svg"),
        ([*LONG, "--plot", "absent/run.png"], "'absent' is not there"),
        ([*LONG, "--out", "folder.csv"], "is a folder"),
        ([*LONG, "--out", "file/run.csv"], "is a file, not a folder"),
        ([*LONG, "--save-scene", "scene.json"], "must end in .toml"),
        (["sweep", "--out", "absent/sweep.csv"], "is not there"),
        (["bench", "accuracy", "--out", "file"], "is a file"),
        (["demo", "--out", "file/deeper"], "is a file"),
        (["demo", "--out", ""], "the name is empty"),
        (["sweep", "--out", ""], "the name is empty"),
        (["fit", ""], "the name is empty"),
        (["drive", "--port", "virtual", *GAIT[2:], "--record", "absent/run.wire"], "is not there"),
    ],
)
def test_refused_before_any_work(arguments, said, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "file").write_text("")
    done = CliRunner().invoke(cli, arguments)
    assert done.exit_code == 2, done.output
    assert said in " ".join(done.output.split())


@pytest.mark.parametrize(
    ("suffix", "head"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?x")]
)
def test_a_figure_is_what_its_name_says(suffix, head, tmp_path) -> None:
    path = tmp_path / f"run.{suffix}"
    done = CliRunner().invoke(
        cli, ["simulate", *GAIT, "--duration-s", "0.1", "--no-error", "--plot", str(path)]
    )
    assert done.exit_code == 0, done.output
    assert path.read_bytes().startswith(head)
