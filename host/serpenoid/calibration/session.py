"""A calibration session in memory: the set-up, and every kind of reading taken under it.

Everything here is SI and radians; session_file reads it from a folder, whose files speak degrees.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..model.checks import check_choice, check_number
from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.robot import Robot

KINDS = ("measured", "regenerated", "simulated")
FACINGS = ("down", "up")
FOLLOWED = 1.5  # errors of the zero's difference, beyond which it is taken to have drifted
# Beyond these a number is a slip of units, not a reading: the joints end before 60 degrees, the
# snake tumbles before 45, and no treadmill runs at 10 m/s.
MAX_LAMBDA_DEG, MAX_INCLINE_DEG, MAX_SPEED_M_S, MAX_GRAVITY_M_S2 = 60.0, 45.0, 10.0, 30.0


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """What the instruments may be off by, as standard deviations.

    incline_sigma_rad: of one reading of the inclinometer. incline_zero_sigma_rad: of its zero,
    common to the session. belt_speed_sigma_m_s: of one belt speed past the snake.
    lambda_sigma_rad: of the bend, common to all bent readings. Raises BadInput.
    """

    incline_sigma_rad: float
    incline_zero_sigma_rad: float
    belt_speed_sigma_m_s: float
    lambda_sigma_rad: float

    def __post_init__(self) -> None:
        for name in ("incline_sigma_rad", "belt_speed_sigma_m_s"):
            check_number(name, getattr(self, name), 0.0, open_low=True)
        for name in ("incline_zero_sigma_rad", "lambda_sigma_rad"):
            check_number(name, getattr(self, name), 0.0)


@dataclass(frozen=True, slots=True)
class Reading:
    """One station held: the belt speed at which the snake neither climbs nor slides.

    number: from 1, unique in a session. lambda_rad: angle of every link to the direction of the
    belt, alternately left and right; 0 when straight. incline_rad: gamma as the inclinometer shows
    it. belt_speed_m_s: uphill, so that the snake, facing downhill, rolls forwards. drift_m_s: what
    was left of the snake's own motion, positive when carried along with the belt. voided: not to be
    used, for the reason in comment. time_utc: ISO 8601, empty if not recorded. facing: "down" the
    incline, or "up": the wheels then roll backwards, which tells a ratchet. uncertainty: of the
    instruments it was taken with, None for those of the session's set-up. Raises BadInput.
    """

    number: int
    lambda_rad: float
    incline_rad: float
    belt_speed_m_s: float
    drift_m_s: float = 0.0
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    uncertainty: Uncertainty | None = None
    facing: str = "down"

    def __post_init__(self) -> None:
        check_number("number", self.number, 1)
        check_choice("facing", self.facing, FACINGS)
        check_number("lambda_rad", self.lambda_rad, 0.0, math.radians(MAX_LAMBDA_DEG))
        incline_limit = math.radians(MAX_INCLINE_DEG)
        check_number("incline_rad", self.incline_rad, 0.0, incline_limit, open_low=True)
        check_number("belt_speed_m_s", self.belt_speed_m_s, 0.0, MAX_SPEED_M_S)
        check_number("drift_m_s", self.drift_m_s, -MAX_SPEED_M_S, MAX_SPEED_M_S)
        if not self.voided and self.slip_speed_m_s <= 0.0:
            raise BadInput(
                f"belt_speed_m_s - drift_m_s is {self.slip_speed_m_s:g} in reading {self.number}; "
                "it must be more than 0, since wheels at rest hold any force up to their static "
                "friction; void the reading or correct it"
            )

    @property
    def slip_speed_m_s(self) -> float:
        """Return the speed of the belt past the snake, v_rel = v_belt - v_drift."""
        return self.belt_speed_m_s - self.drift_m_s


@dataclass(frozen=True, slots=True)
class GaitRun:
    """One measured speed of the crawling robot, on level ground of the session's surface.

    number: from 1, unique among all readings of the session. omega_rad_s: the true rate, from the
    board's clock. speed_m_s: of the robot over ground, 0 where it got nowhere. Raises BadInput.
    """

    number: int
    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    speed_m_s: float
    speed_sigma_m_s: float
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def __post_init__(self) -> None:
        check_number("number", self.number, 1)
        Gait(self.alpha_rad, self.beta_rad, self.omega_rad_s)
        check_number("speed_m_s", self.speed_m_s, 0.0, MAX_SPEED_M_S)
        check_number("speed_sigma_m_s", self.speed_sigma_m_s, 0.0, MAX_SPEED_M_S, open_low=True)

    @property
    def gait(self) -> Gait:
        """Return the gait that was run."""
        return Gait(self.alpha_rad, self.beta_rad, self.omega_rad_s)


@dataclass(frozen=True, slots=True)
class ZeroReading:
    """The inclinometer read twice on one spot, the second time turned end for end.

    What stays of the sum is twice its zero. before: taken before the first station.
    """

    number: int
    shown_rad: float
    reversed_rad: float
    before: bool = True
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    uncertainty: Uncertainty | None = None

    def __post_init__(self) -> None:
        for name in ("shown_rad", "reversed_rad"):
            check_number(name, getattr(self, name), *map(math.radians, (-45.0, 45.0)))

    @property
    def zero_rad(self) -> float:
        """Return what the inclinometer shows where it is level."""
        return (self.shown_rad + self.reversed_rad) / 2


@dataclass(frozen=True, slots=True)
class BendCheck:
    """The protractor held between two neighbouring links of a bent robot."""

    number: int
    lambda_rad: float
    between_links_rad: float
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    @property
    def found_rad(self) -> float:
        """Return the lambda that the protractor shows: links stand at pi - 2 lambda."""
        return (math.pi - self.between_links_rad) / 2


@dataclass(frozen=True, slots=True)
class Zero:
    """What is known of the inclinometer's zero: to be taken off every incline it shows."""

    value_rad: float
    sigma_rad: float
    readings: int


