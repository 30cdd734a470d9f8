"""How often `compare`'s verdict is right: sessions by the real procedure, runs with a known fault.

A session is taken on the simulated treadmill and fitted. Then the lab's robot crawls with a servo
drawn at random, and with a fault that is known; the speeds are measured with tape and stopwatch as
in a session. The joints' amplitude is each time another, as far off as the comparison is told that
it may be.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from coverage_treadmill import INCLINE_STEP_DEG, WHOLE, WHOLE_2005, shown_in_steps
from numpy.typing import NDArray
from serpenoid import Gait, Robot, Servo, fit_friction, servo
from serpenoid.calibration.crawls.data import CrawlData
from serpenoid.calibration.friction_result import ground_of, whole_ground
from serpenoid.calibration.speeds import AMPLITUDE_SIGMA, scaled, speed
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.robot import LabRobot
from serpenoid.prediction.speed_samples import sample_speeds
from serpenoid.prediction.verdict import Judge
from serpenoid.taking.new_session import default_setup
from serpenoid.taking.simulated import SimulatedPerson
from serpenoid.taking.treadmill import take_all
from serpenoid.taking.world import RUN_M, RUN_S
from simulated_sessions import MemoryRecord, drawn_truth
from study import Study

Array = NDArray[np.float64]
MORE = "two of them or more"
WORDS = ("agrees", "friction", "amplitude", "servos", MORE, "neither")
HOBBY, KNOWN = "hobby", "XL-330"  # kinds of servo that the comparison is told
_SERVOS = 4  # of each kind, that sessions share
_POINTS, _MOST_SIGMAS, _DRAWN = 9, 3.0, 11


@dataclass(frozen=True)
class Fault:
    """What is wrong when the robot crawls; right: the verdict that would be right.

    frictions: shares of ct, cn, ft0, fn0 at the treadmill. amplitude: share of the joints'.
    uphill_deg: of the ground. ruler: true length of a metre that the tape shows. beta: share of
    the phase lag. stated: the kind of servo that the comparison is told; servo: what really moves
    the joints, where it is none of this kind.
    """

    name: str
    right: str
    frictions: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    amplitude: float = 1.0
    uphill_deg: float = 0.0
    ruler: float = 1.0
    beta: float = 1.0
    stated: str = HOBBY
    servo: Servo | None = None

    def ideal(self, robot: Robot, gaits: Sequence[Gait], amplitude: float) -> list[float]:
        """Return the speeds on the level of joints that follow the gait, m/s."""
        ground = ground_of(robot.links, (np.array(self.frictions) * WHOLE).tolist())
        return [speed(robot, ground, g) for g in self._made(gaits, amplitude)]

    def driven(self, robot: Robot, gaits: Sequence[Gait], servo: Servo) -> list[float]:
        """Return the speeds of the lab's robot as a tape shows them, m/s."""
        ground = whole_ground((np.array(self.frictions) * WHOLE).tolist())
        moved = LabRobot.whole(robot, ground, servo=self.servo or servo)
        slope = math.radians(self.uphill_deg)
        made = self._made(gaits, 1.0)
        return [crawl_speed(moved, g, slope_rad=slope) / self.ruler for g in made]

    def _made(self, gaits: Sequence[Gait], amplitude: float) -> list[Gait]:
        made = [scaled(g, amplitude * self.amplitude) for g in gaits]
        return [replace(g, beta_rad=g.beta_rad * self.beta) for g in made]


def _jerky() -> Servo:
    """Return a hobby servo that makes much ripple: a light rotor, a stiff loop, a dry gear."""
    typical = servo(HOBBY).servo
    return replace(
        typical,
        armature_kg_m2=0.4 * typical.armature_kg_m2,
        stiffness_nm_rad=1.5 * typical.stiffness_nm_rad,
        gear_friction_nm=3 * typical.gear_friction_nm,
    )


def _slow() -> Servo:
    """Return a hobby servo on a tired battery."""
    typical = servo(HOBBY).servo
    return replace(
        typical,
        torque_limit_nm=0.6 * typical.torque_limit_nm,
        speed_limit_rad_s=0.6 * typical.speed_limit_rad_s,
    )


FAULTS = (
    Fault("nothing", "agrees"),
    *(
        Fault(f"ft0 {share - 1:+.0%}", "friction", (1.0, 1.0, share, 1.0))
        for share in (0.6, 0.8, 1.1, 1.2, 1.4)
    ),
    *(
        Fault(f"fn0 {share - 1:+.0%}", "friction", (1.0, 1.0, 1.0, share))
        for share in (0.6, 0.8, 0.9, 1.2, 1.4)
    ),
    *(
        Fault(f"amplitude {share - 1:+.0%}", "amplitude", amplitude=share)
        for share in (0.7, 0.8, 0.85, 0.9, 0.95, 1.1)
    ),
    *(Fault(f"tape {ruler - 1:+.0%}", "neither", ruler=ruler) for ruler in (0.8, 0.9, 1.1, 1.25)),
    Fault("phase lag -15%", "neither", beta=0.85),
    *(Fault(f"{slope:g} deg uphill", "friction", uphill_deg=slope) for slope in (0.25, 0.5, 1.0)),
    Fault("servos without a rotor", "servos", servo=Servo()),
    Fault(f"nothing; {KNOWN} is known", "agrees", stated=KNOWN),
    Fault(f"ft0 +20%; {KNOWN} is known", "friction", (1.0, 1.0, 1.2, 1.0), stated=KNOWN),
    Fault(f"fn0 -20%; {KNOWN} is known", "friction", (1.0, 1.0, 1.0, 0.8), stated=KNOWN),
    Fault(f"amplitude -20%; {KNOWN} is known", "amplitude", amplitude=0.8, stated=KNOWN),
    Fault(f"jerky servos for {KNOWN}", "servos", stated=KNOWN, servo=_jerky()),
    Fault(f"slow servos for {KNOWN}", "servos", stated=KNOWN, servo=_slow()),
)


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


