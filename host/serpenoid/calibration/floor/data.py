"""The kept pushes and slides of a session as arrays, with what their errors have in common."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..fitting.data import TOGETHER, Floats, Whole, postures, settings
from ..fitting.shared import rolling_share, straightness_factors
from ..kinds.coast import Coast
from ..kinds.slide import Slide
from ..session import Session
from .arc import along

TAPE_M = 0.005  # of a way measured from where a hand let go


@dataclass(frozen=True)
class Poses:
    """How the robot lay in each of K readings: bend, share of bent links, posture (-1: none).

    back: it rolls backwards.
    """

    lambda_rad: Floats
    bent_share: Floats
    posture: Whole
    back: NDArray[np.bool_]


@dataclass(frozen=True)
class Samples:
    """Places over time, or ways and times to rest; `push` says of which push each is."""

    push: Whole
    t_s: Floats
    x_m: Floats
    sigma_m: Floats
    sigma_s: Floats


@dataclass(frozen=True)
class Slides:
    """Slides from rest: incline_rad with the zero taken off, its error, and the time's."""

    poses: Poses
    incline_rad: Floats
    length_m: Floats
    time_s: Floats
    sigma_rad: Floats
    sigma_m: Floats
    sigma_s: Floats


@dataclass(frozen=True)
class FloorData:
    """What is fitted: pushes with samples on their way, pushes known by their rest alone, slides.

    numbers: of the pushes' readings, then of the slides'. way: +1 there, -1 back. place: which line
    of the floor. filmed: its lengths come from a film. tracks, rests: see Samples; a push is in
    one of them. posture_sigma_rad: prior of each bend's offset. rolling: J / r^2 of all wheels over
    the mass, mean and standard deviation. straightness_rad: as FitData's. slope_sigma_rad,
    scale_sigma, zero_sigma_rad: priors of every place's slope, the films' scale and the
    inclinometer's zero.
    """

    numbers: tuple[int, ...]
    poses: Poses
    way: Floats
    place: Whole
    places: tuple[str, ...]
    filmed: NDArray[np.bool_]
    tracks: Samples
    rests: Samples
    slides: Slides
    posture_lambda_rad: Floats
    posture_sigma_rad: Floats
    rolling: tuple[float, float]
    straightness_rad: tuple[float, float]
    slope_sigma_rad: float
    scale_sigma: float
    zero_sigma_rad: float
    mass_kg: float
    gravity_m_s2: float

    @classmethod
    def of(cls, session: Session) -> FloorData:
        """Take a session's kept pushes and slides."""
        pushes, slides = session.kept_pushes, session.kept_slides
        every = (*pushes, *slides)
        given, setup = session.setup.uncertainty, session.setup
        angles = np.array([r.lambda_rad for r in every], dtype=float)
        sigmas = np.full(len(every), given.lambda_sigma_rad)
        posture, posture_rad, posture_sigma = postures(angles, sigmas, settings(session, every))
        share = np.array([session.bent_share(r) for r in every], dtype=float)
        mean, scatter = straightness_factors(setup.robot.links)
        off, cut = given.joint_sigma_rad, len(pushes)
        mass_kg = setup.robot.links * setup.robot.link_mass_kg
        back = np.array([p.facing == "back" for p in pushes], dtype=bool)
        ahead = np.zeros(len(slides), dtype=bool)
        places = tuple(sorted({p.place for p in pushes}))
        return cls(
            numbers=tuple(r.number for r in every),
            poses=Poses(angles[:cut], share[:cut], posture[:cut], back),
            way=np.array([1.0 if p.way == "there" else -1.0 for p in pushes]),
            place=np.array([places.index(p.place) for p in pushes], dtype=np.intp),
            places=places,
            filmed=np.array([p.by == "film" for p in pushes], dtype=bool),
            tracks=_tracks(pushes, setup.floor.push_time_sigma_s),
            rests=_rests(pushes, setup.floor.push_time_sigma_s),
            slides=_slides(session, slides, Poses(angles[cut:], share[cut:], posture[cut:], ahead)),
            posture_lambda_rad=posture_rad,
            posture_sigma_rad=posture_sigma,
            rolling=rolling_share(setup.floor.wheels_kg, mass_kg),
            straightness_rad=(off * mean, off * scatter),
            slope_sigma_rad=setup.floor.slope_sigma_rad,
            scale_sigma=_scale_sigma(pushes, setup.floor.film_scale_sigma),
            zero_sigma_rad=session.zero.sigma_rad or given.incline_sigma_rad,
            mass_kg=mass_kg,
            gravity_m_s2=setup.procedure.gravity_m_s2,
        )

    @property
    def ratchet(self) -> bool:
        """Tell whether a push tells how the robot rolls backwards."""
        return bool(self.poses.back.any())

    @property
    def pushes(self) -> int:
        """Return how many pushes there are."""
        return len(self.way)

    @cached_property
    def posture_whitening(self) -> Floats:
        """Return W that makes the bends' offsets, in sigmas of their priors, independent: W d."""
        count = len(self.posture_sigma_rad)
        together = TOGETHER + (1.0 - TOGETHER) * np.eye(count)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(together)), dtype=np.float64)


def _scale_sigma(pushes: tuple[Coast, ...], stated: float) -> float:
    """Return that of all films' common scale: the largest that a film told, or what is stated."""
    return max([stated, *(push.scale_sigma or 0.0 for push in pushes)])


def _tracks(pushes: tuple[Coast, ...], time_sigma_s: float) -> Samples:
    rows: list[NDArray[np.float64]] = []
    for k, push in enumerate(pushes):
        if push.track is None:
            continue
        t, x, y = (np.array(column) for column in push.counted)
        sigma_m = push.distance_sigma_m or 0.001
        by_hand = push.by == "marks"
        usual_s = time_sigma_s if by_hand else 0.0
        sigma_s = usual_s if push.time_sigma_s is None else push.time_sigma_s
        way = x if by_hand else along(x, y, sigma_m)
        one = np.ones_like(t)
        rows.append(np.stack([k * one, t - t[0], way - way[0], sigma_m * one, sigma_s * one]))
    return _samples(np.concatenate(rows, axis=1) if rows else np.empty((5, 0)))


def _rests(pushes: tuple[Coast, ...], time_sigma_s: float) -> Samples:
    rows = [
        [
            k,
            p.duration_s,
            p.distance_m,
            p.distance_sigma_m or TAPE_M,
            time_sigma_s if p.time_sigma_s is None else p.time_sigma_s,
        ]
        for k, p in enumerate(pushes)
        if p.track is None
    ]
    return _samples(np.array(rows, dtype=float).reshape(-1, 5).T)


def _samples(rows: Floats) -> Samples:
    return Samples(rows[0].astype(np.intp), *rows[1:])


def _slides(session: Session, slides: tuple[Slide, ...], poses: Poses) -> Slides:
    def row(*values: float) -> Floats:
        return np.array(values, dtype=float)

    setup, count = session.setup, len(slides)
    watch_s = setup.floor.push_time_sigma_s
    return Slides(
        poses=poses,
        incline_rad=row(*(s.incline_rad - session.zero.value_rad for s in slides)),
        length_m=row(*(s.distance_m for s in slides)),
        time_s=row(*(s.duration_s for s in slides)),
        sigma_rad=np.full(count, setup.uncertainty.incline_sigma_rad),
        sigma_m=np.full(count, setup.stopwatch.distance_sigma_m),
        sigma_s=row(*(s.time_sigma_s or watch_s for s in slides)),
    )