@dataclass(frozen=True, slots=True)
class TreadmillSteps:
    """What a treadmill can be set to: most home ones by 0.5 % of grade and 0.1 km/h."""

    incline_step_rad: float = 0.005
    belt_step_m_s: float = 0.1 / 3.6
    belt_least_m_s: float = 0.0

    def __post_init__(self) -> None:
        check_number("incline_step_rad", self.incline_step_rad, 0.0, open_low=True)
        check_number("belt_step_m_s", self.belt_step_m_s, 0.0, open_low=True)
        check_number("belt_least_m_s", self.belt_least_m_s, 0.0, MAX_SPEED_M_S)


@dataclass(frozen=True, slots=True)
class Stopwatch:
    """Standard deviations of a gait run's distance (tape and marks) and time (a hand's)."""

    distance_sigma_m: float = 0.005
    time_sigma_s: float = 0.2

    def __post_init__(self) -> None:
        check_number("distance_sigma_m", self.distance_sigma_m, 0.0)
        check_number("time_sigma_s", self.time_sigma_s, 0.0)

    def speed(self, distance_m: float, time_s: float) -> tuple[float, float]:
        """Return the mean speed over a distance and its standard deviation, m/s."""
        speed_m_s = distance_m / time_s
        off_m = math.hypot(self.distance_sigma_m, speed_m_s * self.time_sigma_s)
        return speed_m_s, off_m / time_s


@dataclass(frozen=True, slots=True)
class Procedure:
    """Which stations are to be held: every bend, from the first incline up to the top speed.

    gaits: to be run on level ground afterwards, each gait_runs times. ratchet: wheels roll harder
    backwards, so that straight stations are held a second time, facing up the belt.
    """

    lambda_rad: tuple[float, ...]
    incline_start_rad: float
    incline_step_rad: float
    belt_speed_max_m_s: float
    gravity_m_s2: float
    gaits: tuple[Gait, ...] = ()
    gait_runs: int = 3
    ratchet: bool = False


@dataclass(frozen=True, slots=True)
class Setup:
    """All of a session but its readings; two sessions may be joined only if theirs are equal.

    kind: measured, regenerated (from published fits) or simulated. source, note: where the
    readings come from, in words. surface, place, people: of the laboratory, in words. treadmill:
    what it can be set to. stopwatch: how gait runs are timed. weighed: the mass is no assumption.
    """

    name: str
    kind: str
    source: str
    note: str
    robot: Robot
    procedure: Procedure
    uncertainty: Uncertainty
    surface: str = ""
    place: str = ""
    people: str = ""
    treadmill: TreadmillSteps = TreadmillSteps()
    stopwatch: Stopwatch = Stopwatch()
    weighed: bool = True

    @property
    def weight_n(self) -> float:
        """Return the weight of the whole snake, the m g of Eqs. 58 and 60."""
        return self.robot.links * self.robot.link_mass_kg * self.procedure.gravity_m_s2


