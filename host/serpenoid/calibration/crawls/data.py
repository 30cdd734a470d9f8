"""What a session's crawls tell: speeds of gaits, and what each may be off by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...model.drives import Servo, ServoKind
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ..friction_result import Estimate
from ..kinds.gait import RUN_WAYS, GaitRun
from ..kinds.video import FilmReading
from ..session import Session
from ..speed_samples import MODEL_SIGMA, scaled
from .runs import crawls_by_command
from .servos import ENDS, SERVO_DRAWS, ServoEffects, effects_of
from .slope import sloped_speed
from .speeds import Array, Speeds, SpeedSolver

LEAST_M_S = 0.001  # of a predicted speed, beside MODEL_SIGMA
SLOPE_SIGMA = 0.2  # of what a slope does to a speed: friction is not yet as it will be fitted
Crawl = tuple[Robot, Ground, Gait, Servo | None]
GAIN_ELASTICITY = 1.5  # about: per cent of speed for one of amplitude


@dataclass(frozen=True)
class CrawlData:
    """Measured speeds of G gaits: means of timed runs that went the same way; films stand alone.

    sigma_m_s: standard deviations, what the model leaves out among them. seen: the gaits whose
    joints a film showed, so that the common amplitude does not count. numbers: of the readings.
    asked: the gaits as commanded. gain, gain_sigma: of those seen, the joints' mean amplitude over
    the commanded one. ways: shares of a gait's runs that went there and back on a floor.
    """

    gaits: tuple[Gait, ...]
    speed_m_s: Array
    sigma_m_s: Array
    seen: NDArray[np.bool_]
    numbers: tuple[tuple[int, ...], ...]
    asked: tuple[Gait, ...] = ()
    gain: Array = field(default_factory=lambda: np.zeros(0))
    gain_sigma: Array = field(default_factory=lambda: np.zeros(0))
    ways: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(cls, session: Session) -> CrawlData:
        """Take a session's kept gait runs and films."""
        rows: list[tuple[Gait, Gait, Sequence[GaitRun], FilmReading | None, int]] = []
        for crawl in crawls_by_command(session):
            asked, ways = crawl.commanded, dict.fromkeys(run.way for run in crawl.timed)
            count = len(crawl.films) + len(ways)
            for way in ways:
                timed = [run for run in crawl.timed if run.way == way]
                rows.append((asked, asked, timed, None, count))
            rows += [(crawl.gait, asked, [f.gait_run], f, count) for f in crawl.films]
        gaits, asked, runs, films, counts = zip(*rows, strict=True) if rows else ((),) * 5
        speeds = [_speed_of(*row) for row in zip(runs, films, counts, strict=True)]
        speed_m_s, sigma_m_s, ways = zip(*speeds, strict=True) if rows else ((),) * 3
        kept = [film for film in films if film]
        return cls(
            gaits,
            np.array(speed_m_s),
            np.array(sigma_m_s),
            np.array([film is not None for film in films], dtype=bool),
            tuple(tuple(r.number for r in of) for of in runs),
            asked,
            np.array([film.mean_gain for film in kept]),
            np.array([film.gain_sigma for film in kept]),
            ways,
        )

    def __len__(self) -> int:
        """Return how many gaits there are."""
        return len(self.gaits)

    def of_robot(self, robot: Robot, at: Array) -> Speeds:
        """Return what solves for the speeds of a robot whose joints follow the gait.

        at: frictions, whole snake, (4,), about those that will be asked for.
        """
        return SpeedSolver(robot, self.gaits, self.seen.tolist(), at)

    def effects(
        self,
        robot: Robot,
        ground: Ground,
        kind: ServoKind | None,
        ends: tuple[float, float] = ENDS,
        seed: int = 0,
        count: int = SERVO_DRAWS,
    ) -> ServoEffects:
        """Return what some servos of a kind do to these gaits; ends: see `effects_of`."""
        films = int(self.seen.sum())
        if kind is None:
            return ServoEffects.none(len(self), films)
        servos = (kind.servo,) if kind.exact else tuple(kind.draws(count, seed))
        return effects_of(robot, ground, self.asked or self.gaits, self.seen.tolist(), servos, ends)

    def on_slope(
        self,
        robot: Robot,
        ground: Ground,
        slope: Estimate,
        servo: Servo | None = None,
        amplitude: float = 1.0,
    ) -> CrawlData:
        """Return the speeds as they would be on level ground.

        slope: of the floor, which falls towards "there". What it does to a crawl is simulated; its
        doubt is added to the sigmas. servo, amplitude: what moves the joints, and their amplitude
        over the commanded one; None: joints do what was seen. A weak servo's crawl can feel a slope
        twice as much.
        """
        if not any(self.sloped):
            return self
        ends, asked = (-1.0, 0.0, 1.0), self.asked or self.gaits
        moved = self.gaits if servo is None else tuple(scaled(g, amplitude) for g in asked)
        factors = np.array(
            [
                [
                    self._factor(
                        (robot, ground, gait, servo), ways, slope.value + end * slope.sigma
                    )
                    for end in ends
                ]
                for gait, ways in zip(moved, self.ways, strict=True)
            ]
        )
        odd, even = factors[:, 2] - factors[:, 0], factors[:, 2] + factors[:, 0] - 2 * factors[:, 1]
        mean, spread = factors[:, 1] + even / 2, np.hypot(odd / 2, even / math.sqrt(2))
        level = self.speed_m_s / mean
        off = np.hypot(spread, SLOPE_SIGMA * (1.0 - mean)) / mean * level
        return replace(self, speed_m_s=level, sigma_m_s=np.hypot(self.sigma_m_s / mean, off))

    @property
    def sloped(self) -> list[bool]:
        """Return of each gait whether it ran there or back on a floor."""
        return [any(ways) for ways in self.ways]

    @staticmethod
    def _factor(crawl: Crawl, ways: tuple[float, float], slope_rad: float) -> float:
        """Return the mean speed of a gait's runs over that on level ground."""
        robot, ground, gait, servo = crawl
        level = max(sloped_speed(robot, ground, gait, 0.0, servo), 1e-6)
        own = 1.0 - sum(ways)
        for share, slope in zip(ways, (-slope_rad, slope_rad), strict=True):
            if share:
                own += share * sloped_speed(robot, ground, gait, slope, servo) / level
        return max(own, 0.05)


def _speed_of(
    runs: Sequence[GaitRun], film: FilmReading | None, films: int
) -> tuple[float, float, tuple[float, float]]:
    """Return the mean speed of a gait's runs, its sigma, and the shares that went there and back.

    films: how many rows there are of this gait: what the model leaves out is the same in all.
    """
    weights = np.array([r.speed_sigma_m_s for r in runs]) ** -2.0
    weights, sigma = weights / weights.sum(), float(weights.sum() ** -0.5)
    mean = float(weights @ np.array([r.speed_m_s for r in runs]))
    joints = GAIN_ELASTICITY * film.gain_sigma if film else 0.0
    off = math.hypot(math.sqrt(films) * MODEL_SIGMA, joints) * mean
    there, back = (float(weights[[r.way == way for r in runs]].sum()) for way in RUN_WAYS[1:])
    return mean, math.hypot(sigma, off, LEAST_M_S), (there, back)
