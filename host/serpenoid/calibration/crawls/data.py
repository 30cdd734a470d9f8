"""What a session's crawls tell: speeds of gaits, and what each may be off by."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...model.drives import ServoKind
from ...model.errors import NotConverged
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...periodic.servo_steady import servo_speeds
from ...periodic.steady import steady_gait
from ..friction_result import ground_of
from ..session import Session
from ..speed_samples import scaled, speed
from .runs import runs_by_gait

Array = NDArray[np.float64]
# Of a predicted speed, relative and m/s: joints' centres and amplitudes that differ, as by 0.5 deg.
MODEL_SIGMA, LEAST_M_S = 0.01, 0.001
GAIN_ELASTICITY = 1.5  # about: per cent of speed for one of amplitude
SERVO_DRAWS = 48
Speeds = Callable[[Array, Array], Array]  # (K, 4) frictions, (K,) amplitudes -> (K, gaits), m/s


@dataclass(frozen=True)
class CrawlData:
    """Measured speeds of G gaits, mean of their runs.

    sigma_m_s: standard deviations, what the model leaves out among them. seen: the gaits whose
    joints a film showed, so that the common amplitude does not count. numbers: of the readings.
    """

    gaits: tuple[Gait, ...]
    speed_m_s: Array
    sigma_m_s: Array
    seen: NDArray[np.bool_]
    numbers: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, session: Session) -> CrawlData:
        """Take a session's kept gait runs and films."""
        gains = {film.gait: film.gain_sigma for film in session.kept_films}
        rows = []
        for gait, runs in runs_by_gait(session).items():
            weights = np.array([r.speed_sigma_m_s for r in runs]) ** -2.0
            mean = float(weights @ np.array([r.speed_m_s for r in runs]) / weights.sum())
            joints = GAIN_ELASTICITY * gains.get(gait, 0.0)
            off = math.hypot(MODEL_SIGMA, joints) * mean
            sigma = math.hypot(weights.sum() ** -0.5, off, LEAST_M_S)
            rows.append((gait, mean, sigma, gait in gains, tuple(r.number for r in runs)))
        gaits, speeds, sigmas, seen, numbers = zip(*rows, strict=True) if rows else ((),) * 5
        return cls(gaits, np.array(speeds), np.array(sigmas), np.array(seen, dtype=bool), numbers)

    def __len__(self) -> int:
        """Return how many gaits there are."""
        return len(self.gaits)

    def of_robot(self, robot: Robot) -> Speeds:
        """Return what solves for the speeds of a robot whose joints follow the gait."""

        def at(pair: tuple[list[float], float]) -> list[float]:
            ground = ground_of(robot.links, pair[0])
            made = [g if s else scaled(g, pair[1]) for g, s in zip(self.gaits, self.seen,
                                                                   strict=True)]  # fmt: skip
            return [_or_nothing(robot, ground, gait) for gait in made]

        def speeds(whole: Array, amplitude: Array) -> Array:
            pairs = list(zip(whole.tolist(), amplitude.tolist(), strict=True))
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                return np.array(list(pool.map(at, pairs)))

        return speeds

    def shares(self, robot: Robot, ground: Ground, kind: ServoKind | None) -> Array:
        """Return what servos of a kind leave of the speeds on some ground, (servos, gaits)."""
        if kind is None:
            return np.ones((1, len(self)))
        servos = [kind.servo] if kind.exact else kind.draws(SERVO_DRAWS)
        ideal = [steady_gait(robot, ground, g, rtol=1e-3, powers=False) for g in self.gaits]
        found = servo_speeds((state, one) for one in servos for state in ideal)
        own = np.array([max(state.speed_m_s, 1e-9) for state in ideal])
        return np.maximum(found.reshape(len(servos), len(self)) / own, 1e-3)


def _or_nothing(robot: Robot, ground: Ground, gait: Gait) -> float:
    """Return the speed, 0 where the solver finds none: so strange frictions are not the answer."""
    try:
        return speed(robot, ground, gait)
    except NotConverged:
        return 0.0
