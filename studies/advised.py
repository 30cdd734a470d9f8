"""How many readings advice saves: advised sequences beside fixed plans, on the same treadmill.

Target is the band that a plan's whole session leaves the speed of a gait, the median of all its
sessions, known before any advice. An advised session begins with four of the plan's own readings,
the first two straight and the first two bent (more where two cannot be fitted), so that nothing is
won by a cleverer opening; then it does what advice says after every reading, until its band is as
narrow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from coverage_treadmill import GAIT, INCLINE_STEP_DEG, WHOLE_2005, shown_in_steps
from serpenoid import BadInput, Session, advise, fit_friction
from serpenoid.calibration.taking.new_session import default_setup
from serpenoid.calibration.taking.simulated import SimulatedPerson
from serpenoid.calibration.taking.steps import Step
from serpenoid.calibration.taking.treadmill import record_step, take_all
from serpenoid.periodic.servo_steady import band as speed_band
from serpenoid.prediction.next_reading import NextReading
from simulated_sessions import MemoryRecord, drawn_truth
from speed_table import SpeedTable
from study import all_cores

# Bends, and the incline's step where it is not that of a treadmill of today (0.5 % of grade).
PLANS_DEG: dict[str, tuple[tuple[float, ...], float | None]] = {
    "paper": ((0.0, 7.5), 0.2),
    "paper, steps of 0.5 %": ((0.0, 7.5), None),
    "default": ((0.0, 7.5, 15.0, 30.0), None),
}
OPENING = 2  # readings of the straight series and of the first bend
_MOST_READINGS, _SETTLE_S = 40, 16.0


@dataclass(frozen=True)
class Saved:
    """One session: readings in all, planned and advised; opening: how many they have in common.

    plan_band, advised_band: full width of the speed's 95 % band, relative; target: the plan's
    median one. plan_off, advised_off: speed predicted less true one, relative. reached: whether the
    advised band came down to the target at all.
    """

    plan: str
    seed: int
    target: float
    opening: int
    plan_readings: int
    advised_readings: int
    plan_band: float
    advised_band: float
    plan_off: float
    advised_off: float
    reached: bool


@dataclass(frozen=True)
class Ratio:
    """What all sessions of a plan came to: mean readings, and advised over planned ones.

    after_opening: the ratio of the readings that come after the common ones.
    """

    plan: str
    sessions: int
    reached: int
    target: float
    plan_readings: float
    advised_readings: float
    ratio: float
    after_opening: float


def band_and_off(session: Session, table: SpeedTable) -> tuple[float, float]:
    """Return the width of the sampled speed's 95 % band, and how far off its middle is."""
    whole = np.array([[getattr(WHOLE_2005, name) for name in ("ct", "cn", "ft0", "fn0")]])
    true_m_s = float(table(whole)[0])
    fit = fit_friction(session)
    low, high = speed_band(table(fit.sample_whole(256)))
    best = float(table(np.array([list(fit.whole_snake.values())]))[0])
    return (high - low) / true_m_s, best / true_m_s - 1.0


def opening(session: Session) -> Session:
    """Return a session's first readings straight and of its first bend: as few as can be fitted."""
    straight = [r for r in session.kept if not r.lambda_rad]
    bend = next(r.lambda_rad for r in session.kept if r.lambda_rad)
    bent = [r for r in session.kept if r.lambda_rad == bend]
    bends = tuple(b for b in session.bends if abs(b.found_rad - bend) < 1e-5)
    for count in range(OPENING, len(session.kept)):
        begun = replace(session, readings=(*straight[:count], *bent[:count]), bends=bends)
        try:
            fit_friction(begun)
        except BadInput:
            continue
        return begun
    return session


class Advised:
    """A session that goes on by advice, and the bend that its robot lies in; none at first."""

    def __init__(self, record: MemoryRecord, treadmill: SimulatedPerson):
        self.record, self.treadmill = record, treadmill
        self.posed_rad = math.nan

    def hold(self, told: NextReading) -> bool:
        """Bend the robot as advised unless it lies so, hold the station; tell if there was one."""
        if told.lambda_rad != self.posed_rad:
            self._pose(told.lambda_rad or 0.0)
        step = Step(
            "station",
            "station",
            "",
            incline_deg=math.degrees(told.incline_rad or 0.0),
            settle_s=_SETTLE_S,
            cells={"lambda_deg": round(math.degrees(self.posed_rad), 4)},
        )
        found = self.treadmill.answer(step, self.record.session)
        if found is not None:
            record_step(self.record, step, found)
            self.posed_rad = self.record.session.kept[-1].lambda_rad  # as it was written down
        return found is not None

    def _pose(self, lambda_rad: float) -> None:
        self.posed_rad = lambda_rad
        if not lambda_rad:
            self.treadmill.answer(Step("straight", "straight", ""), self.record.session)
            return
        bend_deg = math.degrees(lambda_rad)
        pose = Step("bend", "bend", "", lambda_deg=bend_deg)
        cells = dict(self.treadmill.answer(pose, self.record.session) or {})
        record_step(self.record, replace(pose, cells={"lambda_deg": bend_deg}), cells)
        self.posed_rad = self.record.session.bends[-1].found_rad


