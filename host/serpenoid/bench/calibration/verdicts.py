"""How often `compare`'s verdict is right: sessions by the real procedure, runs with a known fault.

A session is taken on the simulated treadmill and fitted. Then the robot crawls, with a fault that
is known; the speeds are measured with tape and stopwatch as in a session. The joints' amplitude is
each time another, as far off as the comparison is told that it may be.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...calibration.friction_fit import fit_friction
from ...calibration.friction_result import ground_of
from ...calibration.speed_samples import AMPLITUDE_SIGMA, sample_speeds, scaled, speed
from ...calibration.taking.memory import MemoryRecord
from ...calibration.taking.new_session import default_setup
from ...calibration.taking.simulated import RUN_M, RUN_S, SimulatedTreadmill, drawn_truth
from ...calibration.taking.treadmill import take_all
from ...calibration.verdict import Judge, Measured
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.scene import Scene
from ...simulation.simulate import simulate
from .coverage import INCLINE_STEP_DEG, WHOLE, WHOLE_2005, shown_in_steps

Array = NDArray[np.float64]
WORDS = ("agrees", "friction", "amplitude", "friction or amplitude", "neither")
_CYCLES, _POINTS, _MOST_SIGMAS = 4, 9, 3.0


@dataclass(frozen=True)
class Fault:
    """What is wrong when the robot crawls; right: the verdict that would be right.

    frictions: shares of ct, cn, ft0, fn0 at the treadmill. amplitude: share of the joints'.
    uphill_deg: of the ground. ruler: true length of a metre that the tape shows. beta: share of
    the phase lag.
    """

    name: str
    right: str
    frictions: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    amplitude: float = 1.0
    uphill_deg: float = 0.0
    ruler: float = 1.0
    beta: float = 1.0

    def speeds(self, robot: Robot, gaits: Sequence[Gait], amplitude: float) -> list[float]:
        """Return the speeds measured without error, m/s."""
        ground = ground_of(robot.links, (np.array(self.frictions) * WHOLE).tolist())
        made = [scaled(g, amplitude * self.amplitude) for g in gaits]
        made = [replace(g, beta_rad=g.beta_rad * self.beta) for g in made]
        if self.uphill_deg:
            return [uphill_speed(robot, ground, g, math.radians(self.uphill_deg)) for g in made]
        return [speed(robot, ground, g) / self.ruler for g in made]


FAULTS = (
    Fault("nothing", "agrees"),
    *(Fault(f"ft0 {share - 1:+.0%}", "friction", (1.0, 1.0, share, 1.0))
      for share in (0.6, 0.8, 1.1, 1.2, 1.4)),
    *(Fault(f"fn0 {share - 1:+.0%}", "friction", (1.0, 1.0, 1.0, share))
      for share in (0.6, 0.8, 0.9, 1.2, 1.4)),
    *(Fault(f"amplitude {share - 1:+.0%}", "amplitude", amplitude=share)
      for share in (0.7, 0.8, 0.85, 0.9, 0.95, 1.1)),
    *(Fault(f"tape {ruler - 1:+.0%}", "neither", ruler=ruler) for ruler in (0.8, 0.9, 1.1, 1.25)),
    Fault("phase lag -15%", "neither", beta=0.85),
    *(Fault(f"{slope:g} deg uphill", "friction", uphill_deg=slope) for slope in (0.25, 0.5, 1.0)),
)  # fmt: skip


@dataclass(frozen=True)
class Verdicts:
    """How often each verdict was given where one fault was there; right: the one wanted.

    seen: share of sessions that the fault was noticed in at all. named: share of these in which
    the right cause was named, alone or as one of two.
    """

    fault: str
    right: str
    sessions: int
    counts: dict[str, int]
    seen: float
    named: float | None


def uphill_speed(robot: Robot, ground: Ground, gait: Gait, slope_rad: float) -> float:
    """Return the speed of a robot that sets out straight up a slope, m/s, at least 0."""
    level = _way(robot, ground, gait, 0.0, 0.0)
    heading = math.atan2(level[1], level[0])
    up = _way(robot, ground, gait, slope_rad, heading)
    forward = float(up @ [math.cos(heading), math.sin(heading)])
    return max(forward, 0.0) / (_CYCLES * gait.period_s)


def _way(robot: Robot, ground: Ground, gait: Gait, slope_rad: float, heading: float) -> Array:
    per_cycle = 4
    run = simulate(Scene(
        robot, ground, gait, method="nonsmooth", dt_s=gait.period_s / 400,
        duration_s=2 * _CYCLES * gait.period_s, record_every=400 // per_cycle,
        incline_rad=slope_rad, incline_direction_rad=heading,
    ))  # fmt: skip
    centre = np.asarray(run.centre_m)
    return centre[-1] - centre[-1 - _CYCLES * per_cycle]


class TrueSpeeds:
    """Speeds of every fault over the amplitude that the joints happen to have, interpolated."""

    def __init__(self, robot: Robot, gaits: Sequence[Gait], faults: Sequence[Fault]):
        most = _MOST_SIGMAS * AMPLITUDE_SIGMA
        self._at = np.linspace(1.0 - most, 1.0 + most, _POINTS)
        self._of = {f.name: np.array([f.speeds(robot, gaits, a) for a in self._at.tolist()])
                    for f in faults}  # fmt: skip

    def __call__(self, fault: Fault, amplitude: float) -> Array:
        """Return the speeds of the gaits, m/s."""
        return np.array([np.interp(amplitude, self._at, v) for v in self._of[fault.name].T])


def words(job: tuple[tuple[Fault, ...], int, TrueSpeeds]) -> dict[str, str]:
    """Take and fit one session; return the verdict on each fault."""
    faults, seed, true = job
    rng = np.random.default_rng([seed, 58])
    setup = replace(shown_in_steps(default_setup("verdicts"), INCLINE_STEP_DEG), kind="simulated")
    gaits, truth = setup.procedure.gaits, drawn_truth(setup, WHOLE_2005, rng)
    stations = replace(setup, procedure=replace(setup.procedure, gaits=()))
    treadmill = SimulatedTreadmill(stations, truth, seed=int(rng.integers(2**31)))
    fit = fit_friction(take_all(MemoryRecord(stations), treadmill))
    drawn = sample_speeds(fit, gaits, amplitude_sigma=AMPLITUDE_SIGMA)
    judge = Judge(fit, drawn, AMPLITUDE_SIGMA, seed)

    def measured(speeds: Array) -> Measured:
        watch, times = setup.stopwatch, setup.procedure.gait_runs
        way = np.minimum(RUN_M, speeds * RUN_S)
        seconds = np.where(speeds > 0.0, way / np.maximum(speeds, 1e-9), RUN_S)
        shape = (times, len(speeds))
        seen_m = np.maximum(way + watch.distance_sigma_m * rng.normal(size=shape), 0.0)
        seen_s = seconds + watch.time_sigma_s * rng.normal(size=shape)
        runs = [[watch.speed(d, t) for d, t in zip(*row, strict=True)]
                for row in zip(seen_m.T.tolist(), seen_s.T.tolist(), strict=True)]  # fmt: skip
        weights = np.array([[sigma**-2.0 for _, sigma in row] for row in runs])
        means = np.array([[v for v, _ in row] for row in runs])
        total = weights.sum(axis=1)
        return Measured(gaits, (weights * means).sum(axis=1) / total, total**-0.5)

    found = {}
    for fault in faults:
        amplitude = 1.0 + AMPLITUDE_SIGMA * float(np.clip(rng.normal(), -3.0, 3.0))
        seen = measured(true(fault, amplitude))
        found[fault.name] = judge(seen).word
    return found


def counted(fault: Fault, found: Sequence[dict[str, str]]) -> Verdicts:
    """Count a fault's verdicts."""
    of = Counter(row[fault.name] for row in found)
    seen = len(found) - of["agrees"]
    named = sum(n for word, n in of.items() if fault.right in word.split(" or "))
    return Verdicts(
        fault.name, fault.right, len(found), {word: of[word] for word in WORDS},
        seen / len(found), named / seen if seen and fault.right != "agrees" else None,
    )  # fmt: skip


