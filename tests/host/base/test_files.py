"""Files: what is no regular file is refused at once; what is written is whole or not there."""

from __future__ import annotations

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import serpenoid
from refusals import refused
from robots import NIRAKH_2005
from serpenoid import BadInput
from serpenoid.base.files import check_file, read_json, read_text, visible, whole_file, write_csv
from serpenoid.base.vectors import number_array


@pytest.mark.parametrize("path", ["/dev/zero", "/dev/tty", "/proc", "loop", "pipe", "a\0b", "no"])
def test_what_is_no_regular_file(tmp_path: Path, path: str, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    os.symlink("loop", "loop")
    for read in (check_file, read_text, read_json):
        with refused(r"regular file|No such|symbolic links|null byte"):
            read(Path(path))


def test_a_large_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # a hole takes no room on the disk
    with refused(r"1099511627776 bytes; the most is 16000000;"):
        read_text(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "lists in lists without end"),
        ("[NaN]", "NaN is no number"),
        ("[-Infinity]", "-Infinity is no number"),
        ("[" + 5000 * "9" + "]", "not JSON: Exceeds the limit"),
        ("", "not JSON"),
    ],
)
def test_json_that_is_none_of_ours(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "x.json"
    path.write_text(text)
    with refused(message):
        read_json(path)


@pytest.mark.parametrize("values", [["1"], [10**400], [[1], [1, 2]], [True], None, [None], [1j]])
def test_what_is_no_array_of_numbers(values) -> None:
    with refused(r"alpha_rad is .*regular array"):
        number_array("alpha_rad", values)
    assert number_array("x", [1, 10**20]).tolist() == [1.0, 1e20]


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """Return a file that is there already, alone in its folder."""
    file = tmp_path / "kept.csv"
    file.write_text("kept")
    return file


def test_what_was_there_stays_when_writing_fails(kept: Path) -> None:
    def half() -> None:
        with whole_file(kept) as part:
            part.write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        half()
    assert kept.read_text() == "kept"
    link = kept.with_name("link.csv")
    link.symlink_to(kept)
    write_csv(link, ["a"], [[1]])
    assert link.is_symlink()
    assert kept.read_text().split() == ["a", "1"]
    assert {p.name for p in kept.parent.iterdir()} == {"kept.csv", "link.csv"}


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


def test_sigterm_leaves_the_old_file_and_no_part(kept: Path) -> None:
    done = subprocess.run([sys.executable, "-c", ENDED, kept], check=False)
    assert done.returncode == 128 + 15
    assert [(p.name, p.read_text()) for p in kept.parent.iterdir()] == [("kept.csv", "kept")]


def test_an_error_names_the_file_that_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "absent" / "run.csv"
    with pytest.raises(OSError, match="No such file") as error:
        write_csv(path, ["t_s"], [])
    assert error.value.filename == str(path)
    full = tmp_path / "full.csv"
    with pytest.raises(OSError, match="No space") as error, whole_file(full):
        raise OSError(errno.ENOSPC, "No space left on device")  # as a write says it, without a name
    assert error.value.filename == str(full)


def test_a_fit_that_cannot_be_kept_is_shown_and_ends_with_1(tmp_path: Path) -> None:
    session = tmp_path / "session"
    shutil.copytree(NIRAKH_2005, session)
    (session / "fit.json").unlink(missing_ok=True)
    (session / "fit.json").mkdir()
    done = serpenoid("fit", session)
    assert "0.084" in done.stdout
    assert (done.returncode, "fit.json" in done.stderr) == (1, True)


def test_a_sessions_own_files_are_not_written_over(tmp_path: Path) -> None:
    for name in ("session.toml", "readings.csv"):
        (tmp_path / name).write_text("measured")
    grid = "sweep --robot paper --alpha-deg 30 --beta-deg 80 --omega-rad-s 5 --out"
    done = serpenoid(grid, tmp_path / "readings.csv")
    assert (done.returncode, "a session's own" in done.stderr) == (2, True)
    assert {p.read_text() for p in tmp_path.iterdir()} == {"measured"}


def test_long_text_from_outside_is_shortened_and_control_characters_are_shown() -> None:
    error = str(BadInput(f"column {'k' * 70_000}; name it t_s"))
    assert len(error) < 2100
    assert error.startswith("column kkk")
    assert error.endswith("name it t_s")
    assert visible("ab\x1b") == "ab\\x1b"
