"""How often 95 % intervals hold the true values, in sessions on the floor of the simulated lab.

The true values are random in each session: slope of the floor, scale of the film, mass, inertia of
the wheels, joint errors, direction and rotation of each push. A simulated person follows the
procedure. The fit uses the positions from the films and the set-up of the session.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from coverage_treadmill import GAIT, SERVOS, WHOLE_2005, WHOLE_SNAKE, DrivenTable
from numpy.typing import NDArray
from serpenoid import FrictionFit, Gait, SerpenoidError, ServoKind, compare, fit_friction
from serpenoid.friction.parameters import FRICTIONS
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.recording import Camera
from serpenoid.periodic.servo_steady import band
from serpenoid.prediction.speeds import AMPLITUDE_SIGMA, scaled, speed
from serpenoid.session.settings import Setup
from serpenoid.taking.new_session import default_setup, on_place
from serpenoid.taking.simulated import SimulatedPerson, take_all
from simulated_sessions import MemoryRecord, drawn_truth
from speed_table import SpeedTable
from study import Study, kolmogorov

WHEELS_KG = 0.036
UNSEEN = tuple(
    Gait(math.radians(alpha), math.radians(beta), 2 * math.pi * rate)
    for alpha, beta, rate in (
        (60, 60, 0.3),
        (65, 60, 0.8),
        (70, 60, 0.5),
        (70, 75, 0.7),
        (75, 90, 0.4),
        (80, 75, 0.4),
    )
)
_SPEED_SAMPLES = 256


@dataclass(frozen=True)
class FloorCase:
    """One kind of session: its camera, the wheels' inertia in its set-up, and its plan.

    pushes: number in each bend. driven: the robot has hobby servos instead of very fast ones.
    """

    name: str
    camera: Camera
    wheels_kg: float | None = WHEELS_KG
    pushes: int = 8
    driven: bool = False

    @property
    def kind(self) -> ServoKind | None:
        """Return the kind of servo; a property, because cases are sent to other processes."""
        return SERVOS if self.driven else None


CASES = (
    FloorCase("film, 1 mm", Camera()),
    FloorCase("film, 1 mm, a hobby servo", Camera(), driven=True),
    FloorCase("film, 2 mm, a tenth of the pictures missing", Camera(sigma_m=0.002, missing=0.1)),
    FloorCase("film, 1 mm, wheels not weighed", Camera(), None),
)


@dataclass(frozen=True)
class FloorCoverage:
    """Shares of sessions whose interval holds the true value.

    ct, cn, ft0, fn0, speed, driven: see `Coverage`. sigma: standard deviation of a share of 95 %.
    errors: median relative errors of the four frictions. half_widths: median relative half-widths
    of the intervals; those of the two speeds are the last. unseen, unseen_90: median and 90th
    percentile of the relative error of the speeds of six other gaits, with fast servos and known
    amplitude. unseen_commanded: the median with the commanded amplitude. kolmogorov: result of
    `kolmogorov` for the p-values of fits, and of `compare` with two filmed gaits.
    """

    case: str
    sessions: int
    refused: int
    ct: float
    cn: float
    ft0: float
    fn0: float
    speed: float
    driven: float
    sigma: float
    errors: tuple[float, ...]
    half_widths: tuple[float, ...]
    unseen: float
    unseen_90: float
    unseen_commanded: float
    kolmogorov: tuple[float, float]


def floor_setup(case: FloorCase) -> Setup:
    """Return the set-up of a case's sessions."""
    base = default_setup("floor coverage")
    return replace(
        base,
        provenance=replace(base.provenance, kind="simulated"),
        robot_table=replace(base.robot_table, wheels_kg=case.wheels_kg),
        plan=replace(
            base.plan,
            on="floor",
            pushes=case.pushes,
            gaits=(),
        ),
    )


def drawn_person(
    case: FloorCase, rng: np.random.Generator, amplitude: float = 1.0
) -> SimulatedPerson:
    """Return a simulated person with random true values of robot, servos and floor.

    amplitude: of the joints in a gait, over the commanded one.
    """
    setup = floor_setup(case)
    truth = drawn_truth(setup, WHOLE_2005, rng, case.kind)
    truth = replace(truth, camera=case.camera, amplitude=amplitude)
    return SimulatedPerson(setup, truth, int(rng.integers(2**31)))


@dataclass(frozen=True)
class FloorTables:
    """Tables of the speed of GAIT, shared by all sessions."""

    speed: SpeedTable
    driven: DrivenTable


