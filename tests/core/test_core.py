"""The C++ tests of the core: release build, sanitizers, other compilers; clang-tidy."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

CORE = Path(__file__).parents[2] / "host" / "core"
WINE, DOCTEST = "/usr/lib/wine/wine64", "/usr/include/doctest/doctest.h"
# Name -> (options of CMake, required programs and files).
BUILDS = {
    "shipped": (["-DCMAKE_BUILD_TYPE=Release"], []),
    "sanitizers": (
        [
            "-DCMAKE_BUILD_TYPE=Debug",
            "-DCMAKE_CXX_FLAGS=-O1 -fsanitize=address,undefined -fno-sanitize-recover=all",
        ],
        [],
    ),
    "clang": (
        ["-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_CXX_FLAGS=-O1 -stdlib=libc++ -pedantic-errors"],
        ["clang++", "/usr/share/doc/libc++-dev", "/usr/share/doc/libc++abi-dev"],
    ),
    # As on Windows, where MSVC has no vector extensions.
    "windows": (
        [
            "-DCMAKE_SYSTEM_NAME=Windows",
            "-DCMAKE_CXX_COMPILER=x86_64-w64-mingw32-g++-posix",
            "-DCMAKE_CXX_FLAGS=-O1 -DSERPENOID_PLAIN_PACKS",
            "-DCMAKE_EXE_LINKER_FLAGS=-static",
            f"-DCMAKE_CROSSCOMPILING_EMULATOR={WINE}",
        ],
        ["x86_64-w64-mingw32-g++-posix", WINE],
    ),
}

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("build", BUILDS)
def test_the_core_passes_its_own_tests(build: str, tmp_path: Path) -> None:
    options, required = BUILDS[build]
    required = ["cmake", "ctest", DOCTEST, *required]
    if absent := [p for p in required if not (shutil.which(p) or Path(p).exists())]:
        pytest.skip(f"needs {' and '.join(absent)}; see tests/core/packages.txt")
    wine = {"WINEDEBUG": "-all", "WINEPREFIX": str(tmp_path / "wine")}
    for command in (
        ["cmake", "-S", str(CORE), "-B", str(tmp_path), *options],
        ["cmake", "--build", str(tmp_path), "--parallel", str(os.cpu_count())],
        ["ctest", "--test-dir", str(tmp_path), "--output-on-failure"],
    ):
        result = subprocess.run(
            command, capture_output=True, text=True, check=False, env=os.environ | wine
        )
        assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-3000:]
        assert "warning:" not in result.stderr


# Excluded: checks that find no faults here, equal branches, and sizeof of a pack.
RULES = (
    "-*,bugprone-*,-bugprone-easily-swappable-parameters,-bugprone-narrowing-conversions,"
    "-bugprone-implicit-widening-of-multiplication-result,-bugprone-branch-clone,"
    "-bugprone-sizeof-expression"
)


@pytest.mark.skipif(not shutil.which("clang-tidy"), reason="needs clang-tidy")
def test_clang_tidy_finds_nothing() -> None:
    sources = [
        str(p) for p in CORE.rglob("*.cpp") if p.parent.name not in ("python", "web", "board")
    ]
    folders = [f"-I{CORE}", f"-I{CORE.parents[1]}/firmware/lib/gait"]
    command = ["clang-tidy", "--quiet", f"--checks={RULES}", *sources, "--", "-std=c++20", *folders]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout) == (0, "")
