"""Output files are there whole or not at all, and a session's own files are never theirs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from serpenoid.commands.main import cli
from serpenoid.model.errors import BadInput, SerpenoidError
from serpenoid.model.files import visible, whole_file, write_csv

NIRAKH_2005 = Path(__file__).resolve().parents[3] / "calibration_data" / "nirakh-2005"
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


ENDED = """
import os, signal, sys
from pathlib import Path
from serpenoid.commands import main
from serpenoid.model.files import whole_file

def writes(**_):
    with whole_file(Path(sys.argv[1])) as part:
        part.write_text("half")
        os.kill(os.getpid(), signal.SIGTERM)

main.cli.main = writes
main.main()
"""


def test_sigterm_leaves_the_old_file_and_no_part(tmp_path: Path) -> None:
    file = tmp_path / "kept.csv"
    file.write_text("kept")
    done = subprocess.run([sys.executable, "-c", ENDED, file], check=False)
    assert done.returncode == 128 + 15
    assert [p.name for p in tmp_path.iterdir()] == ["kept.csv"]
    assert file.read_text() == "kept"


def test_a_fit_that_cannot_be_kept_is_shown_and_ends_with_1(tmp_path: Path) -> None:
    session = tmp_path / "session"
    shutil.copytree(NIRAKH_2005, session)
    (session / "fit.json").unlink(missing_ok=True)
    (session / "fit.json").mkdir()
    done = CliRunner().invoke(cli, ["fit", str(session)])
    assert "0.084" in done.output
    assert isinstance(done.exception, SerpenoidError)
    assert "not kept as fit.json" in str(done.exception)


def test_a_pipe_is_refused_where_a_film_is_asked_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "film.mp4")
    done = CliRunner().invoke(cli, ["video", "film", str(tmp_path / "film.mp4")])
    assert "a device, a pipe or a socket" in str(done.exception)


@pytest.mark.parametrize("command", ["new", "practice"])
def test_a_link_to_itself_is_no_folder_for_a_session(tmp_path: Path, command: str) -> None:
    (tmp_path / "loop").symlink_to("loop")
    done = CliRunner().invoke(cli, ["calibrate", command, str(tmp_path / "loop")])
    assert isinstance(done.exception, (OSError, SerpenoidError)), done.exception


def test_a_cell_without_end_is_no_csv(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(f"t_s,sent_deg\n{'x' * 131_073},1\n")
    done = CliRunner().invoke(cli, ["servo", "--test", str(tmp_path / "t.csv")])
    assert "t.csv:2: not CSV" in str(done.exception)


def test_long_text_from_outside_is_shortened_and_marks_of_direction_are_shown() -> None:
    error = str(BadInput(f"column {'k' * 70_000}; name it t_s"))
    assert len(error) < 2100
    assert error.startswith("column kkk")
    assert error.endswith("name it t_s")
    assert visible("a\u202eb\x1b") == "a\\u202eb\\x1b"


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


def test_an_error_names_the_file_that_was_asked_for(tmp_path) -> None:
    path = tmp_path / "absent" / "run.csv"
    with pytest.raises(OSError, match="No such file") as refused:
        write_csv(path, ["t_s"], [])
    assert refused.value.filename == str(path)
