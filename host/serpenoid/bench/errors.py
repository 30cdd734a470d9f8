"""Whether runs know how far they are off: random scenes, their estimates held against the truth.

The truth is a run by an exact method at a tolerance far below all that the judge itself uses; where
two of those disagree the motion has no truth, and the run must have been warned of. Runs in time
come on viscous and on dry ground, with wheels that stick, and with ratchets; periodic states are
held against a run in time that has forgotten its start.
"""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from ..model.drives import Servo
from ..model.errors import BadInput, Diverged, NotConverged, StepTooLarge
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, speed_floor_m_s, steady_gait
from ..simulation.judge import difference
from ..simulation.run import ENERGY_COLUMNS, Array, Run
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

IN_TIME = ("torque", "servo", "angle", "faults", "springs")
DRY = ("dry", "ratchet", "dry_torque", "dry_servo", "dry_faults")
STATES = ("viscous_states", "dry_states", "ratchet_states")
KINDS = (*IN_TIME, *DRY, *STATES)
_TRUTH, _OTHER_TRUTH = 1e-13, 1e-12  # tolerances
_FLOOR = 1e-10  # body lengths and radians: rounding, no error to estimate
_DRY_FLOOR = 1e-9  # on dry ground, where each change of mode is found to a rounding of its own
_STATE_FLOOR = 1e-8  # relative: what a settled run in time is good for
_MOST_CYCLES = 300
_POWERS = ("power", "abs_power", "positive_power")
MOST_S = 60.0  # of processor time for a case: one of some hundred dry truths never ends
_TELL_EVERY = 10  # runs


@dataclass(frozen=True, slots=True)
class Judged:
    """Hold one run's true error and its estimate, in body lengths or radians, the larger.

    true: nan where the motion has no truth (chaos). Of periodic states: of speed or a power,
    relative, whichever is worst beside its estimate. judged: False where it took too long; nothing
    is known of such a run.
    """

    kind: str
    scene: Scene
    true: float
    estimate: float
    settled: bool
    judged: bool = True

    @property
    def ratio(self) -> float:
        """Return true error over estimate; of errors that are not rounding."""
        return max(self.true, _FLOOR) / max(self.estimate, _FLOOR)

    @property
    def kept(self) -> bool:
        """Tell whether the true error is within three times the estimate, or was warned of."""
        return not self.judged or not self.settled or self.ratio <= 3


def random_scene(kind: str, rng: Generator) -> Scene:
    """Return a scene of a kind, one of IN_TIME or DRY, at a step or tolerance good or bad."""
    if kind in DRY:
        return _random_dry(kind, rng)
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
        more |= {"method": "rk4", "dt_s": float(step)}
    if kind == "angle" and rng.random() < 0.4:
        method = str(rng.choice(["collocation", "nonsmooth"]))
        more |= {
            "method": method,
            "tolerance": float(10 ** rng.uniform(-9, -3)),
            "incline_rad": 0.0,
        }
    return Scene(robot, ground, gait, **more)


def random_dry_ground(robot: Robot, ratchet: bool, rng: Generator) -> Ground:
    """Return wheels on a floor: dry friction as shares of a link's weight, less along than across.

    Ratchets: viscous alone, or with dry friction, up to thirty times as much backwards.
    """
    weight = 9.81 * robot.link_mass_kg
    ct, cn = 10 ** rng.uniform(-3, -1), 10 ** rng.uniform(-2, 0)
    ft0, fn0 = weight * 10 ** rng.uniform(-3, -1.3), weight * 10 ** rng.uniform(-1.3, -0.2)
    if not ratchet:
        return Ground(ct, cn, ft0, fn0)
    back = 10 ** rng.uniform(0.1, 1.5)
    if rng.random() < 0.3:
        return Ground((ct, back * ct), cn)
    return Ground((ct, back * ct), cn, (ft0, back * ft0), fn0)


