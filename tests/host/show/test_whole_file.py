"""Output files are there whole or not at all, and a session's own files are never theirs."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from serpenoid.commands.main import cli
from serpenoid.show.figure_data import write_csv
from serpenoid.show.whole_file import whole_file

WISH = ["sweep", "--robot", "paper", "--alpha-deg", "30", "--beta-deg", "80", "--omega-rad-s", "5"]


def test_what_was_there_stays_when_writing_fails(tmp_path: Path) -> None:
    file = tmp_path / "kept.csv"
    file.write_text("kept")

    def half() -> None:
        with whole_file(file) as part:
            part.write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        half()
    assert [p.name for p in tmp_path.iterdir()] == ["kept.csv"]
    assert file.read_text() == "kept"
    write_csv(file, ["a"], [[1]])
    assert file.read_text().split() == ["a", "1"]
    assert [p.name for p in tmp_path.iterdir()] == ["kept.csv"]


def test_a_link_stays_one(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    real, link = tmp_path / "there" / "real.csv", tmp_path / "link.csv"
    real.write_text("old")
    link.symlink_to(real)
    write_csv(link, ["a"], [])
    assert link.is_symlink()
    assert real.read_text().split() == ["a"]


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".json", ".NPZ"])
def test_sweeps_of_every_kind_are_replaced(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"a{suffix}"
    file.write_text("old")
    assert CliRunner().invoke(cli, [*WISH, "--out", str(file)]).exit_code == 0
    assert file.stat().st_size > 100
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    "wish",
    [
        [*WISH, "--out", "readings.csv"],
        ["optimize", "--robot", "paper", "--speed", "0.1", "--plot", "readings.png"],
        [*WISH, "--out", "fit.json"],
    ],
)
def test_a_sessions_own_files_are_not_written_over(tmp_path: Path, wish: list[str]) -> None:
    for name in ("session.toml", "readings.csv", "fit.json"):
        (tmp_path / name).write_text("measured")
    done = CliRunner().invoke(cli, [*wish[:-1], str(tmp_path / wish[-1])])
    assert done.exit_code == 2
    assert "a session's readings" in done.output
    assert {p.read_text() for p in tmp_path.iterdir()} == {"measured"}
