"""Output files are there whole or not at all, and a session's own files are never theirs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import serpenoid
from robots import NIRAKH_2005
from serpenoid import BadInput
from serpenoid.base.files import visible, whole_file, write_csv

WISH = "sweep --robot paper --alpha-deg 30 --beta-deg 80 --omega-rad-s 5 --out"


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
from serpenoid.base.files import whole_file

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
    done = serpenoid("fit", session)
    assert "0.084" in done.stdout
    assert done.returncode == 1
    assert "not kept as fit.json" in done.stderr


def test_a_pipe_is_refused_where_a_film_is_asked_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "film.mp4")
    refused = serpenoid("video film", tmp_path / "film.mp4").stderr
    assert "a device, a pipe or a socket" in refused


def test_a_link_to_itself_is_no_folder_for_a_session(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    assert serpenoid("calibrate new", tmp_path / "loop").returncode in (1, 2)


def test_a_cell_without_end_is_no_csv(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(f"t_s,setpoint_deg,angle_deg\n{'x' * 131_073},1,2\n")
    assert (
        "t.csv:2: t_s is no finite number" in serpenoid("servo --test", tmp_path / "t.csv").stderr
    )


def test_long_text_from_outside_is_shortened_and_control_characters_are_shown() -> None:
    error = str(BadInput(f"column {'k' * 70_000}; name it t_s"))
    assert len(error) < 2100
    assert error.startswith("column kkk")
    assert error.endswith("name it t_s")
    assert visible("ab\x1b") == "ab\\x1b"


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".NPZ"])
def test_sweeps_of_every_kind_are_replaced(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"a{suffix}"
    file.write_text("old")
    serpenoid(WISH, file, check=True)
    assert file.stat().st_size > 100
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("wish", "file"),
    [
        (WISH, "readings.csv"),
    ],
)
def test_a_sessions_own_files_are_not_written_over(tmp_path: Path, wish: str, file: str) -> None:
    for name in ("session.toml", "readings.csv", "fit.json"):
        (tmp_path / name).write_text("measured")
    done = serpenoid(wish, tmp_path / file)
    assert done.returncode == 2
    assert "a session's readings" in done.stderr
    assert {p.read_text() for p in tmp_path.iterdir()} == {"measured"}


def test_an_error_names_the_file_that_was_asked_for(tmp_path) -> None:
    path = tmp_path / "absent" / "run.csv"
    with pytest.raises(OSError, match="No such file") as refused:
        write_csv(path, ["t_s"], [])
    assert refused.value.filename == str(path)
