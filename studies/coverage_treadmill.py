"""How often 95 % intervals hold the truth, over sessions taken by the real procedure in the lab.

The inclinometer shows steps of 0.1 degrees. The treadmill's steps are 0.5 % of grade, as on most,
which is 2.86 of the inclinometer's, so that rounding errors repeat in a pattern; or drawn anew for
every session between 0.3 and 0.7 %. Its true steps are a hundredth off those stated, or so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from serpenoid import Gait, Ground, Robot, SerpenoidError, fit_friction, servo
from serpenoid.friction.parameters import FRICTIONS
from serpenoid.friction.result import ground_of
from serpenoid.lab.crawl import crawl_speed
from serpenoid.periodic.servo_steady import band, drawn_servo_speeds
from serpenoid.periodic.steady import steady_gait
from serpenoid.prediction.speeds import AMPLITUDE_SIGMA, scaled
from serpenoid.session.settings import Setup
from serpenoid.taking.new_session import default_setup
from serpenoid.taking.simulated import SimulatedPerson, take_all
from simulated_sessions import MemoryRecord, drawn_truth
from speed_table import SpeedTable
from study import Study, kolmogorov

WHOLE_2005 = Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
WHOLE_SNAKE = np.array([getattr(WHOLE_2005, name) for name in FRICTIONS])
GAIT = Gait(math.radians(70.0), math.radians(75.0), math.pi)
INCLINE_STEP_DEG, DRAWN, STEP_SIGMA = 0.1, (0.003, 0.007), 0.01
SERVOS = servo("hobby")
_SPEED_SAMPLES, _SERVOS = 256, 1024
# Of the speeds, so that where fits end they are off by 0.5 % in the mean; linear ones of a tenth of
# these points were 2 % too slow.
_TABLE = {"points": 4096, "kernel": "cubic", "neighbours": 60}


@dataclass(frozen=True)
class Case:
    """Sessions of one kind: a straight series and bends; grade_step None: drawn anew each time."""

    lambdas_deg: tuple[float, ...]
    grade_step: float | None

    @property
    def name(self) -> str:
        """Return it in words."""
        bends = ", ".join(f"{bend:g}" for bend in self.lambdas_deg)
        steps = "drawn" if self.grade_step is None else f"{self.grade_step:.1%}"
        return f"lambda {bends} deg, steps {steps}"


BENDS_DEG = ((7.5,), (30.0,), (7.5, 15.0, 30.0))
CASES = tuple(Case(bends, step) for bends, step in product(BENDS_DEG, (0.005, None)))


@dataclass(frozen=True)
class Coverage:
    """Shares of sessions whose interval holds the truth; sigma: how far a share of 95 % scatters.

    speed: of GAIT, predicted from frictions alone, joints ideal. driven: of the lab's own robot in
    GAIT, whose joints stand off, swing by an amplitude of their own, and have a hobby servo drawn
    at random, by the band of frictions, joints and servos that every command shows. refused:
    sessions whose readings could not tell all four parameters. readings: mean number. half_widths:
    of the intervals, relative, the median; those of the two speeds last. kolmogorov: of the fits'
    p-values, as `kolmogorov` has it.
    """

    case: str
    sessions: int
    refused: int
    readings: float
    ct: float
    cn: float
    ft0: float
    fn0: float
    speed: float
    driven: float
    sigma: float
    half_widths: tuple[float, ...]
    kolmogorov: float


def shown_in_steps(setup: Setup, step_deg: float) -> Setup:
    """Return a set-up whose inclinometer shows such steps."""
    sigma_deg = step_deg / math.sqrt(12)
    return replace(setup, instruments=replace(setup.instruments, incline_sigma_deg=sigma_deg))


class DrivenTable:
    """Speeds of GAIT over frictions and over the joints' amplitude, for the band of driven_speeds.

    shares: what each of many servos leaves of the speed on the ground of WHOLE_2005. A session has
    some of them, drawn for it alone: the same few for all would err alike in all.
    """

    def __init__(self, robot: Robot, table: SpeedTable, servos: int = _SERVOS, **more: Any):
        self._amplitudes = np.array([1.0 - AMPLITUDE_SIGMA, 1.0, 1.0 + AMPLITUDE_SIGMA])
        ends = self._amplitudes[[0, 2]]
        scaled_tables = [SpeedTable(robot, scaled(GAIT, a), **more) for a in ends]
        self._tables = (scaled_tables[0], table, scaled_tables[1])
        ideal = steady_gait(robot, ground_of(robot.links, WHOLE_SNAKE.tolist()), GAIT, rtol=1e-4)
        speeds = drawn_servo_speeds([ideal] * servos, SERVOS.draws(servos))
        self.shares = speeds / ideal.speed_m_s

    def some(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return the shares of a session's own servos."""
        return np.resize(rng.permutation(self.shares), count)

    def __call__(
        self,
        frictions: NDArray[np.float64],
        amplitude: NDArray[np.float64],
        share: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return the speeds of (count, 4) frictions, each with an amplitude and a servo's share."""
        low, mid, high = (table(frictions) for table in self._tables)
        x = (amplitude - 1.0) / AMPLITUDE_SIGMA
        return share * (mid + x * (high - low) / 2 + x * x * ((high + low) / 2 - mid))


def run_session(
    case: Case, seed: int, number: int, tables: tuple[SpeedTable, DrivenTable]
) -> list[float] | None:
    """Take and fit a session; return what held, half widths, readings; None where refused."""
    table, driven = tables
    rng = np.random.default_rng([seed, *(round(10 * x) for x in case.lambdas_deg), number])
    base = shown_in_steps(default_setup("coverage"), INCLINE_STEP_DEG)
    step = case.grade_step or float(rng.uniform(*DRAWN))
    setup = replace(
        base,
        provenance=replace(base.provenance, kind="simulated"),
        instruments=replace(base.instruments, incline_step_percent=100 * step),
        plan=replace(base.plan, lambda_deg=(0.0, *case.lambdas_deg), gaits=()),
    )
    truth = drawn_truth(setup, WHOLE_2005, rng, SERVOS)
    truth = replace(truth, incline_scale=1.0 + STEP_SIGMA * float(rng.normal()))
    treadmill = SimulatedPerson(setup, truth, int(rng.integers(2**31)))
    session = take_all(MemoryRecord(setup), treadmill)
    try:
        fit = fit_friction(session)
    except SerpenoidError:
        return None
    drawn = fit.sample_whole(_SPEED_SAMPLES)
    amplitudes = 1.0 + AMPLITUDE_SIGMA * rng.normal(size=_SPEED_SAMPLES + 1)
    driven_speeds = driven(drawn, amplitudes[1:], driven.some(_SPEED_SAMPLES, rng))
    crawls = crawl_speed(treadmill.robot, scaled(GAIT, float(amplitudes[0])))
    ends = np.vstack(
        [[fit.intervals[name] for name in FRICTIONS], band(table(drawn)), band(driven_speeds)]
    )
    true = np.append(WHOLE_SNAKE, [float(table(WHOLE_SNAKE[None, :])[0]), crawls])
    inside_flags = (ends[:, 0] <= true) & (true <= ends[:, 1])
    half_widths = (ends[:, 1] - ends[:, 0]) / true / 2
    return [*inside_flags, *half_widths, len(session.kept_stations), fit.p_value or math.nan]


def judged(case: Case, rows: list[list[float] | None]) -> Coverage:
    """Return the shares of a case's sessions."""
    fitted: NDArray[np.float64] = np.array([row for row in rows if row is not None], dtype=float)
    shares = fitted[:, :6].mean(axis=0).tolist()
    widths = np.median(fitted[:, 6:12], axis=0).tolist()
    return Coverage(
        case.name,
        len(fitted),
        len(rows) - len(fitted),
        float(fitted[:, 12].mean()),
        *shares,
        sigma=math.sqrt(0.95 * 0.05 / len(fitted)),
        half_widths=tuple(widths),
        kolmogorov=kolmogorov(fitted[:, 13].tolist()),
    )


def speed_tables(_cases: Sequence[Case] = ()) -> tuple[SpeedTable, DrivenTable]:
    """Return the speeds that fits are judged by."""
    robot = default_setup("coverage").robot
    table = SpeedTable(robot, GAIT, **_TABLE)
    return table, DrivenTable(robot, table, **_TABLE)


STUDY = Study(CASES, speed_tables, run_session, lambda case, results: [judged(case, results)])
