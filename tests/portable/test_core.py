"""The core is standard C++20: other compilers take it, and its states and motions are the same."""

from __future__ import annotations

import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
CORE, LIB = HERE.parents[1] / "host" / "core", HERE.parents[1] / "firmware" / "lib"
FLAGS = "-std=c++20 -O1 -pedantic-errors -Wall -Wextra -Wno-ignored-attributes -ffp-contract=off"
WINE = "/usr/lib/wine/wine64"
OTHERS = {
    "clang++ -stdlib=libc++": ("/usr/share/doc/libc++-dev", "/usr/share/doc/libc++abi-dev"),
    # as on Windows, where MSVC has no vectors
    "x86_64-w64-mingw32-g++-posix -static -DSERPENOID_PLAIN_PACKS": (WINE,),
}
SAME = 1e-12  # of a line's largest number
# A slide of a dry run ends at a backward speed of at most 0.1 x 1e-3 x the tolerance of 1e-6, over
# the gait's speed: 1e-10. Rounding chooses it, and Windows has its own sines. Ten ends may add up.
SAME_DRY = 1e-9

pytestmark = pytest.mark.slow


def run(*command: str | Path, folder: Path) -> str:
    settings = {"WINEDEBUG": "-all", "WINEPREFIX": str(folder / "wine"), "CCACHE_DISABLE": "1"}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | settings
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def lines(compiler: str, folder: Path) -> list[np.ndarray]:
    """Compile all of the core but its bindings and boards, a folder at a time; return its lines."""
    command = [*compiler.split(), *FLAGS.split(), *(f"-I{p}" for p in (CORE, *LIB.iterdir()))]
    sources = [HERE / "states_and_motions.cpp", *LIB.glob("gait/*.cpp"), *CORE.rglob("*.cpp")]
    units: dict[Path, str] = {}
    for source in sorted(sources):
        if source.parent.name not in ("python", "board"):
            unit = folder / f"{source.parent.name}.cpp"
            units[unit] = units.get(unit, "") + f'#include "{source}"\n'
    for unit, text in units.items():
        unit.write_text(text)

    def compiled(unit: Path) -> Path:
        run(*command, "-c", unit, "-o", unit.with_suffix(".o"), folder=folder)
        return unit.with_suffix(".o")

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compiled, units))
    program = folder / "states_and_motions.exe"
    run(*command, *objects, "-lpthread", "-o", program, folder=folder)
    wine = [WINE] if "mingw" in compiler else []
    printed = run(*wine, program, folder=folder)
    return [np.array(line.split(), dtype=np.float64) for line in printed.splitlines()]


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> list[np.ndarray]:
    return lines("g++", tmp_path_factory.mktemp("usual"))


@pytest.mark.parametrize("compiler", OTHERS)
def test_states_and_motions_are_the_same(usual, compiler: str, tmp_path) -> None:
    absent = [p for p in (compiler.split(maxsplit=1)[0], *OTHERS[compiler]) if not shutil.which(p)]
    if absent := [p for p in absent if not Path(p).exists()]:
        pytest.skip(f"needs {' and '.join(absent)}; see tests/portable/packages.txt")
    for k, (here, there) in enumerate(zip(usual, lines(compiler, tmp_path), strict=True)):
        assert here[0] == there[0] > 0, f"line {k}"
        same = SAME_DRY if k % 4 == 3 and "mingw" in compiler else SAME
        assert np.abs(here - there)[1:].max() <= same * np.abs(here[1:]).max(), f"line {k}"
