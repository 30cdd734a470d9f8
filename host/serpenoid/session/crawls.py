"""Group a session's gait runs, timed or filmed, by their commands; settings of its servos."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base.vectors import columns
from ..model.drives import FRAME_S, ServoKind
from ..model.gait import Gait
from ..model.robot import frame_us
from .declaration import in_si
from .gait_run import Crawl, FilmReading
from .session import Session
from .settings import Setup


@dataclass(frozen=True)
class Crawls:
    """All gait runs with one command, timed ones first."""

    runs: tuple[Crawl, ...]

    @property
    def commanded(self) -> Gait:
        """Return the command of the first run."""
        return self.runs[0].commanded

    @property
    def films(self) -> tuple[FilmReading, ...]:
        """Return the filmed runs."""
        return tuple(run for run in self.runs if isinstance(run, FilmReading))

    @property
    def gait(self) -> Gait:
        """Return the mean of the filmed gaits; without films the command."""
        films = [film.gait for film in self.films]
        if not films:
            return self.commanded
        numbers = "omega_rad_s", "offset_rad", "joint_gain", "joint_shift_rad"
        means = {name: np.mean([getattr(g, name) for g in films], axis=0) for name in numbers}
        return replace(films[0], **means)


def crawls_by_command(session: Session) -> list[Crawls]:
    """Return the gait runs of each command, in the order of their rates."""
    groups: list[list[Crawl]] = []
    for crawl in session.kept_crawls:
        same = (g for g in groups if same_command(g[0].commanded, crawl.commanded))
        group = next(same, None)
        if group is None:
            groups.append(group := [])
        group.append(crawl)
    groups.sort(key=lambda group: group[0].omega_rad_s)
    return [Crawls(tuple(group)) for group in groups]


def mean_speed(runs: Sequence[Crawl]) -> tuple[float, float]:
    """Return the weighted mean speed of runs, and its standard uncertainty, m/s."""
    speeds_m_s, sigmas_m_s = columns(runs, "speed_m_s", "speed_sigma_m_s")
    mean, weight = np.average(speeds_m_s, weights=sigmas_m_s**-2.0, returned=True)
    return float(mean), float(weight**-0.5)


def as_run(session: Session, gaits: Sequence[Gait]) -> tuple[Gait, ...]:
    """Return the gaits, with their true rates if they were run."""
    ran = [crawl.commanded for crawl in crawls_by_command(session)]
    return tuple(next((g for g in ran if same_command(g, gait)), gait) for gait in gaits)


def same_command(first: Gait, second: Gait) -> bool:
    """Return whether two commands agree to 1 % of the rate and 0.01 rad, the errors of films."""
    max_rate, max_rad = 0.01, 0.01
    angles = [(g.alpha_rad, g.beta_rad, g.offset_rad) for g in (first, second)]
    joints = [(g.joint_gain, g.joint_shift_rad) for g in (first, second)]
    is_same_rate = math.isclose(first.omega_rad_s, second.omega_rad_s, rel_tol=max_rate)
    return is_same_rate and joints[0] == joints[1] and math.dist(*angles) < max_rad


def driving(setup: Setup, kind: ServoKind) -> ServoKind:
    """Return a kind of servo with a session's voltage and frame time, unless it states its own."""
    table = setup.robot_table
    if table.supply_v is not None and kind.sigma.get("supply_v"):
        kind = kind.at_volts(table.supply_v)
    if kind.servo.frame_s != FRAME_S:
        return kind
    own_ms = 1e-3 * frame_us(table.links - 1)
    return kind.at_frames(in_si("frame_ms", table.frame_ms or own_ms))