def _random_dry(kind: str, rng: Generator) -> Scene:
    robot = Robot(int(rng.integers(2, 9)), 10 ** rng.uniform(-1.4, -0.3), rng.uniform(0.05, 0.12))
    ground = random_dry_ground(robot, kind == "ratchet", rng)
    gait = Gait(rng.uniform(0.1, 1.4), rng.uniform(0.3, 1.8), rng.uniform(0.5, 8))
    more = _joint_drive(kind.removeprefix("dry_"), robot, rng)
    if kind == "dry_torque":  # of the size at which wheels slide now and hold now
        size = ground.fn0 * robot.link_length_m * robot.links / 2
        more["torque"] = rng.normal(size=robot.links - 1) * size * 10 ** rng.uniform(-1.5, 0)
    if rng.random() < 0.6:
        more |= {"method": "nonsmooth", "tolerance": float(10 ** rng.uniform(-9, -3))}
    else:
        step = 10 ** rng.uniform(-4, -2) / (10 if kind == "dry_servo" else 1)
        more |= {"method": "rk4", "dt_s": float(step)}
    incline = float(rng.choice([0, 0, 0.05]))
    return Scene(
        robot, ground, gait, duration_s=float(rng.uniform(0.5, 4)), incline_rad=incline, **more
    )


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
        return {
            "formulation": "implicit",
            "joint_stiffness_n_m": k,
            "joint_damping_n_s_m": k * 10 ** rng.uniform(-3.5, -2),
        }
    return {}


def truth_scene(scene: Scene, tolerance: float) -> Scene:
    """Return the scene by the most accurate method for it, a step of its own grid apart."""
    method = "nonsmooth" if scene.law == "dry" else "dop853"
    return replace(scene, method=method, tolerance=tolerance, record=())


def random_case(kind: str, rng: Generator) -> tuple[Scene, float]:
    """Return a scene of a kind, and of a periodic state the relative accuracy to ask for."""
    if kind not in STATES:
        return random_scene(kind, rng), math.nan
    robot = Robot(int(rng.integers(2, 11)), 10 ** rng.uniform(-1.4, 0), rng.uniform(0.05, 0.15))
    ground = Ground(10 ** rng.uniform(-2.5, 0), 10 ** rng.uniform(-1, 1))
    if kind != "viscous_states":
        ground = random_dry_ground(robot, kind == "ratchet_states", rng)
    gait = Gait(rng.uniform(0.1, 1.4), rng.uniform(0.2, 2.2), 10 ** rng.uniform(-0.3, 1.2))
    return Scene(robot, ground, gait), float(10 ** rng.uniform(-6, -2))


def judge_random(kind: str, rng: Generator, most_s: float = MOST_S) -> Judged | None:
    """Judge one random case of a kind; None where it or its truth does not run.

    most_s: processor time, s, after which the case is given up.
    """
    scene, rtol = random_case(kind, rng)
    try:
        with _at_most(most_s):
            if kind in STATES:
                return judge_state(kind, scene.robot, scene.ground, scene.gait, rtol)
            return judge(kind, scene)
    except _TooLong:
        return Judged(kind, scene, math.nan, math.nan, settled=True, judged=False)


class _TooLong(Exception):
    """Raised when the processor time of a case is used up."""


@contextmanager
def _at_most(seconds: float) -> Iterator[None]:
    """Raise _TooLong after so much processor time, s; off the main thread there is no such limit.

    A run in the core looks for signals at every step, as it does for Ctrl-C.
    """
    if not hasattr(signal, "SIGPROF") or threading.current_thread() != threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise _TooLong

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def judge(kind: str, scene: Scene) -> Judged | None:
    """Hold a run's estimate against the truth; None where the scene or its truth does not run."""
    try:
        run = simulate(scene)
        truth, other = (simulate(truth_scene(scene, t)) for t in (_TRUTH, _OTHER_TRUTH))
    except (StepTooLarge, Diverged, BadInput):
        return None
    body = scene.robot.body_length_m
    true = difference(run, truth).size(body)
    floor = _FLOOR if scene.law == "viscous" else _DRY_FLOOR
    if difference(truth, other).size(body) > 0.3 * max(true, floor):
        true = math.nan
    return Judged(kind, scene, true, _estimate(run), run.error_estimate.settled)


