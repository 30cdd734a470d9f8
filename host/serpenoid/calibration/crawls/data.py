"""What a session's crawls tell: speeds of gaits, and what each may be off by."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ...model.drives import Servo, ServoKind
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ..session import Session
from ..speeds import MODEL_SIGMA, Array, SpeedModel
from .runs import crawls_by_command, mean_speed

LEAST_M_S = 0.001  # of a predicted speed, beside MODEL_SIGMA
GAIN_ELASTICITY = 1.5  # about: per cent of speed for one of amplitude


@dataclass(frozen=True)
class CrawlData:
    """Measured speeds of G gaits on level ground: means of timed runs; films stand alone.

    gaits: as filmed, where they were, else as commanded. sigma_m_s: standard deviations, what the
    model leaves out among them. commanded: as of `SpeedModel`; () where there is no film. gain,
    gain_sigma: of the films, the joints' mean amplitude over the commanded one. numbers: of each
    gait's readings.
    """

    gaits: tuple[Gait, ...]
    speed_m_s: Array
    sigma_m_s: Array
    commanded: tuple[Gait | None, ...] = ()
    gain: Array = field(default_factory=lambda: np.zeros(0))
    gain_sigma: Array = field(default_factory=lambda: np.zeros(0))
    numbers: tuple[tuple[int, ...], ...] = ()

    @classmethod
    def of(cls, session: Session) -> CrawlData:
        """Take a session's kept gait runs and films, as on level ground."""
        rows = []
        for crawl in crawls_by_command(session):
            # what the model leaves out is the same in all rows of a gait
            model = math.sqrt(bool(crawl.timed) + len(crawl.films)) * MODEL_SIGMA
            if crawl.timed:
                numbers = tuple(run.number for run in crawl.timed)
                speed = mean_speed(crawl.timed)
                rows.append((crawl.commanded, None, model, *speed, numbers, None))
            for film in crawl.films:
                off = math.hypot(model, GAIN_ELASTICITY * film.gain_sigma)
                speed = film.speed_m_s, film.speed_sigma_m_s
                rows.append((crawl.gait, crawl.commanded, off, *speed, (film.number,), film))
        gaits, asked, off, speeds, sigmas, numbers, films = (
            zip(*rows, strict=True) if rows else ((),) * 7
        )
        kept = [film for film in films if film]
        left_out = np.array(off) * np.array(speeds)
        return cls(
            gaits,
            np.array(speeds),
            np.hypot(np.hypot(sigmas, left_out), LEAST_M_S),
            asked,
            np.array([film.mean_gain for film in kept]),
            np.array([film.gain_sigma for film in kept]),
            numbers,
        )

    def __len__(self) -> int:
        """Return how many gaits there are."""
        return len(self.gaits)

    def model(self, robot: Robot, ground: Ground) -> SpeedModel:
        """Return what solves for speeds; ground: from whose states others are sought."""
        return SpeedModel(robot, ground, self.gaits, self.commanded or (None,) * len(self))


def servos_of(kind: ServoKind | None, count: int, seed: int = 0) -> tuple[Servo, ...]:
    """Return so many servos of a kind, the typical one if it is exact, or none."""
    if kind is None:
        return ()
    return (kind.servo,) if kind.exact else tuple(kind.draws(count, seed))
