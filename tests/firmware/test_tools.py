"""Compiler warnings, cppcheck and clang-tidy for the firmware; fuzzers of parser and controller."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def run(*command: str) -> None:
    result = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr[-4000:]


@pytest.mark.slow
@pytest.mark.avr
@pytest.mark.skipif(
    not (shutil.which("cppcheck") and shutil.which("clang-tidy")),
    reason="needs cppcheck and clang-tidy",
)
def test_no_warning_from_our_files(firmware_elf) -> None:
    firmware_elf("uno")  # It fetches the Servo library, without which firmware/src is not checked.
    run("firmware/check")


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("clang++"), reason="needs clang++ with libFuzzer")
def test_a_bounded_run_of_both_fuzzers_finds_nothing(tmp_path: Path) -> None:
    run("tests/firmware/fuzz/run", "runs=1000", str(tmp_path))
