"""How often 95 % intervals hold the truth, over sessions taken by the real procedure.

The treadmill's incline steps, 0.3 to 0.7 % of grade, are drawn anew for every session. With one
step for all, an inclinometer in steps of 0.1 degrees rounds in a pattern that repeats along a
series (0.5 % of grade is 2.86 of its steps), and coverage would be that pattern's, not the fit's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...calibration.friction_fit import fit_friction
from ...calibration.friction_result import NAMES
from ...calibration.taking.memory import MemoryRecord
from ...calibration.taking.new_session import default_setup
from ...calibration.taking.simulated import SimulatedTreadmill, drawn_truth
from ...calibration.taking.treadmill import take_all
from ...model.errors import SerpenoidError
from ...model.gait import Gait
from ...model.ground import Ground
from .speed_table import SpeedTable

WHOLE_2005 = Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
LAMBDAS_DEG = (7.5, 30.0)
GAIT = Gait(math.radians(70.0), math.radians(75.0), math.pi)
_SPEED_SAMPLES = 256


@dataclass(frozen=True)
class Coverage:
    """Shares of sessions whose interval holds the truth; sigma: how far a share of 95 % scatters.

    refused: sessions whose readings could not tell all four parameters.
    """

    lambda_deg: float
    sessions: int
    refused: int
    readings: float
    ct: float
    cn: float
    ft0: float
    fn0: float
    speed: float
    sigma: float


def coverage(
    lambda_deg: float, sessions: int, seed: int, table: SpeedTable, tell: Callable[[str], None]
) -> Coverage:
    """Take, fit and judge this many sessions with a straight series and one bend."""
    rng = np.random.default_rng([seed, round(10 * lambda_deg)])
    base = default_setup("coverage")
    plan = replace(base.procedure, lambda_rad=(0.0, math.radians(lambda_deg)), gaits=())
    base = replace(base, procedure=plan, kind="simulated")
    truth_whole = np.array([getattr(WHOLE_2005, name) for name in NAMES])
    speed = float(table(truth_whole[None, :])[0])
    inside, readings, refused = [], [], 0
    for k in range(sessions):
        steps = replace(base.treadmill, incline_step_rad=float(rng.uniform(0.003, 0.007)))
        setup = replace(base, treadmill=steps)
        truth = drawn_truth(setup, WHOLE_2005, rng)
        taken = take_all(MemoryRecord(setup), SimulatedTreadmill(setup, truth, seed=seed + k))
        try:
            fit = fit_friction(taken)
        except SerpenoidError:
            refused += 1
            continue
        low, high = np.quantile(table(fit.sample_whole(_SPEED_SAMPLES)), [0.025, 0.975])
        ends = np.array([fit.intervals[name] for name in NAMES])
        held = (ends[:, 0] <= truth_whole) & (truth_whole <= ends[:, 1])
        inside.append([*held, low <= speed <= high])
        readings.append(len(taken.kept))
        if (k + 1) % 100 == 0:
            tell(f"lambda {lambda_deg:g} deg: {k + 1} of {sessions} sessions")
    ct, cn, ft0, fn0, of_speed = np.mean(inside, axis=0).tolist()
    scatter = math.sqrt(0.95 * 0.05 / len(inside))
    mean = float(np.mean(readings))
    return Coverage(
        lambda_deg, len(inside), refused, mean, ct, cn, ft0, fn0, of_speed, sigma=scatter
    )


def run(sessions: int, seed: int, tell: Callable[[str], None]) -> list[Coverage]:
    """Judge both bends."""
    tell("solving for the speeds that fits are judged by")
    table = SpeedTable(default_setup("coverage").robot, GAIT)
    return [coverage(bend, sessions, seed, table, tell) for bend in LAMBDAS_DEG]