def planned(plan: str, seed: int) -> tuple[Session, SimulatedPerson]:
    """Return a whole session of a plan, and the same treadmill with nothing done on it yet."""
    base = shown_in_steps(default_setup("advised"), INCLINE_STEP_DEG)
    bends_deg, step_deg = PLANS_DEG[plan]
    procedure = replace(base.procedure, lambda_rad=tuple(map(math.radians, bends_deg)), gaits=())
    steps = base.treadmill
    if step_deg is not None:
        procedure = replace(procedure, incline_step_rad=math.radians(step_deg))
        steps = replace(steps, incline_step_rad=math.tan(math.radians(step_deg)))
    setup = replace(base, kind="simulated", procedure=procedure, treadmill=steps)
    truth = drawn_truth(setup, WHOLE_2005, np.random.default_rng(seed))
    taken = take_all(MemoryRecord(setup), SimulatedPerson(setup, truth, seed))
    return taken, SimulatedPerson(setup, truth, seed)


def plan_of(job: tuple[str, int, SpeedTable]) -> tuple[int, float, float]:
    """Return a plan's readings, its band and how far off its speed is."""
    plan, seed, table = job
    taken = planned(plan, seed)[0]
    return len(taken.kept), *band_and_off(taken, table)


def advised(job: tuple[str, int, SpeedTable, float]) -> tuple[int, float, float, int]:
    """Return an advised session's readings, band, how far off, and the opening's readings."""
    plan, seed, table, target = job
    taken, treadmill = planned(plan, seed)
    goes_on = Advised(MemoryRecord(taken.setup, opening(taken)), treadmill)
    first = len(goes_on.record.session.kept)
    band, off = band_and_off(goes_on.record.session, table)
    while band > target and len(goes_on.record.session.kept) < _MOST_READINGS:
        ranked = advise(goes_on.record.session, [GAIT], samples=24, servo=None).readings
        next(told for told in ranked if goes_on.hold(told))
        band, off = band_and_off(goes_on.record.session, table)
    return len(goes_on.record.session.kept), band, off, first


def run(sessions: int, seed: int, tell: Callable[[str], None]) -> list[Saved]:
    """Compare this many sessions with either plan, on all cores."""
    table = SpeedTable(default_setup("advised").robot, GAIT)
    seeds = range(seed, seed + sessions)
    found: list[Saved] = []
    with all_cores() as pool:
        for plan in PLANS_DEG:
            plans = list(pool.map(plan_of, [(plan, k, table) for k in seeds]))
            target = float(np.median([band for _, band, _ in plans]))
            tell(f"{plan} plan: the target is a band of {target:.1%}")
            jobs = [(plan, k, table, target) for k in seeds]
            for k, of_plan, own in zip(seeds, plans, pool.map(advised, jobs), strict=True):
                found.append(_saved(plan, k, target, of_plan, own))
                tell(f"{plan} plan, seed {k}: {of_plan[0]} readings, {own[0]} advised")
    return found


def _saved(
    plan: str,
    seed: int,
    target: float,
    of_plan: tuple[int, float, float],
    own: tuple[int, float, float, int],
) -> Saved:
    return Saved(
        plan,
        seed,
        target,
        own[3],
        of_plan[0],
        own[0],
        of_plan[1],
        own[1],
        of_plan[2],
        own[2],
        own[1] <= target,
    )


def ratios(rows: Sequence[Saved]) -> list[Ratio]:
    """Return what each plan's sessions came to; one that never got there counts as it stopped."""
    out = []
    for plan in dict.fromkeys(r.plan for r in rows):
        of = [r for r in rows if r.plan == plan]
        by_plan, own, first = (
            float(np.mean([getattr(r, name) for r in of]))
            for name in ("plan_readings", "advised_readings", "opening")
        )
        reached = sum(r.reached for r in of)
        out.append(
            Ratio(
                plan,
                len(of),
                reached,
                of[0].target,
                by_plan,
                own,
                own / by_plan,
                (own - first) / (by_plan - first),
            )
        )
    return out
