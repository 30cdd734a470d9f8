"""Pushes as a block of a posterior.

A push along a floor obeys, while it moves, v' = -(c v + f) + a, with

    c = A / m_e,   f = B / m_e,   m_e = m (1 + rho k_t),

A = ct k_t + cn k_n, B = ft0 k_f + fn0 (k_g + s): the same projections of the bend as a station's
(`fitting.bends`), s the drag of links that stand off their path (`fitting.shared`). rho is the
wheels' J / r^2 over the mass m: wheels turn by the speed along their links alone, so that their
share of the motion's energy is that of ct. A floor falls by s_along towards "there" and by s_across
to the left of it: at an angle psi to the line of the pushes a = +- g m / m_e (s_along cos psi +
s_across sin psi), and psi follows the track. A robot without a straight link slips, too (`slip`).

A film tells a c and f of its own, and both speed and place at the start. Its places are linear in
all of these near a point; with the start eliminated two residuals remain, which say how far the
common c and f are from those of the film. Ways and times to rest have the law's closed form, and
the start is solved for at every point.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...session.session import Session
from ...session.station import slips
from ..fitting.bends import Bends, frictions_in, projections, resistance
from ..fitting.shared import FRICTIONS, rolling_share
from ..fitting.unknowns import Floats, Unknown, Values, Whole
from .crooked import Sideways
from .tracks import PushTrack, Rows, at_rest, tracks_of

WHERE = " on the floor"


@dataclass(frozen=True)
class Rolling:
    """What a robot that rolls has besides its frictions: its mass, and its wheels'.

    rolling: J / r^2 of all wheels over the mass, mean and standard deviation.
    """

    mass_kg: float
    gravity_m_s2: float
    rolling: tuple[float, float]

    @classmethod
    def of(cls, session: Session) -> Rolling:
        """Take what a session's set-up says."""
        setup = session.setup
        mass_kg = setup.robot.links * setup.robot.link_mass_kg
        rolling = rolling_share(setup.robot_table.wheels_kg, mass_kg)
        return cls(mass_kg, setup.laboratory.gravity_m_s2, rolling)

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return the wheels' share, where it has a doubt; it cannot be below 0."""
        mean, sigma = self.rolling
        return (Unknown("rolling", -mean / sigma),) if sigma > 0.0 else ()

    def motion(
        self,
        values: Values,
        bends: Bends,
        bent: tuple[Floats | float, Floats] | None = None,
    ) -> tuple[Floats, ...]:
        """Return c and f on level ground, and m / m_e, each (K, N).

        bent: share of the links that stand at angles to the way, and these; those of the bends
        unless given.
        """
        rolls, spread = self.rolling
        sigmas = values["rolling"][:, None] if "rolling" in values else 0.0
        share, angles = bent or (bends.share, bends.angles_rad(values))
        astray = bends.astray_rad(values)
        force, dry = resistance(frictions_in(values), share, angles, astray)
        by_ct = projections(share, angles)[0]
        inert = 1.0 + (rolls + spread * sigmas) * by_ct
        mass = self.mass_kg * inert
        return force / mass, dry / mass, np.ones_like(force) / inert


