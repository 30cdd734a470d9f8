"""Files: what is no regular file is refused at once; what is written is whole or not there."""

from __future__ import annotations

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import serpenoid as sn
from command_line import serpenoid
from refusals import refused
from robots import NIRAKH_2005, PAPER, VISCOUS


@pytest.mark.parametrize("path", ["/dev/zero", "/dev/tty", "/proc", "loop", "pipe", "a\0b", "no"])
def test_what_is_no_regular_file(tmp_path: Path, path: str, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    os.symlink("loop", "loop")
    with refused(r"regular file|No such|symbolic links|null byte"):
        sn.load_scene(path)


def test_a_large_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # a hole takes no room on the disk
    with refused(r"1099511627776 bytes; the most is 16000000;"):
        sn.load_fit(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "not JSON: maximum recursion"),
        ("[NaN]", "NaN is no number"),
        ("[" + 5000 * "9" + "]", "not JSON: Exceeds the limit"),
        ("", "not JSON"),
    ],
)
def test_json_that_is_none_of_ours(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "fit.json"
    path.write_text(text)
    with refused(message):
        sn.load_fit(path)


@pytest.mark.parametrize("values", [["1"], [10**400], [[1], [1, 2]], [True], None, [None], [1j]])
def test_what_is_no_array_of_numbers(values) -> None:
    with refused(r"alpha_rad is .*regular array"):
        sn.sweep(PAPER, VISCOUS, alpha_rad=values, beta_rad=1.0, omega_rad_s=1.0)


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """Return a file that is there already, alone in its folder."""
    file = tmp_path / "kept.toml"
    file.write_text("kept")
    return file


def test_what_was_there_stays_when_writing_fails(kept: Path, monkeypatch) -> None:
    scene = sn.Scene(PAPER, VISCOUS, sn.Gait(0.5, 1.0, 1.0))

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(sn.SerpenoidError, match=rf"{kept}: cannot be written: No space left"):
            sn.save_scene(scene, kept)
    assert kept.read_text() == "kept"
    link = kept.with_name("link.toml")
    link.symlink_to(kept)
    sn.save_scene(scene, link)
    assert link.is_symlink()
    assert sn.load_scene(kept).gait == scene.gait
    assert {p.name for p in kept.parent.iterdir()} == {"kept.toml", "link.toml"}


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
    assert [(p.name, p.read_text()) for p in kept.parent.iterdir()] == [("kept.toml", "kept")]


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


def test_long_text_from_outside_is_shortened() -> None:
    error = str(sn.BadInput(f"column {'k' * 70_000}; name it t_s"))
    assert len(error) < 2100
    assert error.startswith("column kkk")
    assert error.endswith("name it t_s")
