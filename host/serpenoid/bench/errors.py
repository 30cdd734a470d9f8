"""Whether runs know how far they are off: random scenes, their estimates held against the truth.

The truth is a run by an exact method at a tolerance far below all that the judge itself uses; where
two of those disagree the motion has no truth, and the run must have been warned of.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from ..model.drives import Servo
from ..model.errors import BadInput, Diverged, StepTooLarge
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..simulation.judge import difference
from ..simulation.run import Run
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

KINDS = ("torque", "servo", "angle", "faults", "springs")
_TRUTH, _OTHER_TRUTH = 1e-13, 1e-12  # tolerances
_FLOOR = 1e-10  # body lengths and radians: rounding, no error to estimate
_BY_STEP = ("rk4", "rk4", "euler", "semi_implicit_euler")


@dataclass(frozen=True, slots=True)
class Judged:
    """Hold one run's true error and its estimate, in body lengths or radians, the larger.

    true: nan where the motion has no truth (chaos).
    """

    kind: str
    scene: Scene
    true: float
    estimate: float
    settled: bool

    @property
    def ratio(self) -> float:
        """Return true error over estimate; of errors that are not rounding."""
        return max(self.true, _FLOOR) / max(self.estimate, _FLOOR)

    @property
    def kept(self) -> bool:
        """Tell whether the true error is within three times the estimate, or was warned of."""
        return not self.settled or self.ratio <= 3


def random_scene(kind: str, rng: Generator) -> Scene:
    """Return a scene of a kind, one of KINDS, at a step or tolerance good or bad."""
    links = int(rng.integers(2, 9))
    robot = Robot(links, 10 ** rng.uniform(-1.2, 0), rng.uniform(0.05, 0.15))
    ground = Ground(10 ** rng.uniform(-2.5, 0), 10 ** rng.uniform(-1, 1))
    gait = Gait(rng.uniform(0.1, 1.2), rng.uniform(0.3, 1.8), rng.uniform(0.5, 8))
    more: dict[str, Any] = {
        "duration_s": float(rng.uniform(1, 15 if kind == "torque" else 6)),
        "incline_rad": float(rng.choice([0, 0.1])),
    }
    more |= _joint_drive(kind, robot, rng)
    if rng.random() < 0.5:
        more |= {"method": "dop853", "tolerance": float(10 ** rng.uniform(-9, -3))}
    else:
        step = 10 ** rng.uniform(-3.5, -1.8) / (10 if kind == "servo" else 1)
        more |= {"method": str(rng.choice(_BY_STEP)), "dt_s": float(step)}
    if kind == "angle" and rng.random() < 0.4:
        method = str(rng.choice(["collocation", "nonsmooth"]))
        more |= {"method": method, "tolerance": float(10 ** rng.uniform(-9, -3)),
                 "incline_rad": 0.0}  # fmt: skip
    return Scene(robot, ground, gait, **more)


def _joint_drive(kind: str, robot: Robot, rng: Generator) -> dict[str, Any]:
    joints = robot.links - 1
    if kind == "torque":
        weight = robot.link_mass_kg * robot.link_length_m**2
        return {"drive": "torque", "torque": rng.normal(size=joints) * weight * 3}
    if kind == "servo":
        stiff = robot.inertia_kg_m2 * 10 ** rng.uniform(2, 4)
        servo = Servo(stiff, stiff * rng.uniform(0.01, 0.1), stiff * rng.uniform(0.05, 1))
        return {"drive": "servo", "servo": servo}
    if kind == "faults":
        return {"limp": (int(rng.integers(1, joints + 1)),)}
    if kind == "springs":
        k = robot.link_mass_kg * 10 ** rng.uniform(2.5, 4)
        return {"formulation": "implicit", "joint_stiffness_n_m": k,
                "joint_damping_n_s_m": k * 10 ** rng.uniform(-3.5, -2)}  # fmt: skip
    return {}


def truth_scene(scene: Scene, tolerance: float) -> Scene:
    """Return the scene by the most accurate method for it, a step of its own grid apart."""
    method = "nonsmooth" if scene.law == "dry" else "dop853"
    return replace(scene, method=method, tolerance=tolerance, record=())


def judge(kind: str, scene: Scene) -> Judged | None:
    """Hold a run's estimate against the truth; None where the scene or its truth does not run."""
    try:
        run = simulate(scene)
        truth, other = (simulate(truth_scene(scene, t)) for t in (_TRUTH, _OTHER_TRUTH))
    except (StepTooLarge, Diverged, BadInput):
        return None
    body = scene.robot.body_length_m
    true = difference(run, truth).size(body)
    if difference(truth, other).size(body) > 0.3 * max(true, _FLOOR):
        true = math.nan
    return Judged(kind, scene, true, _estimate(run), run.error_estimate.settled)


def _estimate(run: Run) -> float:
    return run.error_estimate.integration.size(run.scene.robot.body_length_m)


def judge_class(count: int, seed: int, tell: Callable[[str], object]) -> Iterator[Judged]:
    """Judge so many random runs of every kind."""
    for kind in KINDS:
        rng, found = np.random.default_rng([seed, KINDS.index(kind)]), 0
        while found < count:
            judged = judge(kind, random_scene(kind, rng))
            if judged is not None:
                found += 1
                yield judged
        tell(f"{kind}: {count} runs")


def coverage_rows(runs: list[Judged]) -> list[dict[str, float | str]]:
    """Return, by kind and for all, which share of the runs is as far off as it says."""
    rows = []
    for kind in (*dict.fromkeys(r.kind for r in runs), "all"):
        some = [r for r in runs if kind in (r.kind, "all")]
        ratio = np.array([r.ratio for r in some if r.settled and not math.isnan(r.true)])
        rows.append({
            "kind": kind,
            "runs": len(some),
            "within_estimate": float(np.mean(ratio <= 1)) if ratio.size else math.nan,
            "within_3": float(np.mean(ratio <= 3)) if ratio.size else math.nan,
            "worst_ratio": float(ratio.max()) if ratio.size else math.nan,
            "median_ratio": float(np.median(ratio)) if ratio.size else math.nan,
            "warned": sum(not r.settled for r in some),
            "unwarned_misses": sum(not r.kept for r in some),
        })  # fmt: skip
    return rows