def judge_state(kind: str, robot: Robot, ground: Ground, gait: Gait, rtol: float) -> Judged | None:
    """Hold a periodic state's estimates against a run in time from it; None where none settles.

    Steady says of a state that it did not reach what it is off by, too: that is judged like any.
    """
    try:
        found = steady_gait(robot, ground, gait, rtol=rtol)
    except NotConverged as error:
        if error.best is None:
            return None
        found = error.best
    cycles = 10 + 25 * found.settling_time_s / gait.period_s
    if cycles > _MOST_CYCLES:
        return None
    try:
        truths = np.vstack([_settled(found, math.ceil(cycles), t) for t in (1e-12, 1e-11)])
    except (Diverged, BadInput, NotConverged):
        return None
    claims = np.array(
        [
            found.error_estimate,
            *(getattr(found, f"{name}_error_w") / _size(truths[1][1:]) for name in _POWERS),
        ]
    )
    told = np.array([found.chord_m_s, *(getattr(found, f"{name}_w") for name in _POWERS)])
    floor = speed_floor_m_s(robot, gait.omega_rad_s)
    scale = np.array([max(truths[1][0], floor), *[_size(truths[1][1:])] * 3])
    true, doubt = abs(told - truths[1]) / scale, np.ptp(truths, axis=0) / scale
    true, claims = np.maximum(true, _STATE_FLOOR), np.maximum(claims, _STATE_FLOOR)
    known = doubt <= 0.1 * true
    if not known.any():
        return None
    worst = int(np.argmax(np.where(known, true / claims, 0)))
    return Judged(kind, Scene(robot, ground, gait), float(true[worst]), float(claims[worst]), True)


def _size(powers: Array) -> float:
    return float(max(abs(powers).max(), 1e-300))


def _settled(found: Steady, cycles: int, tolerance: float) -> Array:
    """Return chord speed, m/s, and the three powers, W, of a run's last two cycles, (2, 4)."""
    gait, period = found.gait, found.gait.period_s
    run = simulate(
        Scene(
            found.robot,
            found.ground,
            gait,
            start="steady",
            dt_s=period,
            record_every=1,
            duration_s=cycles * period,
            record=("energy",),
            tolerance=tolerance,
            method="dop853" if found.ground.smooth else "nonsmooth",
        )
    )
    work, positive = (
        np.diff(run.energy_j[-3:, ENERGY_COLUMNS.index(name)]) / period
        for name in ("joint_work_j", "positive_work_j")
    )
    way = np.hypot(*np.diff(run.centre_m[-3:], axis=0).T) / period
    return np.stack([way, work, 2 * positive - work, positive], axis=1)


def _estimate(run: Run) -> float:
    return run.error_estimate.integration.size(run.scene.robot.body_length_m)


def judge_class(
    count: int, seed: int, tell: Callable[[str], object], most_s: float = MOST_S
) -> Iterator[Judged]:
    """Judge so many random runs of every kind, and give up those that take longer than most_s."""
    for kind in KINDS:
        rng, found, given_up = np.random.default_rng([seed, KINDS.index(kind)]), 0, 0
        while found < count and given_up < max(count, 3):
            judged = judge_random(kind, rng, most_s)
            if judged is None:
                continue
            yield judged
            found, given_up = found + judged.judged, given_up + (not judged.judged)
            if not judged.judged:
                tell(f"{kind}: given up after {most_s:g} s of processor time: {judged.scene}")
            elif found % _TELL_EVERY == 0 and found < count:
                tell(f"{kind}: {found} of {count} runs")
        tell(f"{kind}: {found} runs")


def coverage_rows(runs: list[Judged]) -> list[dict[str, float | str]]:
    """Return, by kind and for all, which share of the runs is as far off as it says."""
    rows = []
    for kind in (*dict.fromkeys(r.kind for r in runs), "all"):
        some = [r for r in runs if kind in (r.kind, "all")]
        ratio = np.array([r.ratio for r in some if r.settled and not math.isnan(r.true)])
        rows.append(
            {
                "kind": kind,
                "runs": sum(r.judged for r in some),
                "within_estimate": float(np.mean(ratio <= 1)) if ratio.size else math.nan,
                "within_3": float(np.mean(ratio <= 3)) if ratio.size else math.nan,
                "worst_ratio": float(ratio.max()) if ratio.size else math.nan,
                "median_ratio": float(np.median(ratio)) if ratio.size else math.nan,
                "warned": sum(not r.settled for r in some),
                "unwarned_misses": sum(not r.kept for r in some),
                "given_up": sum(not r.judged for r in some),
            }
        )
    return rows