@dataclass(frozen=True, eq=False)
class Pushes:
    """The kept pushes of a session.

    way: +1 there, -1 back. place: which of the places. slips: it has no straight link, and nothing
    guides it (`slip`). rows: of each push by film, by its index, its residuals near a point.
    """

    rolling: Rolling
    bends: Bends
    way: Floats
    place: Whole
    places: tuple[str, ...]
    tracks: tuple[PushTrack, ...]
    slips: NDArray[np.bool_]
    slope_sigma_rad: float
    scale_sigma: float
    rows: dict[int, Rows] = field(default_factory=dict)

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return the frictions, then what the pushes share."""
        frictions = tuple(Unknown(name, friction=True) for name in FRICTIONS)
        shared = [f"{part} {place}" for place in self.places for part in ("along", "across")]
        shared += ["film scale"] if self.filmed and self.scale_sigma > 0.0 else []
        bends, rolling = self.bends, self.rolling.unknowns
        return (*frictions, *bends.unknowns, *map(Unknown, shared), *rolling, *bends.straightness)

    @property
    def filmed(self) -> bool:
        """Tell whether a length comes from a film."""
        return any(track.by == "film" for track in self.tracks)

    @property
    def numbers(self) -> Whole:
        """Return the push that each residual belongs to."""
        of_film = np.where(self.slips, 3, 2)
        counts = [of_film[k] if track.by == "film" else 1 for k, track in enumerate(self.tracks)]
        return np.repeat(np.array([t.number for t in self.tracks], dtype=np.intp), counts)

    pool = (), np.empty((0, 0))

    def _motion(
        self, values: Values, bent: tuple[float, Floats] | None = None
    ) -> tuple[Floats, ...]:
        """Return what `Rolling.motion` does, in the lengths as filmed."""
        c, f, share = self.rolling.motion(values, self.bends, bent)
        if "film scale" in values:
            filmed = np.array([track.by == "film" for track in self.tracks])
            scale = 1.0 + self.scale_sigma * values["film scale"][:, None] * filmed
            f, share = f * scale, share * scale
        return c, f, share

    def law(self, values: Values) -> tuple[Floats, Floats, Floats]:
        """Return c and f on level ground in the lengths as filmed, (K, N), and the floor's pull.

        That is (along, across), (K, N, 2), m/s^2, + where it helps a push.
        """
        c, f, share = self._motion(values)
        slopes = [
            np.stack([values[f"{part} {place}"] for place in self.places], axis=1)[:, self.place]
            for part in ("along", "across")
        ]
        pull = self.slope_sigma_rad * self.rolling.gravity_m_s2 * self.way * share
        return c, f, pull[..., None] * np.stack(slopes, axis=2)

    def level_laws(self, values: Values) -> list[tuple[PushTrack, Floats, Floats]]:
        """Return pushes but for their slip, each with its c and f (1,), as filmed.

        The floor's slopes are in f.
        """
        c, f, pull = self.law(values)
        return [
            (track, c[:, k], f[:, k] - pull[:, k] @ track.heading)
            for k, (track, _) in enumerate(self._without_slip(values))
        ]

    def _without_slip(self, values: Values) -> list[tuple[PushTrack, Sideways | None]]:
        """Return each push but for its slip at a point, as `PushTrack.without_slip` does."""
        tracks: list[tuple[PushTrack, Sideways | None]] = [(track, None) for track in self.tracks]
        if not self.slips.any():
            return tracks
        c, f, pull = (part[0] for part in self.law(values))
        numbers = self._slip_numbers(values)[0]
        for k in np.flatnonzero(self.slips):
            tracks[k] = self.tracks[k].without_slip(c[k], f[k], pull[k], numbers[k])
        return tracks

    def _slip_numbers(self, values: Values) -> Floats:
        """Return the numbers of each push's `Slip`, (K, N, 4); 0 where no push slips."""
        angles = self.bends.angles_rad(values)
        if not self.slips.any():
            return np.zeros((1, len(self.tracks), 4))
        across = self._motion(values, (1.0, np.pi / 2 - angles))[0]
        c_end, f_end, _ = self._motion(values, (0.5, 2 * angles))
        parts = np.broadcast_arrays(angles, across, c_end, f_end)
        return np.stack(parts, axis=2)

    def residuals(self, values: Values) -> Floats:
        """Return the residuals (K, rows)."""
        c, f, pull = self.law(values)
        slip = self._slip_numbers(values)
        parts = {k: rows(c[:, k], f[:, k], pull[:, k], slip[:, k]) for k, rows in self.rows.items()}
        rest = [k for k, track in enumerate(self.tracks) if track.by == "rest"]
        level = f[:, rest] - pull[:, rest, 0]
        off = at_rest([self.tracks[k] for k in rest], c[:, rest], level)[1]
        parts |= zip(rest, off.T[..., None], strict=True)
        return np.concatenate([parts[k] for k in sorted(parts)], axis=1)

    def near(self, values: Values) -> Pushes:
        """Return the block with films linear about a point."""
        c, f, pull = (part[0] for part in self.law(values))
        slip = self._slip_numbers(values)[0]
        rows = {
            k: track.near(c[k], f[k], pull[k], slip[k], sideways)
            for k, (track, sideways) in enumerate(self._without_slip(values))
            if track.by != "rest"
        }
        return replace(self, rows=rows) if rows else self

    def nuisances(self, values: Values) -> dict[str, Floats]:
        """Return what pushes share by the name that a fit gives it, in its unit."""
        out: dict[str, Floats] = {}
        for place in self.places:
            for part, name in (("along", "floor_slope_rad"), ("across", "floor_slope_across_rad")):
                out[name + ("_" + place if place else "")] = (
                    self.slope_sigma_rad * values[f"{part} {place}"]
                )
        if "film scale" in values:
            out["film_scale"] = 1.0 + self.scale_sigma * values["film scale"]
        if "rolling" in values:
            mean, sigma = self.rolling.rolling
            out["wheels_turning_over_mass"] = mean + sigma * values["rolling"]
        return out


def floor_blocks(session: Session) -> tuple[Pushes, ...]:
    """Return the block of a session's kept pushes; none where there are none."""
    pushes, setup = session.kept_pushes, session.setup
    if not pushes:
        return ()
    places = tuple(sorted({p.place for p in pushes}))
    scales = [push.scale_sigma or 0.0 for push in pushes]
    links = setup.robot.links
    block = Pushes(
        Rolling.of(session),
        Bends.of(session, pushes, WHERE),
        np.array([1.0 if p.way == "there" else -1.0 for p in pushes]),
        np.array([places.index(p.place) for p in pushes], dtype=np.intp),
        places,
        tracks_of(session),
        np.array([p.by == "film" and slips(p.bend, p.lambda_rad, links) for p in pushes]),
        setup.instruments.floor_slope_sigma_rad,
        max([setup.instruments.film_scale_sigma, *scales]),
    )
    return (block,)
