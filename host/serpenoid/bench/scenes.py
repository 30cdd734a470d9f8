"""What each term of a scene costs: instructions per RK4 step, counted by callgrind, not timed."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from ..model.errors import SerpenoidError
from .rows import write_rows

SOURCE = Path(__file__).resolve().parents[2]  # host/, of a checkout
LADDER = SOURCE.parent / "studies" / "ladder"
RUNGS = {
    "by hand": "viscous, level, written by hand",
    "viscous": "viscous, level",
    "bingham": "+ Bingham friction",
    "ratchet": "the same, on ratchet wheels",
    "incline": "+ incline",
    "servo": "+ servos",
    "record forces": "+ recording forces each step",
    "energy ledger": "+ energy ledger (no record)",
    "record motion": "viscous, level, recording each step",
}
FORMULATIONS = ("explicit", "implicit")
STEPS = 500
VALGRIND = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null")
_OTHERS = ("python", "board", "lab", "web")  # rooms of the core that no run needs
# as in CMakeLists.txt
FLAGS = (
    "-std=c++20",
    "-O3",
    "-DNDEBUG",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
)


@dataclass(frozen=True)
class Rung:
    """Hold one line of the ladder; its ratio is to the kernel by hand for the plain scene."""

    formulation: str
    rung: str
    title: str
    instructions_per_step: float
    ratio_to_hand: float


def _run(command: list[str], what: str) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SerpenoidError(f"{what} failed: {done.stderr.strip()[-2000:]}")
    return done


def _needed() -> None:
    for tool, package in (("valgrind", "valgrind"), ("g++", "g++")):
        if not shutil.which(tool):
            raise SerpenoidError(f"{tool} is not there; install it (Debian: apt install {package})")
    if not (SOURCE / "core" / "run" / "simulation.cpp").exists():
        raise SerpenoidError("bench scenes compiles the core; run it in a checkout of the source")


def parts() -> tuple[list[Path], list[str]]:
    """Return the sources of the ladder's program, and where their headers are."""
    core, firmware = SOURCE / "core", SOURCE.parent / "firmware" / "lib"
    sources = [p for p in sorted(core.rglob("*.cpp")) if p.parent.name not in _OTHERS]
    sources += [*sorted(firmware.glob("gait/*.cpp")), LADDER / "ladder.cpp"]
    return sources, [f"-I{core}", f"-I{firmware / 'gait'}", f"-I{firmware / 'avr'}"]


def build(folder: Path) -> Path:
    """Compile the core and the ladder into a folder and return the program."""
    sources, include = parts()
    program = folder / "ladder"
    command = ["g++", *FLAGS, *include, *map(str, sources), "-o", str(program)]
    _run(command, "compiling the core and the ladder")
    return program


def measure(program: Path, note: Callable[[str], object]) -> Iterator[Rung]:
    """Yield every rung of both formulations: of two runs, so that start and end cancel."""
    for formulation in FORMULATIONS:
        hand = 0.0
        for rung, title in RUNGS.items():
            note(f"{formulation}: {title}")
            counts = []
            for steps in (STEPS, 2 * STEPS):
                run = [*VALGRIND, str(program), formulation, rung, str(steps)]
                said = _run(run, f"rung {rung!r}").stderr
                collected = re.search(r"Collected : (\d+)", said)
                if not collected:
                    raise SerpenoidError(f"callgrind printed no count for {rung!r}: {said[-500:]}")
                counts.append(int(collected[1]))
            count = (counts[1] - counts[0]) / STEPS
            hand = hand or count  # the first rung
            yield Rung(formulation, rung, title, round(count, 1), round(count / hand, 3))


def run(out: Path, note: Callable[[str], object]) -> list[Rung]:
    """Build, count, and write scenes.csv into out."""
    _needed()
    with tempfile.TemporaryDirectory() as folder:
        note("compiling the core (about a minute)")
        rungs = list(measure(build(Path(folder)), note))
    out.mkdir(parents=True, exist_ok=True)
    write_rows(out / "scenes.csv", rungs)
    return rungs
