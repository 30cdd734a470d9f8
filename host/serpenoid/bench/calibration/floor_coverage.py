"""How often 95 % intervals hold the truth, over sessions on a floor by the whole chain in the lab.

Every session draws its own truth: the floor's slope, the film's scale, the mass, the wheels'
inertia, joint errors, and how crooked each push is. A person follows the procedure; films give
places, and the fit knows those and what the set-up states.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...calibration.friction_fit import fit_friction
from ...calibration.friction_result import NAMES, FrictionFit, band
from ...calibration.kinds.instruments import FloorTools
from ...calibration.session import Setup
from ...calibration.speed_samples import AMPLITUDE_SIGMA, sample_speeds, scaled, speed
from ...calibration.taking.floor.simulated import SimulatedFloor, drawn_floor
from ...calibration.taking.memory import MemoryRecord
from ...calibration.taking.new_session import default_setup
from ...calibration.taking.treadmill import take_all
from ...lab.crawl import crawl_speed
from ...lab.recording import Camera
from ...model.errors import SerpenoidError
from ...model.gait import Gait
from .coverage import GAIT, SERVOS, WHOLE, WHOLE_2005, DrivenTable
from .speed_table import SpeedTable

WHEELS_KG = 0.036
UNSEEN = tuple(
    Gait(math.radians(alpha), math.radians(beta), 2 * math.pi * rate)
    for alpha, beta, rate in (
        (60, 60, 0.3), (65, 60, 0.8), (70, 60, 0.5), (70, 75, 0.7), (75, 90, 0.4), (80, 75, 0.4),
    )
)  # fmt: skip
# Run where they are to close the loop: none of those above, and each away from the cliff.
CLOSING = tuple(
    Gait(math.radians(alpha), math.radians(beta), 2 * math.pi * rate)
    for alpha, beta, rate in ((70, 60, 0.8), (80, 75, 0.45), (60, 55, 0.3))
)
_SPEED_SAMPLES = 256


@dataclass(frozen=True)
class FloorCase:
    """Sessions of one kind: what films, what the set-up is told of the wheels, and the pushes.

    camera: None: tape and watch. crawls: gaits that are run, timed over a metre, and fitted, too.
    """

    name: str
    camera: Camera | None
    wheels_kg: float | None = WHEELS_KG
    pushes: int = 4
    crawls: tuple[Gait, ...] = ()


CASES = (
    FloorCase("film, 1 mm", Camera()),
    FloorCase("film, 2 mm, a tenth of the pictures missing", Camera(sigma_m=0.002, missing=0.1)),
    FloorCase("film, 1 mm, wheels not weighed", Camera(), None),
    FloorCase("by hand, with three crawls", None, crawls=CLOSING),
)


@dataclass(frozen=True)
class FloorCoverage:
    """Shares of sessions whose interval holds the truth; sigma: how far a share of 95 % scatters.

    ct, cn, ft0, fn0, speed, driven: as of `Coverage`. errors: medians of the four frictions'
    relative errors. half_widths: of the intervals, relative, the median, those of the two speeds
    last. unseen, unseen_90: median and 90th percentile of the relative error of six gaits' speeds
    by quick servos, joints' amplitudes known (as a film tells them); unseen_commanded: the median
    where they are taken as commanded. Where crawls are fitted, their amplitude stands in place of
    the known one, and servos are quick for `driven`, too. minutes: by the lab's clock.
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
    minutes: float


def floor_setup(case: FloorCase) -> Setup:
    """Return the set-up of a case's sessions."""
    base = default_setup("floor coverage")
    return replace(
        base, kind="simulated", floor=FloorTools(wheels_kg=case.wheels_kg),
        procedure=replace(
            base.procedure, on="floor", pushes=case.pushes, gaits=case.crawls, gait_runs=1
        ),
    )  # fmt: skip


def drawn_person(
    case: FloorCase, rng: np.random.Generator, amplitude: float = 1.0
) -> SimulatedFloor:
    """Return a person on a floor, the truth of both drawn, the robot's servos with it.

    amplitude: of its joints in a gait. Where crawls are fitted servos are quick.
    """
    setup = floor_setup(case)
    truth = drawn_floor(setup, WHOLE_2005, rng, None if case.crawls else SERVOS)
    truth = replace(truth, camera=case.camera, amplitude=amplitude)
    return SimulatedFloor(setup, truth, seed=int(rng.integers(2**31)))


