"""Extreme scenes by every method: a run meets the error it states, or stops and says why.

Outcomes: "met", the true error of places and angles is within 1.5 times the run's error_estimate;
"not settled", the run says that its estimate is no bound; "refused", "diverged" and "bad input",
it stopped and said so; "SILENTLY WRONG", "HANG", "NaN" and "CRASH" are defects. The truth is
SciPy's DOP853 on equations in plain NumPy; a scene that takes it too long has none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..model.gait import Gait
from ..model.ground import Ground
from ..simulation.scene import METHODS, Scene, objection
from ..simulation.simulate import simulate
from .child_process import Limited
from .problems import PAPER_GROUND, Array, Problem, gait_deg, paper_robot, reference, springs
from .scipy_peer import solve

DEFECTS = ("HANG", "NaN", "SILENTLY WRONG", "CRASH")  # Outcomes that no run may have.


@dataclass(frozen=True, slots=True)
class Outcome:
    """Hold what became of one run; stated and true error in body lengths and radians."""

    scene: str
    method: str
    outcome: str
    stated: float = math.nan
    error: float = math.nan
    text: str = ""


def extremes() -> tuple[Problem, ...]:
    """Return every extreme scene: the paper's scene of 5 s with fields changed, at a fixed step."""
    plain = Scene(
        paper_robot(),
        PAPER_GROUND,
        gait_deg(30, 80, 5),
        duration_s=5.0,
        start="link1_at_rest",
        record_every=10**9,
    )
    waves = Gait(math.radians(10), 4 * math.pi / 999, 5.0)  # two on a thousand links
    quick: dict[str, dict[str, Any]] = {
        "alpha 170 deg": {"gait": gait_deg(170, 80, 5), "duration_s": 1.0},
        "omega 100 rad/s": {"gait": gait_deg(30, 80, 100), "dt_s": 1e-4, "duration_s": 0.3},
        "cn/ct = 1e-6": {"ground": Ground(ct=10.0, cn=1e-5)},
        "cn/ct = 1e6": {"ground": Ground(ct=1e-5, cn=10.0)},
        "mass 1e3 kg": {"robot": paper_robot(mass_kg=1e3)},
        "k = 2.2e6, c = 1 at 1 ms": {"duration_s": 1.0, **springs(2.2e6, 1.0)},
        "hard stick": {"ground": Ground(0.1, 10.0, 5.0, 5.0), "gait": gait_deg(30, 80, 1)},
    }
    slower: dict[str, dict[str, Any]] = {
        "omega 0.01 rad/s": {"gait": gait_deg(30, 80, 0.01), "duration_s": 200.0, "dt_s": 1e-2},
        "mass 1e-6 kg": {"robot": paper_robot(mass_kg=1e-6), "duration_s": 0.1},
        "no friction, k = 1e3, c = 0": {
            "ground": Ground(0.0, 0.0),
            "duration_s": 20.0,
            **springs(1e3, 0.0),
        },
        "k = 1e9, c = 1e5": {"dt_s": 1e-4, "duration_s": 0.1, **springs(1e9, 1e5)},
        "1000 links": {"robot": paper_robot(1000), "gait": waves, "duration_s": 1.0},
        "an hour": {"dt_s": 1e-2, "duration_s": 3600.0},
    }
    return tuple(
        Problem(name, name, replace(plain, **changes), name in quick)
        for name, changes in (quick | slower).items()
    )


def _truth(problem: Problem) -> Array:
    dry = problem.scene.ground.dry
    return reference(problem)[0] if dry else solve(problem, "DOP853", tolerance=1e-11)


def outcome_of(problem: Problem, method: str, exact: Array | None) -> Outcome:
    """Run one method on one extreme scene and say what became of it; exact: the true end."""
    run = simulate(replace(problem.scene, method=method, start=problem.start))
    end, estimate = problem.vector(run.state()), run.error_estimate
    stated = estimate.integration.size(problem.scene.robot.body_length_m)
    error, word = math.nan, "no reference"
    if not np.isfinite(end).all() or math.isnan(stated):
        word = "NaN"
    elif not estimate.settled:
        word = "not settled"
    elif exact is not None:
        error = problem.error(end, exact, places_only=True)
        # The truth and rounding over many steps may be off by 1e-8.
        word = "met" if error <= 1.5 * stated + 1e-8 else "SILENTLY WRONG"
    return Outcome(problem.name, method, word, stated, error)


def measure(quick: bool, tell: Callable[[str], None]) -> Iterator[Outcome]:
    """Yield the outcome of every extreme scene by every method that runs it.

    Truths may take 6 s of processor time, a run with the finer ones that tell its error 20 s.
    """
    # What a note begins with; any other is a crash.
    stopped = {
        "StepTooLarge": "refused",
        "Diverged": "diverged",
        "BadInput": "bad input",
        "HANG": "HANG",
    }
    with Limited() as child:
        for problem in extremes():
            if quick > problem.quick:
                continue
            tell(f"extreme scenes: {problem.name} ...")
            # no truth where it takes too long, or is refused as all methods will refuse it
            exact, _ = child(6.0, _truth, problem)
            for method in METHODS:
                if objection(method, problem.scene) is None:
                    outcome, note = child(20.0, outcome_of, problem, method, exact)
                    word, _, text = note.partition(": ")
                    word = stopped.get(word, "CRASH")
                    yield outcome or Outcome(problem.name, method, word, text=text)