def run_floor_session(
    case: FloorCase, seed: int, number: int, tables: FloorTables
) -> list[float] | None:
    """Simulate and fit a session; return flags, widths and errors, or None if it is refused."""
    grain = round(1e4 * case.camera.sigma_m)
    rng = np.random.default_rng([seed, grain, case.pushes, number])
    amplitude = 1.0 + AMPLITUDE_SIGMA * float(rng.normal())
    person = drawn_person(case, rng, amplitude)
    setup = floor_setup(case)
    setup = replace(setup, plan=on_place(setup.plan, "floor"))
    session = take_all(MemoryRecord(setup), person)
    try:
        fit = fit_friction(session, seed=number)
    except SerpenoidError:
        return None
    bands = _bands(fit, rng, tables)
    ends = np.vstack([[fit.intervals[name] for name in FRICTIONS], *bands])
    crawls = crawl_speed(person.robot, scaled(GAIT, amplitude))
    true = np.append(WHOLE_SNAKE, [float(tables.speed(WHOLE_SNAKE[None, :])[0]), crawls])
    inside_flags = (ends[:, 0] <= true) & (true <= ends[:, 1])
    errors = np.abs(np.array(list(fit.whole_snake.values())) / WHOLE_SNAKE - 1.0)
    gait_errors = _unseen(fit, case, person, amplitude, UNSEEN[number % len(UNSEEN)])
    return [
        *inside_flags,
        *(ends[:, 1] - ends[:, 0]) / true / 2,
        *errors,
        *gait_errors,
        fit.p_value or math.nan,
        compare(session, fit, servo=case.kind).p_value or math.nan,
    ]


def _unseen(
    fit: FrictionFit, case: FloorCase, person: SimulatedPerson, amplitude: float, gait: Gait
) -> list[float]:
    """Return relative errors of another gait's speed, with known and with commanded amplitude."""
    ideal = crawl_speed(replace(person.robot, servo=None), scaled(gait, amplitude))
    commanded_error = abs(speed(fit.robot, fit.ground, gait) / ideal - 1.0)
    return [
        abs(speed(fit.robot, fit.ground, scaled(gait, amplitude)) / ideal - 1.0),
        commanded_error,
    ]


def _bands(
    fit: FrictionFit, rng: np.random.Generator, tables: FloorTables
) -> list[tuple[float, float]]:
    """Return the bands of GAIT's speed, by friction alone, and with servos."""
    frictions = fit.sample_whole(_SPEED_SAMPLES)
    amplitudes = 1.0 + AMPLITUDE_SIGMA * rng.normal(size=_SPEED_SAMPLES)
    servos = tables.driven.some(_SPEED_SAMPLES, rng)
    return [band(tables.speed(frictions)), band(tables.driven(frictions, amplitudes, servos))]


def judged_floor(case: FloorCase, rows: list[list[float] | None]) -> FloorCoverage:
    """Return the coverage of the sessions of a case."""
    fitted: NDArray[np.float64] = np.array([row for row in rows if row is not None], dtype=float)
    middle = np.median(fitted, axis=0)
    return FloorCoverage(
        case.name,
        len(fitted),
        len(rows) - len(fitted),
        *fitted[:, :6].mean(axis=0).tolist(),
        sigma=math.sqrt(0.95 * 0.05 / len(fitted)),
        errors=tuple(middle[12:16].tolist()),
        half_widths=tuple(middle[6:12].tolist()),
        unseen=float(middle[16]),
        unseen_90=float(np.quantile(fitted[:, 16], 0.9)),
        unseen_commanded=float(middle[17]),
        kolmogorov=(kolmogorov(fitted[:, 18].tolist()), kolmogorov(fitted[:, 19].tolist())),
    )


def floor_tables(_cases: Sequence[FloorCase] = ()) -> FloorTables:
    """Return tables of GAIT's speed, for frictions within 20 % of the true ones, and servos."""
    robot = default_setup("floor coverage").robot
    limits: dict[str, Any] = {"box": (0.8 * WHOLE_SNAKE, 1.2 * WHOLE_SNAKE), "kernel": "cubic"}
    table = SpeedTable(robot, GAIT, **limits)
    return FloorTables(table, DrivenTable(robot, table, **limits))


STUDY = Study(
    CASES,
    floor_tables,
    run_floor_session,
    lambda case, results: [judged_floor(case, results)],
)