def one_floor(
    case: FloorCase, seed: int, number: int, table: SpeedTable, driven: DrivenTable
) -> list[float] | None:
    """Take and fit a session; return what held, widths, errors and minutes; None where refused."""
    grain = round(1e4 * case.camera.sigma_m) if case.camera else 0
    rng = np.random.default_rng([seed, grain, case.pushes, number])
    amplitude = 1.0 + AMPLITUDE_SIGMA * float(rng.normal())
    person = drawn_person(case, rng, amplitude)
    taken = take_all(MemoryRecord(floor_setup(case)), person)
    try:
        fit = fit_friction(taken, crawls=bool(case.crawls))
    except SerpenoidError:
        return None
    ends = np.vstack([[fit.intervals[name] for name in NAMES], *_bands(fit, rng, table, driven)])
    crawls = crawl_speed(person.robot, scaled(GAIT, amplitude))
    true = np.append(WHOLE, [float(table(WHOLE[None, :])[0]), crawls])
    held = (ends[:, 0] <= true) & (true <= ends[:, 1])
    errors = np.abs(np.array(list(fit.whole_snake.values())) / WHOLE - 1.0)
    gait = UNSEEN[number % len(UNSEEN)]
    moved = crawl_speed(replace(person.robot, servo=None), scaled(gait, amplitude))
    known = fit.nuisances["joint_amplitude"].value if case.crawls else amplitude
    told = [speed(fit.robot, fit.ground, g) for g in (scaled(gait, known), gait)]
    off = [abs(v / moved - 1.0) for v in told]
    return [*held, *(ends[:, 1] - ends[:, 0]) / true / 2, *errors, *off, person.t_s / 60]


def _bands(
    fit: FrictionFit, rng: np.random.Generator, table: SpeedTable, driven: DrivenTable
) -> list[tuple[float, float]]:
    """Return the bands of GAIT's speed, of frictions alone and of a driven robot."""
    if fit.draws is not None:  # wider than the tables
        drawn = sample_speeds(fit, [GAIT], amplitude_sigma=AMPLITUDE_SIGMA, count=_SPEED_SAMPLES)
        return [band(drawn.friction_m_s[:, 0]), band(drawn.both_m_s[:, 0])]
    whole = fit.sample_whole(_SPEED_SAMPLES)
    amplitudes = 1.0 + AMPLITUDE_SIGMA * rng.normal(size=_SPEED_SAMPLES)
    return [band(table(whole)), band(driven(whole, amplitudes, driven.some(_SPEED_SAMPLES, rng)))]


def judged_floor(case: FloorCase, found: list[list[float] | None]) -> FloorCoverage:
    """Return the shares of a case's sessions."""
    told: NDArray[np.float64] = np.array([row for row in found if row is not None], dtype=float)
    middle = np.median(told, axis=0)
    return FloorCoverage(
        case.name, len(told), len(found) - len(told), *told[:, :6].mean(axis=0).tolist(),
        sigma=math.sqrt(0.95 * 0.05 / len(told)), errors=tuple(middle[12:16].tolist()),
        half_widths=tuple(middle[6:12].tolist()), unseen=float(middle[16]),
        unseen_90=float(np.quantile(told[:, 16], 0.9)), unseen_commanded=float(middle[17]),
        minutes=float(middle[18]),
    )  # fmt: skip


def speed_tables() -> tuple[SpeedTable, DrivenTable]:
    """Return GAIT's speeds over what pushes leave open, some per cent about the truth."""
    robot = default_setup("floor coverage").robot
    near: dict[str, Any] = {"box": (0.8 * WHOLE, 1.2 * WHOLE), "kernel": "cubic"}
    table = SpeedTable(robot, GAIT, **near)
    return table, DrivenTable(robot, table, **near)


def run_floor(
    sessions: int, seed: int, tell: Callable[[str], None], cases: tuple[FloorCase, ...] = CASES
) -> Iterator[FloorCoverage]:
    """Judge every case, one session after the other.

    Of sessions whose crawls are fitted a fifth, since each takes ten times as long.
    """
    tell("solving for the speeds that fits are judged by")
    table, driven = speed_tables()
    for case in cases:
        found = []
        count = max(sessions // 5, 1) if case.crawls else sessions
        for number in range(count):
            found.append(one_floor(case, seed, number, table, driven))
            if not (number + 1) % 50:
                tell(f"{case.name}: {number + 1} of {count}")
        yield judged_floor(case, found)