class TrueSpeeds:
    """Speeds of every fault, by the servo and the amplitude that the joints happen to have.

    The lab's robot runs each gait with each of some servos; what another amplitude makes of it is
    taken from joints that follow the gait.
    """

    def __init__(
        self, robot: Robot, gaits: Sequence[Gait], faults: Sequence[Fault], servos: int = _SERVOS
    ):
        most = _MOST_SIGMAS * AMPLITUDE_SIGMA
        self.servos = servos
        self._at = np.linspace(1.0 - most, 1.0 + most, _POINTS)
        self._ideal, self._driven = {}, {}
        drawn = {name: servo(name).draws(servos, _DRAWN) for name in {f.stated for f in faults}}
        for f in faults:
            ideal = np.array([f.ideal(robot, gaits, a) for a in self._at.tolist()])
            self._ideal[f.name] = ideal / np.maximum(ideal[_POINTS // 2], 1e-9)
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                found = pool.map(partial(f.driven, robot, gaits), drawn[f.stated])
                self._driven[f.name] = np.array(list(found))

    def __call__(self, fault: Fault, amplitude: float, number: int) -> Array:
        """Return the speeds of the gaits, m/s, with one of the servos."""
        shares = [np.interp(amplitude, self._at, v) for v in self._ideal[fault.name].T]
        return self._driven[fault.name][number % self.servos] * np.array(shares)


def words(
    faults: tuple[Fault, ...], first_seed: int, number: int, true: TrueSpeeds
) -> dict[str, str]:
    """Take and fit one session; return the verdict on each fault."""
    seed = first_seed + number
    rng = np.random.default_rng([seed, 58])
    setup = replace(shown_in_steps(default_setup("verdicts"), INCLINE_STEP_DEG), kind="simulated")
    gaits, truth = setup.procedure.gaits, drawn_truth(setup, WHOLE_2005, rng)
    stations = replace(setup, procedure=replace(setup.procedure, gaits=()))
    treadmill = SimulatedPerson(stations, truth, int(rng.integers(2**31)))
    fit = fit_friction(take_all(MemoryRecord(stations), treadmill))
    judges = {}
    for name in {f.stated for f in faults}:
        kind = servo(name)
        drawn = sample_speeds(fit, gaits, amplitude_sigma=AMPLITUDE_SIGMA, servo=kind)
        judges[name] = Judge(fit, drawn, AMPLITUDE_SIGMA, seed, kind)

    def measured(speeds: Array) -> CrawlData:
        watch, times = setup.stopwatch, setup.procedure.gait_runs
        way = np.minimum(RUN_M, speeds * RUN_S)
        seconds = np.where(speeds > 0.0, way / np.maximum(speeds, 1e-9), RUN_S)
        shape = (times, len(speeds))
        seen_m = np.maximum(way + watch.distance_sigma_m * rng.normal(size=shape), 0.0)
        seen_s = seconds + watch.time_sigma_s * rng.normal(size=shape)
        runs = [
            [watch.speed(d, t) for d, t in zip(*row, strict=True)]
            for row in zip(seen_m.T.tolist(), seen_s.T.tolist(), strict=True)
        ]
        weights = np.array([[sigma**-2.0 for _, sigma in row] for row in runs])
        means = np.array([[v for v, _ in row] for row in runs])
        total = weights.sum(axis=1)
        return CrawlData(gaits, (weights * means).sum(axis=1) / total, total**-0.5)

    found = {}
    for fault in faults:
        amplitude = 1.0 + AMPLITUDE_SIGMA * float(np.clip(rng.normal(), -3.0, 3.0))
        seen = measured(true(fault, amplitude, int(rng.integers(true.servos))))
        found[fault.name] = judges[fault.stated](seen).word
    return found


def counted(fault: Fault, found: Sequence[dict[str, str]]) -> Verdicts:
    """Count a fault's verdicts."""
    of = Counter(row[fault.name] for row in found)
    seen = len(found) - of["agrees"]
    named = sum(n for word, n in of.items() if fault.right in word.split(" or "))
    counts = {word: of[word] for word in WORDS}
    counts[MORE] = sum(n for word, n in of.items() if " or " in word)
    return Verdicts(
        fault.name,
        fault.right,
        len(found),
        counts,
        seen / len(found),
        named / seen if seen and fault.right != "agrees" else None,
    )


def true_speeds(cases: Sequence[tuple[Fault, ...]]) -> TrueSpeeds:
    """Return the speeds of all faults, by the servos that sessions share."""
    setup = default_setup("verdicts")
    return TrueSpeeds(setup.robot, setup.procedure.gaits, cases[0])


STUDY = Study(
    (FAULTS,), true_speeds, words, lambda faults, results: [counted(f, results) for f in faults]
)


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
