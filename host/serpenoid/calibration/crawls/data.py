"""What a session's crawls tell: speeds of gaits, and what each may be off by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...model.drives import Servo, ServoKind
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...session.film import FilmReading
from ...session.gait_run import GaitRun
from ...session.session import Session
from ..speeds import LEAST_M_S, MODEL_SIGMA, Array, SpeedModel

# Commands that differ by less are one command: a film shows its rate, and may show its angles.
_SAME_RATE, _SAME_RAD = 0.01, 0.01
GAIN_ELASTICITY = 1.5  # about: per cent of speed for one of amplitude


@dataclass(frozen=True)
class CrawlData:
    """Measured speeds of G gaits on level ground: means of timed runs; films stand alone.

    gaits: as filmed, where they were, else as commanded. sigma_m_s: standard deviations, what the
    model leaves out among them. commanded: as of `SpeedModel`; () where there is no film. gain,
    gain_sigma: of the films, the joints' mean amplitude over the commanded one.
    """

    gaits: tuple[Gait, ...]
    speed_m_s: Array
    sigma_m_s: Array
    commanded: tuple[Gait | None, ...] = ()
    gain: Array = field(default_factory=lambda: np.zeros(0))
    gain_sigma: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(cls, session: Session) -> CrawlData:
        """Take a session's kept gait runs and films, as on level ground."""
        rows = []
        for crawl in crawls_by_command(session):
            # what the model leaves out is the same in all rows of a gait
            model = math.sqrt(bool(crawl.timed) + len(crawl.films)) * MODEL_SIGMA
            if crawl.timed:
                rows.append((crawl.commanded, None, model, *mean_speed(crawl.timed), None))
            for film in crawl.films:
                off = math.hypot(model, GAIN_ELASTICITY * film.gain_sigma)
                speed = film.speed_m_s, film.speed_sigma_m_s
                rows.append((crawl.gait, crawl.commanded, off, *speed, film))
        gaits, asked, off, speeds, sigmas, films = zip(*rows, strict=True) if rows else ((),) * 6
        kept = [film for film in films if film]
        left_out = np.array(off) * np.array(speeds)
        return cls(
            gaits,
            np.array(speeds),
            np.hypot(np.hypot(sigmas, left_out), LEAST_M_S),
            asked,
            np.array([film.mean_gain for film in kept]),
            np.array([film.gain_sigma for film in kept]),
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


@dataclass(frozen=True)
class Crawls:
    """All timed runs and films of one command."""

    commanded: Gait
    timed: tuple[GaitRun, ...] = ()
    films: tuple[FilmReading, ...] = ()

    @property
    def runs(self) -> tuple[GaitRun, ...]:
        """Return the timed runs, and what the films say as runs."""
        return (*self.timed, *(film.gait_run for film in self.films))

    @property
    def gait(self) -> Gait:
        """Return the gait with the mean of the joints as filmed; without films the command."""
        return mean_gait([film.gait for film in self.films]) if self.films else self.commanded


def crawls_by_command(session: Session) -> list[Crawls]:
    """Return the crawls of every command, the slowest first; films there and back are of one."""
    crawls: list[Crawls] = []
    timed = [Crawls(run.gait, timed=(run,)) for run in session.kept_gait_runs]
    for new in [*timed, *(Crawls(film.commanded, films=(film,)) for film in session.kept_films)]:
        same = [k for k, c in enumerate(crawls) if same_command(c.commanded, new.commanded)]
        if same:
            known = crawls[same[0]]
            both = known.timed + new.timed, known.films + new.films
            crawls[same[0]] = Crawls(known.commanded, *both)
        else:
            crawls.append(new)
    return sorted(crawls, key=lambda crawl: crawl.commanded.omega_rad_s)


def mean_speed(runs: Sequence[GaitRun]) -> tuple[float, float]:
    """Return the weighted mean speed of some runs, and its standard deviation, m/s."""
    weights = np.array([r.speed_sigma_m_s for r in runs]) ** -2.0
    mean = weights @ np.array([r.speed_m_s for r in runs]) / weights.sum()
    return float(mean), float(weights.sum() ** -0.5)


def as_run(session: Session, gaits: Sequence[Gait]) -> tuple[Gait, ...]:
    """Return the gaits, each with the rate at which it ran, if it ran."""
    ran = [crawl.commanded for crawl in crawls_by_command(session)]
    return tuple(next((own for own in ran if same_command(own, gait)), gait) for gait in gaits)


def same_command(one: Gait, other: Gait) -> bool:
    """Tell whether two commands differ by no more than a film may be off."""
    angles = np.array([[g.alpha_rad, g.beta_rad, g.offset_rad] for g in (one, other)])
    alike = (one.joint_gain, one.joint_shift_rad) == (other.joint_gain, other.joint_shift_rad)
    near = np.abs(angles[0] - angles[1]).max() < _SAME_RAD
    return alike and near and abs(other.omega_rad_s / one.omega_rad_s - 1.0) < _SAME_RATE


def mean_gait(gaits: Sequence[Gait]) -> Gait:
    """Return the gait of the mean joints."""
    if len(gaits) == 1:
        return gaits[0]
    joints = max(len(gait.joint_gain) for gait in gaits)
    gain, shift = np.mean([gait.joint_factors(joints) for gait in gaits], axis=0)
    return replace(
        gaits[0],
        omega_rad_s=float(np.mean([g.omega_rad_s for g in gaits])),
        offset_rad=float(np.mean([g.offset_rad for g in gaits])),
        joint_gain=tuple(gain.tolist()),
        joint_shift_rad=tuple(shift.tolist()),
    )
