"""What a session's crawls tell: speeds of gaits, and what each may be off by."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...model.drives import Servo, ServoKind
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...periodic.drawn_states import drawn_speeds
from ..friction_result import ground_of
from ..session import Session
from ..speed_samples import MODEL_SIGMA, scaled
from .runs import crawls_by_command, mean_speed
from .servos import ENDS, ServoEffects, effects_of

Array = NDArray[np.float64]
Speeds = Callable[[Array, Array], Array]  # (K, P) frictions, (K,) amplitudes -> (K, gaits), m/s

LEAST_M_S = 0.001  # of a predicted speed, beside MODEL_SIGMA
GAIN_ELASTICITY = 1.5  # about: per cent of speed for one of amplitude


@dataclass(frozen=True)
class CrawlData:
    """Measured speeds of G gaits on level ground: means of timed runs; films stand alone.

    asked: the gaits as commanded; gaits: as filmed, where they were. sigma_m_s: standard
    deviations, what the model leaves out among them. seen: the gaits whose joints a film showed, so
    that the common amplitude does not count. gain, gain_sigma: of those, the joints' mean amplitude
    over the commanded one. numbers: of each gait's readings.
    """

    gaits: tuple[Gait, ...]
    asked: tuple[Gait, ...]
    speed_m_s: Array
    sigma_m_s: Array
    seen: NDArray[np.bool_]
    gain: Array = field(default_factory=lambda: np.zeros(0))
    gain_sigma: Array = field(default_factory=lambda: np.zeros(0))
    numbers: tuple[tuple[int, ...], ...] = ()

    @classmethod
    def of(cls, session: Session) -> CrawlData:
        """Take a session's kept gait runs and films, as on level ground."""
        rows = []
        for crawl in crawls_by_command(session):
            asked = crawl.commanded
            timed = (
                [(asked, None, *mean_speed(crawl.timed), tuple(r.number for r in crawl.timed))]
                if crawl.timed
                else []
            )
            filmed = [
                (crawl.gait, film, film.speed_m_s, film.speed_sigma_m_s, (film.number,))
                for film in crawl.films
            ]
            # what the model leaves out is the same in all rows of a gait
            model = math.sqrt(len(timed) + len(filmed)) * MODEL_SIGMA
            rows += [(asked, model, *row) for row in timed + filmed]
        asked, model, gaits, films, speeds, sigmas, numbers = (
            zip(*rows, strict=True) if rows else ((),) * 7
        )
        joints = [GAIN_ELASTICITY * film.gain_sigma if film else 0.0 for film in films]
        off = np.hypot(model, joints) * speeds
        kept = [film for film in films if film]
        return cls(
            gaits,
            asked,
            np.array(speeds),
            np.hypot(np.hypot(sigmas, off), LEAST_M_S),
            np.array([film is not None for film in films], dtype=bool),
            np.array([film.mean_gain for film in kept]),
            np.array([film.gain_sigma for film in kept]),
            numbers,
        )

    def __len__(self) -> int:
        """Return how many gaits there are."""
        return len(self.gaits)

    def of_robot(self, robot: Robot, at: Array) -> Speeds:
        """Return what solves for the speeds of a robot whose joints follow the gait.

        at: frictions, whole snake, (P,), from whose states the others are sought. A speed that is
        not found is 0, so that strange frictions are not the answer.
        """
        pairs = list(zip(self.gaits, self.seen.tolist(), strict=True))
        near = ground_of(robot.links, at.tolist())

        def speeds(whole: Array, amplitude: Array) -> Array:
            grounds = [ground_of(robot.links, own) for own in whole.tolist()]

            def of(gait: Gait, seen: bool) -> Array:
                made = [gait if seen else scaled(gait, a) for a in amplitude.tolist()]
                draws = list(zip(grounds, made, strict=True))
                return drawn_speeds(robot, (near, made[0]), draws, unfound_m_s=0.0)

            solved = {pair: of(*pair) for pair in dict.fromkeys(pairs)}
            return np.stack([solved[pair] for pair in pairs], axis=1)

        return speeds

    def effects(
        self,
        robot: Robot,
        ground: Ground,
        servos: tuple[Servo, ...],
        ends: tuple[float, float] = ENDS,
    ) -> ServoEffects:
        """Return what some servos do to these gaits; none of them: joints follow the gait."""
        if not servos:
            return ServoEffects.none(len(self), int(self.seen.sum()))
        return effects_of(robot, ground, self.asked, self.seen.tolist(), servos, ends)


def servos_of(kind: ServoKind | None, count: int, seed: int = 0) -> tuple[Servo, ...]:
    """Return so many servos of a kind, the typical one if it is exact, or none."""
    if kind is None:
        return ()
    return (kind.servo,) if kind.exact else tuple(kind.draws(count, seed))
