"""Residuals of pushes along a floor, in which friction brakes a rolling robot to a stop.

While it moves, a pushed robot obeys v' = -(c v + f) + a, with

    c = A / m_e,   f = B / m_e,   m_e = m (1 + rho k_t),

A = ct k_t + cn k_n, B = ft0 k_f + fn0 (k_g + s): the same projections of the bend as a station's
(`bends`), and s is the drag of links at an angle to their path. rho is the wheels' J / r^2 over the
mass m: wheels turn with the speed along their links only, so that their kinetic energy has the
factor of ct. A floor falls by s_along towards "there" and by s_across to its left. At an angle psi
to the line of the pushes, which follows the track, a = +- g m / m_e (s_along cos psi + s_across sin
psi). A robot without a straight link slips too (`slip`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..session.push import Push
from ..session.session import Session
from ..session.station import slips
from ..session.track import chord_places, curved_path
from .bends import Bends, frictions_in, projections, resistance
from .drift import wheels_share
from .parameters import FRICTION_PARAMETERS, Floats, Integers, Parameter, Rows, Values
from .push_track import LinearTrack, PushTrack

WHEELS, SCALE = "wheels_turning_over_mass", "film_scale"
SLOPES = ("floor_slope_rad", "floor_slope_across_rad")
# Largest angle of a path to the line of its floor; beyond it the camera was turned.
MAX_CROOKED_RAD = math.radians(25.0)


@dataclass(frozen=True, eq=False)
class Pushes:
    """The kept pushes of a session.

    sign: +1 there, -1 back, (N,). place: index of each push's place, (N,). wheels: their J / r^2
    over the mass, mean and sigma. slope_sigma_rad, scale_sigma: prior sigmas of a floor's slopes
    and of the scale of films. linear: the linearisation of each push about a point.
    """

    on_belt = False

    tracks: tuple[PushTrack, ...]
    bends: Bends
    sign: Floats
    place: Integers
    places: tuple[str, ...]
    mass_kg: float
    gravity_m_s2: float
    wheels: tuple[float, float]
    slope_sigma_rad: float
    scale_sigma: float
    linear: tuple[LinearTrack, ...] = ()

    @classmethod
    def from_session(cls, session: Session, slipping: bool = True) -> Pushes:
        """Return the kept pushes of a session; slipping: as for `posterior_of`."""
        pushes, setup = session.kept_pushes, session.setup
        places = sorted({push.place for push in pushes})
        links, instruments = setup.robot.links, setup.instruments
        tracks = [
            _track(
                p, instruments.push_time_sigma_s, slipping and slips(p.bend, p.lambda_rad, links)
            )
            for p in pushes
        ]
        place = np.array([places.index(push.place) for push in pushes], dtype=np.intp)
        direction_rad = np.array([float(track.heading_rad.mean()) for track in tracks])
        is_film = np.array([track.source == "film" for track in tracks])
        lines_rad = [_line_rad(direction_rad[is_film & (place == k)]) for k in range(len(places))]
        tracks = [_turned(t, lines_rad[k]) for t, k in zip(tracks, place.tolist(), strict=True)]
        return cls(
            tuple(tracks),
            Bends.from_session(session, pushes, "_on_floor"),
            np.array([1.0 if push.way == "there" else -1.0 for push in pushes]),
            place,
            tuple(places),
            links * setup.robot.link_mass_kg,
            setup.laboratory.gravity_m_s2,
            wheels_share(session),
            instruments.floor_slope_sigma_rad,
            max([instruments.film_scale_sigma, *(push.scale_sigma or 0.0 for push in pushes)]),
        )

    @property
    def slips(self) -> bool:
        """Return whether a robot without a straight link was pushed."""
        return any(track.slips for track in self.tracks)

    @property
    def fastest_m_s(self) -> float:
        """Return the largest initial speed of a push, m/s."""
        return max(track.pushed_m_s for track in self.tracks)

    @property
    def is_film(self) -> Rows:
        """Return whether each push was filmed, (N,)."""
        return np.array([track.source == "film" for track in self.tracks])

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Return the parameters: the frictions, then the errors that pushes share."""
        shared = [Parameter(n, sigma=self.slope_sigma_rad) for n in sum(self._slope_names, ())]
        if self.is_film.any() and self.scale_sigma > 0.0:
            shared.append(Parameter(SCALE, 1.0, self.scale_sigma))
        if self.wheels[1] > 0.0:
            shared.append(Parameter(WHEELS, *self.wheels, low=0.0))
        return (*FRICTION_PARAMETERS, *self.bends.parameters, *shared)

    @property
    def _slope_names(self) -> list[tuple[str, ...]]:
        """Return for each place the names of its slopes, along and across."""
        ends = ["_" + place if place else "" for place in self.places]
        return [tuple(name + end for name in SLOPES) for end in ends]

    @property
    def numbers(self) -> Integers:
        """Return the number of the push of each residual, (rows,)."""
        rows = [len(track.law_columns) for track in self.tracks]
        return np.repeat(np.array([t.number for t in self.tracks], dtype=np.intp), rows)

    def laws(self, values: Values) -> Floats:
        """Return for each push c, f, the floor's pull, and the numbers of its slip, (K, N, 8).

        Lengths are as filmed. A positive pull accelerates the robot.
        """
        angles, share = self.bends.angles_rad(values), self.bends.share
        c, f, inert = self._motion(values, share, angles)
        slopes = [np.stack([values[n] for n in names], axis=1) for names in self._slope_names]
        slope = np.stack(slopes, axis=1)[:, self.place]
        pull = (self.gravity_m_s2 * self.sign * inert)[..., None] * slope
        parts = [c, f, pull[..., 0], pull[..., 1]]
        if self.slips:
            across_c, _, _ = self._motion(values, 1.0, np.pi / 2 - angles)
            end_c, end_f, _ = self._motion(values, 0.5, 2 * angles)
            parts += [angles, across_c, end_c, end_f]
        else:
            parts += [np.zeros_like(c)] * 4
        return np.stack(np.broadcast_arrays(*parts), axis=2)

    def _motion(
        self, values: Values, share: Floats | float, angles: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return c and f on level ground, and m / m_e, each (K, N), in lengths as filmed.

        share: share of the links that are at these angles to the path.
        """
        frictions, stray_rad = frictions_in(values), self.bends.stray_angles_rad(values)
        viscous, dry = resistance(frictions, share, angles, stray_rad)
        wheels = values[WHEELS][:, None] if WHEELS in values else self.wheels[0]
        inert = 1.0 + wheels * projections(share, angles)[0]
        mass, scale = self.mass_kg * inert, np.ones(len(self.tracks))
        if SCALE in values:
            scale = np.where(self.is_film, values[SCALE][:, None], 1.0)
        return viscous / mass, dry / mass * scale, scale / inert * np.ones_like(viscous)

    def residuals(self, values: Values) -> Floats:
        """Return the linearised residuals (K, rows)."""
        which, law, offsets, slopes = self._linear_rows
        changes = self.laws(values)[:, which] - law
        return np.asarray(offsets + np.einsum("krl,rl->kr", changes, slopes))

    def sizes(self, values: Values) -> Floats:
        """Return the root mean square (N,) of each push's residuals at values (1,)."""
        which = self._linear_rows[0]
        sums = np.bincount(which, self.residuals(values)[0] ** 2)
        return np.sqrt(sums / np.bincount(which))

    @cached_property
    def _linear_rows(self) -> tuple[Integers, Floats, Floats, Floats]:
        """Return for each residual the index of its push, with law, offset and slopes."""
        which = np.repeat(np.arange(len(self.linear)), [len(t.offsets) for t in self.linear])
        offsets, slopes = (
            np.concatenate([getattr(track, name) for track in self.linear])
            for name in ("offsets", "slopes")
        )
        return which, np.stack([track.law for track in self.linear])[which], offsets, slopes

    def linear_about(self, values: Values) -> Pushes:
        """Return the pushes, linearised about parameter values (1,)."""
        nearby = self.linear or len(self.tracks) * (None,)
        parts = zip(self.tracks, self.laws(values)[0], nearby, strict=True)
        return replace(self, linear=tuple(t.linear_about(law, origin) for t, law, origin in parts))


def _track(push: Push, time_sigma_s: float, slipping: bool) -> PushTrack:
    """Return the track of a push, with directions relative to the picture."""
    if push.track is None:
        sigma_s = time_sigma_s if push.time_sigma_s is None else push.time_sigma_s
        t, x = np.array([push.duration_s]), np.array([push.distance_m])
        sigma_m = push.distance_sigma_m or 0.005
        return PushTrack(push.number, "rest", t, x, sigma_m, sigma_s, np.zeros(1), np.zeros(1))
    t, x, y = push.counted
    sigma_m, sigma_s = push.distance_sigma_m or 0.001, push.time_sigma_s or 0.0
    along_m, left_m, chord_rad = chord_places(x, y)
    path_m, direction_rad = curved_path(along_m, left_m, sigma_m)
    way_m = along_m if slipping else path_m
    places = t - t[0], way_m - way_m[0]
    headings = chord_rad + direction_rad, left_m - left_m[0], chord_rad
    return PushTrack(push.number, "film", *places, sigma_m, sigma_s, *headings, slipping)


def _line_rad(direction_rad: Floats) -> float:
    """Return the mean direction of paths at one place, there or back, rad."""
    return 0.5 * math.atan2(np.sin(2 * direction_rad).sum(), np.cos(2 * direction_rad).sum())


def _turned(track: PushTrack, line_rad: float) -> PushTrack:
    """Return a track with its directions relative to the line of its floor.

    Paths there and back along the line are both at 0.
    """
    mean = float(track.heading_rad.mean())
    off_line = (mean - line_rad + math.pi / 2) % math.pi - math.pi / 2
    if abs(off_line) >= MAX_CROOKED_RAD:
        return replace(track, heading_rad=np.zeros_like(track.heading_rad), chord_rad=0.0)
    turn = off_line - mean
    return replace(track, heading_rad=track.heading_rad + turn, chord_rad=track.chord_rad + turn)
