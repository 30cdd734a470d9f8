"""What a session's crawls tell: speeds of gaits, and what each may be off by."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...model.drives import Servo, ServoKind
from ...model.errors import NotConverged
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...periodic.servo_steady import moved_by
from ...periodic.steady import steady_gait
from ..friction_result import ground_of
from ..session import Session
from ..speed_samples import scaled, speed
from .runs import runs_by_gait

Array = NDArray[np.float64]
# Of a predicted speed, relative and m/s: joints' centres and amplitudes that differ, as by 0.5 deg.
MODEL_SIGMA, LEAST_M_S = 0.01, 0.001
GAIN_ELASTICITY = 1.5  # about: per cent of speed for one of amplitude
GAIN_SIGMA = 0.005  # of an amplitude that a servo is predicted to make
SERVO_DRAWS = 96
Speeds = Callable[[Array, Array], Array]  # (K, 4) frictions, (K,) amplitudes -> (K, gaits), m/s


@dataclass(frozen=True)
class ServoEffects:
    """What each of S servos does to G gaits.

    share: of the ideal speed; where a film showed the joints, of that with the amplitude seen.
    amplitude: made over commanded, (S, films); amplitude_sigma: what that may be off by.
    """

    servos: tuple[Servo, ...]
    share: Array
    amplitude: Array
    amplitude_sigma: float = GAIN_SIGMA

    @classmethod
    def none(cls, gaits: int, films: int) -> ServoEffects:
        """Return those of joints that follow the gait."""
        return cls((), np.ones((1, gaits)), np.ones((1, films)), 0.0)


@dataclass(frozen=True)
class CrawlData:
    """Measured speeds of G gaits, mean of their runs.

    sigma_m_s: standard deviations, what the model leaves out among them. seen: the gaits whose
    joints a film showed, so that the common amplitude does not count. numbers: of the readings.
    asked: the gaits as commanded. gain, gain_sigma: of those seen, the joints' mean amplitude over
    the commanded one.
    """

    gaits: tuple[Gait, ...]
    speed_m_s: Array
    sigma_m_s: Array
    seen: NDArray[np.bool_]
    numbers: tuple[tuple[int, ...], ...]
    asked: tuple[Gait, ...] = ()
    gain: Array = field(default_factory=lambda: np.zeros(0))
    gain_sigma: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(cls, session: Session) -> CrawlData:
        """Take a session's kept gait runs and films."""
        films = {film.gait: film for film in session.kept_films}
        rows = []
        for gait, runs in runs_by_gait(session).items():
            weights = np.array([r.speed_sigma_m_s for r in runs]) ** -2.0
            mean = float(weights @ np.array([r.speed_m_s for r in runs]) / weights.sum())
            film = films.get(gait)
            joints = GAIN_ELASTICITY * film.gain_sigma if film else 0.0
            off = math.hypot(MODEL_SIGMA, joints) * mean
            sigma = math.hypot(weights.sum() ** -0.5, off, LEAST_M_S)
            asked = film.commanded if film else gait
            rows.append((gait, mean, sigma, film is not None, tuple(r.number for r in runs), asked))
        gaits, speeds, sigmas, seen, numbers, asked = zip(*rows, strict=True) if rows else ((),) * 6
        kept = [films[gait] for gait in gaits if gait in films]
        return cls(
            gaits, np.array(speeds), np.array(sigmas), np.array(seen, dtype=bool), numbers, asked,
            np.array([film.mean_gain for film in kept]),
            np.array([film.gain_sigma for film in kept]),
        )  # fmt: skip

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

    def effects(
        self, robot: Robot, ground: Ground, kind: ServoKind | None, seed: int = 0
    ) -> ServoEffects:
        """Return what servos of a kind do to these gaits on some ground."""
        films = int(self.seen.sum())
        if kind is None:
            return ServoEffects.none(len(self), films)
        servos = (kind.servo,) if kind.exact else tuple(kind.draws(SERVO_DRAWS, seed))
        return effects_of(robot, ground, self.asked or self.gaits, self.seen.tolist(), servos)


def effects_of(
    robot: Robot, ground: Ground, gaits: Sequence[Gait], seen: Sequence[bool],
    servos: tuple[Servo, ...],
) -> ServoEffects:  # fmt: skip
    """Return what some servos do to commanded gaits; seen: those whose joints a film showed."""
    ideal = [steady_gait(robot, ground, g, rtol=1e-3, powers=False) for g in gaits]
    jobs = [(state, one, film) for one in servos for state, film in zip(ideal, seen, strict=True)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = np.array(list(pool.map(lambda job: moved_by(*job), jobs)))
    found = found.reshape(len(servos), len(gaits), 2)
    return ServoEffects(
        servos, np.maximum(found[..., 0], 1e-3), found[:, np.asarray(seen, dtype=bool), 1]
    )


def _or_nothing(robot: Robot, ground: Ground, gait: Gait) -> float:
    """Return the speed, 0 where the solver finds none: so strange frictions are not the answer."""
    try:
        return speed(robot, ground, gait)
    except NotConverged:
        return 0.0
