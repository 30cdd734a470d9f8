"""Files from outside: what is no regular file, too large or damaged is refused, and at once."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from refusals import refused
from serpenoid.base.files import check_file, read_json, read_text
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