@dataclass(frozen=True, slots=True)
class Session:
    """A set-up and what was read under it, in the order it was taken, voided readings among it.

    readings: the stations held. gait_runs: measured crawling speeds. zeros: the inclinometer's, by
    reversal. bends: protractor checks. where: what errors call it, the readings' file if there is
    one. folder: where it lies. notes: what reading the files brought up, in words.
    """

    setup: Setup
    readings: tuple[Reading, ...]
    where: str = "session"
    gait_runs: tuple[GaitRun, ...] = ()
    zeros: tuple[ZeroReading, ...] = ()
    bends: tuple[BendCheck, ...] = ()
    folder: Path | None = None
    notes: tuple[str, ...] = ()

    @property
    def kept(self) -> tuple[Reading, ...]:
        """Return the stations that were not voided."""
        return tuple(r for r in self.readings if not r.voided)

    @property
    def kept_gait_runs(self) -> tuple[GaitRun, ...]:
        """Return the gait runs that were not voided."""
        return tuple(r for r in self.gait_runs if not r.voided)

    def uncertainty_of(self, reading: Reading | ZeroReading) -> Uncertainty:
        """Return the uncertainty of the instruments that a reading was taken with."""
        return reading.uncertainty or self.setup.uncertainty

    @property
    def zero(self) -> Zero:
        """Return the inclinometer's zero and its standard deviation.

        Measured by reversal: the mean, with what two readings' errors leave and with half of what
        it moved between before and after; a quarter where it drifted and is followed (zeros_rad).
        Not measured: 0, with what the set-up declares.
        """
        kept = self._kept_zeros
        if not kept:
            return Zero(0.0, self.setup.uncertainty.incline_zero_sigma_rad, 0)
        means = self._zero_sides
        moved_rad = abs(means[-1] - means[0]) / (4 if self.zero_drifts else 2)
        sigma_rad = self._zero_reading_sigma_rad / math.sqrt(len(kept))
        return Zero(sum(means) / len(means), math.hypot(sigma_rad, moved_rad), len(kept))

    @property
    def zero_drifts(self) -> bool:
        """Tell whether the zero is followed: it moved by more than its readings' errors explain."""
        return self.zero_moved_sigmas > FOLLOWED

    @property
    def zero_moved_sigmas(self) -> float:
        """Return how far the zero moved from before to after, in that difference's own errors."""
        means = self._zero_sides
        if len(means) < 2:
            return 0.0
        return abs(means[1] - means[0]) / self.zero_drift_sigma_rad

    def zeros_rad(self, readings: Sequence[Reading]) -> list[float]:
        """Return the zero to be taken off each reading's incline, as it stood at the time.

        A zero that drifts is taken to move evenly from one measurement to the next, in the order
        of readings; else it is the mean for all.
        """
        if not self.zero_drifts:
            return [self.zero.value_rad] * len(readings)
        kept = sorted(self._kept_zeros, key=lambda z: z.number)
        at, found = [z.number for z in kept], [z.zero_rad for z in kept]
        return [float(np.interp(r.number, at, found)) for r in readings]

    @property
    def _kept_zeros(self) -> list[ZeroReading]:
        return [z for z in self.zeros if not z.voided]

    @property
    def _zero_sides(self) -> list[float]:
        """Return the mean zero before and after the stations, those of them that were measured."""
        kept = self._kept_zeros
        sides = [[z.zero_rad for z in kept if z.before is side] for side in (True, False)]
        return [sum(side) / len(side) for side in sides if side]

    @property
    def zero_drift_sigma_rad(self) -> float:
        """Return the error of the difference between both sides' means, rad."""
        sides = [sum(z.before is side for z in self._kept_zeros) for side in (True, False)]
        return self._zero_reading_sigma_rad * math.sqrt(sum(1 / n for n in sides))

    @property
    def _zero_reading_sigma_rad(self) -> float:
        """Return the error of one zero: two readings of the inclinometer, halved."""
        read = [self.uncertainty_of(z).incline_sigma_rad / math.sqrt(2) for z in self._kept_zeros]
        return math.sqrt(sum(s * s for s in read) / len(read))

    @property
    def sha256(self) -> str:
        """Return a hash of all that a friction fit rests on: robot, gravity, zeros, stations."""
        setup = self.setup
        rests_on = [
            repr(setup.robot), setup.procedure.gravity_m_s2, repr(self.zero),
            [[r.lambda_rad, r.incline_rad, r.belt_speed_m_s, r.drift_m_s,
              repr(self.uncertainty_of(r)), *(["up"] if r.facing == "up" else [])]
             for r in self.kept],
            *([self.zeros_rad(self.kept)] if self.zero_drifts else []),
        ]  # fmt: skip
        return hashlib.sha256(json.dumps(rests_on).encode()).hexdigest()