def run(
    sessions: int, seed: int, tell: Callable[[str], None], faults: tuple[Fault, ...] = FAULTS
) -> Iterator[Verdicts]:
    """Judge every fault after every session, on all cores."""
    setup = default_setup("verdicts")
    tell(f"solving for the true speeds of {len(faults)} faults")
    true = TrueSpeeds(setup.robot, setup.procedure.gaits, faults)
    jobs = [(faults, seed + k, true) for k in range(sessions)]
    found: list[dict[str, str]] = []
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        for row in pool.map(words, jobs):
            found.append(row)
            if len(found) % 10 == 0:
                tell(f"{len(found)} sessions")
    for fault in faults:
        yield counted(fault, found)


def markdown(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the table in Markdown, in per cent of sessions."""
    lines = ["| what is wrong | " + " | ".join(WORDS) + " |", "|---" * (1 + len(WORDS)) + "|"]
    for row in rows:
        shares = [100 * row["counts"][word] / row["sessions"] for word in WORDS]
        texts = [f"{x:.0f} %" if x else "" for x in shares]
        right = WORDS.index(row["right"])
        texts[right] = f"**{shares[right]:.0f} %**"
        lines.append(f"| {row['fault']} | " + " | ".join(texts) + " |")
    return "\n".join(lines)
