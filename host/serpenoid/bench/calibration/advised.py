"""How many readings advice saves: advised sequences beside the paper's plan, same treadmill."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...calibration.advice import advise
from ...calibration.friction_fit import fit_friction
from ...calibration.session import Session
from ...calibration.taking.memory import MemoryRecord
from ...calibration.taking.new_session import default_setup
from ...calibration.taking.simulated import SimulatedTreadmill, Truth, drawn_truth
from ...calibration.taking.steps import Step
from ...calibration.taking.treadmill import record_step, take_all
from ...model.errors import BadInput
from .coverage import GAIT, WHOLE_2005
from .speed_table import SpeedTable

# Four readings that leave no parameter open; inclines of about 0.1 and 0.8 m/s.
FIRST = ((0.0, 1.95), (0.0, 2.65), (30.0, 3.8), (30.0, 7.0))
_MOST_READINGS, _SETTLE_S = 16, 16.0


@dataclass(frozen=True)
class Saved:
    """One session: readings of the paper's plan, its band; advised readings to the same band."""

    seed: int
    paper_readings: int
    paper_band_m_s: float
    advised_readings: int
    advised_band_m_s: float


def band_m_s(session: Session, table: SpeedTable) -> float:
    """Return the width of the sampled speed's 95 % band."""
    low, high = np.quantile(table(fit_friction(session).sample_whole(256)), [0.025, 0.975])
    return float(high - low)


def _hold(record: MemoryRecord, treadmill: SimulatedTreadmill, at: tuple[float, float]) -> None:
    """Bend the robot as told, hold one station, record both."""
    bend_deg, incline_deg = at
    shown = 0.0
    if bend_deg:
        pose = Step("bend", "bend", "", lambda_deg=bend_deg)
        cells = dict(treadmill.answer(pose, record.session) or {})
        record_step(record, replace(pose, cells={"lambda_deg": bend_deg}), cells)
        shown = math.degrees(record.session.bends[-1].found_rad)
    else:
        treadmill.answer(Step("straight", "straight", ""), record.session)
    step = Step(
        "station", "station", "", lambda_deg=bend_deg, incline_deg=incline_deg,
        settle_s=_SETTLE_S, cells={"lambda_deg": round(shown, 4)},
    )  # fmt: skip
    found = treadmill.answer(step, record.session)
    if found is not None:
        record_step(record, step, found)


def one(seed: int, table: SpeedTable) -> Saved:
    """Take the paper's plan, then an advised session until its band is as narrow."""
    base = default_setup("advised")
    plan = replace(base.procedure, lambda_rad=(0.0, math.radians(7.5)),
                   incline_step_rad=math.radians(0.2), gaits=())  # fmt: skip
    setup = replace(base, procedure=plan, kind="simulated")
    truth: Truth = drawn_truth(setup, WHOLE_2005, np.random.default_rng(seed))
    paper = take_all(MemoryRecord(setup), SimulatedTreadmill(setup, truth, seed=seed))
    wanted = band_m_s(paper, table)
    record = MemoryRecord(setup)
    treadmill = SimulatedTreadmill(setup, truth, seed=seed + 1000)
    for name in ("zero before", "zero after"):  # the paper's plan reads them, too
        step = Step(name, "zero", "")
        record_step(record, step, treadmill.answer(step, record.session) or {})
    for at in FIRST:
        _hold(record, treadmill, at)
    band = math.inf
    for turn in range(_MOST_READINGS):
        try:
            band = band_m_s(record.session, table)
        except BadInput:  # a station slipped away, or two came out alike: one more of them
            bend, incline = FIRST[turn % len(FIRST)]
            _hold(record, treadmill, (bend, incline + 0.3))
            continue
        if band <= wanted:
            break
        best = advise(record.session, [GAIT], samples=24, runs=False).best
        bend, incline = best.lambda_rad or 0.0, best.incline_rad or 0.0
        _hold(record, treadmill, (math.degrees(bend), math.degrees(incline)))
    return Saved(seed, len(paper.kept), wanted, len(record.session.kept), band)


def run(sessions: int, seed: int, tell: Callable[[str], None]) -> list[Saved]:
    """Compare this many sessions."""
    table = SpeedTable(default_setup("advised").robot, GAIT)
    found = []
    for k in range(sessions):
        found.append(one(seed + k, table))
        tell(f"{k + 1} of {sessions}: {found[-1]}")
    return found
