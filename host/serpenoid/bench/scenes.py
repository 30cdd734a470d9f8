"""What each term of a scene costs: instructions per RK4 step, counted by callgrind, not timed."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from ..base.errors import SerpenoidError
from ..model.drives import Servo
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from .rows import write_rows

FORMULATIONS = ("explicit", "implicit")
STEPS = 20_000  # so many that the start of Python differs by less than ten instructions a step
STEP_S = 1e-3
_PROGRAM = "from serpenoid.bench.scenes import run_rung; run_rung(*{!r})"
_VALGRIND = ("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null")


@dataclass(frozen=True)
class Rung:
    """Hold one line of the ladder; its ratio is to the plain scene of its formulation."""

    formulation: str
    rung: str
    instructions_per_step: float
    ratio_to_plain: float


def ladder(formulation: str, steps: int) -> dict[str, Scene]:
    """Return the scenes by their rungs: the plain one, and others with one thing more each."""
    gait = Gait(math.radians(30), math.radians(80), 5.0)
    plain = Scene(
        Robot(6, 1.0, 0.12, 0.0012),
        Ground(0.1, 10.0),
        gait,
        formulation=formulation,
        method="rk4",
        dt_s=STEP_S,
        duration_s=STEP_S * steps,
        record_every=steps,
        gap="zero",
    )
    dry = replace(plain, ground=Ground(0.1, 10.0, 0.02, 0.05))
    incline = replace(dry, incline_rad=0.05)
    servo = replace(incline, drive="servo", servo=Servo())
    return {
        "viscous, level": plain,
        "Bingham friction": dry,
        "ratchet wheels, too": replace(dry, ground=Ground(0.1, 10.0, (0.02, 0.2), 0.05)),
        "Bingham friction, incline": incline,
        "servos, too": servo,
        "servos, recording forces": replace(servo, record_every=1, record=("joints", "friction")),
        "servos, energy ledger": replace(servo, record=("energy",)),
        "viscous, recording motion": replace(plain, record_every=1),
    }


def run_rung(formulation: str, rung: str, steps: int) -> None:
    """Run a rung's scene; `count` has this counted in a process of its own."""
    simulate(ladder(formulation, steps)[rung])


def count(formulation: str, rung: str, steps: int) -> int:
    """Return the instructions of a process that runs a rung's scene, its start included."""
    program = _PROGRAM.format((formulation, rung, steps))
    done = subprocess.run(
        [*_VALGRIND, sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=False,
    )
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if not collected:
        raise SerpenoidError(f"counting {rung!r} failed: {done.stderr.strip()[-2000:]}")
    return int(collected[1])


def measure(note: Callable[[str], object]) -> Iterator[Rung]:
    """Yield every rung of both formulations: of two runs, so that start and end cancel."""
    if not shutil.which(_VALGRIND[0]):
        raise SerpenoidError("valgrind is not there; install it (Debian: apt install valgrind)")
    for formulation in FORMULATIONS:
        plain = 0.0
        for rung in ladder(formulation, STEPS):
            note(f"{formulation}: {rung}")
            counts = [count(formulation, rung, k * STEPS) for k in (1, 2)]
            per_step = (counts[1] - counts[0]) / STEPS
            plain = plain or per_step  # the first rung
            yield Rung(formulation, rung, round(per_step), round(per_step / plain, 2))


def run(out: Path, note: Callable[[str], object]) -> list[Rung]:
    """Count all rungs, and write scenes.csv into out."""
    rungs = list(measure(note))
    out.mkdir(parents=True, exist_ok=True)
    write_rows(out / "scenes.csv", rungs)
    return rungs
