"""Pushes as samples of a way over time, and the direction that each took along its floor."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...session.push import Push
from ...session.session import Session
from ..fitting.rolling_law import rest, way_m
from ..fitting.unknowns import Floats
from .arc import across, along, directions_rad
from .crooked import CrookedPush, PushRows, Sideways

# Residuals (K, rows) by c, f (K,), the floor's pull (K, 2) and the slip's numbers (K, 4).
Rows = Callable[[Floats, Floats, Floats, Floats], Floats]
TAPE_M = 0.005  # of a way measured from where a hand let go
_FILM_M = 0.001  # of a place, where nothing states it
# A path further off the line of its floor was filmed by a camera that somebody turned.
_CROOKED = math.radians(25.0)
_NEWTON = 3
_LEAST_SPEED_M_S = 1e-3
_LEAST_DRY = 1e-6  # m/s^2, of a push that would not come to rest: it then takes long, not for ever


@dataclass(frozen=True, eq=False)
class PushTrack:
    """One push: the way x_m at times t_s, both from its first place.

    Of a push that is known by its rest alone that one way and time. sigma_m, sigma_s: of a place
    and a time. off_rad: angle of the path to the line of its floor, at each time. by: as Push's.
    across_m: of a film, places to the left of a straight line.
    """

    number: int
    t_s: Floats
    x_m: Floats
    sigma_m: float
    sigma_s: float
    off_rad: Floats
    by: str
    across_m: Floats = field(default_factory=lambda: np.zeros(1))

    def profiled(self, c: Floats, f: Floats) -> tuple[Floats, ...]:
        """Return speed and place at the start (K,) and what remains, in sigmas, (K, rows).

        The place follows from the speed.
        """
        c, f = c[:, None], f[:, None]
        if self.by == "rest":
            speed, off = at_rest([self], c, f)
            return speed[:, 0], np.zeros(len(c)), off
        start = np.full_like(c, self.pushed_m_s)
        speed, off, _ = _likeliest(start, lambda speed: self._off(speed, c, f))
        way = way_m(self.t_s, speed, c, f)[0]
        return speed[:, 0], np.mean(self.x_m - way, axis=1), off

    @property
    def heading(self) -> Floats:
        """Return the mean cosine and sine of the path's angle to the line of its floor."""
        return np.array([np.cos(self.off_rad).mean(), np.sin(self.off_rad).mean()])

    def without_slip(
        self, c: float, f: float, pull: Floats, slip: Floats
    ) -> tuple[PushTrack, Sideways]:
        """Return the push as it was but for its slip, and what that does; arguments as of `near`.

        The angle to the line of the floor is then that of its axis.
        """
        made = replace(self, off_rad=np.full_like(self.off_rad, self.off_rad[0]))
        # The axis's direction follows from the slip, and that from the floor's pull along the axis.
        made, _ = self._slipped(made, c, f, pull, slip)
        return self._slipped(made, c, f, pull, slip)

    def _slipped(
        self, made: PushTrack, c: float, f: float, pull: Floats, slip: Floats
    ) -> tuple[PushTrack, Sideways]:
        """Return what `without_slip` does, from a first answer to it."""
        level = f - float(pull @ made.heading)
        speed = float(made.profiled(np.array([c]), np.array([level]))[0][0])
        law, axis_rad = (speed, c, level), float(made.off_rad[0])
        known = self.t_s, self.across_m, self.sigma_m
        sideways = CrookedPush(slip, law, pull, axis_rad, *known).near()
        x_m, off_rad = self.x_m - sideways.further_m, self.off_rad - sideways.axis_rad
        return replace(self, x_m=x_m, off_rad=off_rad), sideways

    def near(
        self, c: float, f: float, pull: Floats, slip: Floats, sideways: Sideways | None = None
    ) -> Rows:
        """Return the residuals near a point: c, f, the floor's pull (2,), the slip's numbers (4,).

        Those of a film are two, linear about the point; of one that slips a third, by the floor's
        pull across. sideways: the second value of `without_slip`.
        """
        level = f - float(pull @ self.heading)
        law = np.array([c]), np.array([level])
        speed, place, _ = self.profiled(*law)
        way, slopes, moving = way_m(self.t_s, speed, *law)
        spread = np.hypot(1.0, moving * self.sigma_s / self.sigma_m)
        sigma = self.sigma_m * spread[:, None]
        by_pull = self._carried(speed, *law)
        # how far a turning path is from one at its mean angle, by the slopes as they are
        off = place + way - self.x_m + by_pull @ pull - slopes[2] * (level - f)
        own = np.stack([slopes[0], np.ones_like(way)], axis=1) / sigma
        rows = PushRows(off / sigma[:, 0], own, slopes[1:].T / sigma, by_pull / sigma)
        shared = rows.by_law
        if sideways is not None:
            rows = rows.with_sideways(sideways, sigma[:, 0], self.heading)
            shared = np.column_stack([rows.by_law, rows.by_pull[:, 1]])
        own = np.linalg.qr(rows.own)[0]
        basis, root = np.linalg.qr(shared - own @ (own.T @ shared))
        root, by_pull = root[:, :2], basis.T @ rows.by_pull
        at = basis.T @ rows.off - by_pull @ pull - root @ [c, f]
        if sideways is None:
            return lambda c, f, pull, _: at + np.stack([c, f], 1) @ root.T + pull @ by_pull.T
        by_slip = basis.T @ rows.by_slip
        by_all, at = np.hstack([root, by_pull, by_slip]), at - by_slip @ slip
        return lambda c, f, pull, slip: at + np.column_stack([c, f, pull, slip]) @ by_all.T

    def _carried(self, speed: Floats, c: Floats, f: Floats) -> Floats:
        """Return how far (T, 2) accelerations of 1 along cos, and sin, of the path carry it.

        speed, c, f: (1,).
        """
        from scipy.integrate import cumulative_trapezoid

        t = np.minimum(self.t_s, rest(speed, c, f)[0])[:, None]
        pull = np.stack([np.cos(self.off_rad), np.sin(self.off_rad)], axis=1)
        speeds = np.exp(-c * t) * cumulative_trapezoid(np.exp(c * t) * pull, t, axis=0, initial=0)
        return np.asarray(cumulative_trapezoid(speeds, t, axis=0, initial=0))

    def _off(self, speed: Floats, c: Floats, f: Floats) -> tuple[Floats, Floats]:
        """Return predicted less measured, in sigmas, and its slope by the speed, (K, rows)."""
        way, slopes, _ = way_m(self.t_s, speed, c, f)
        weight = np.full_like(self.t_s, self.sigma_m) ** -2.0

        def centred(rows: Floats) -> Floats:  # the place at the start follows
            return (rows - np.average(rows, 1, weight, keepdims=True)) / self.sigma_m

        return centred(way - self.x_m), centred(slopes[0])

    @property
    def pushed_m_s(self) -> float:
        """Return the speed at the start, m/s, roughly."""
        if self.by == "rest":
            return 2.0 * float(self.x_m[0] / self.t_s[0])
        far = 0.98 * float(self.x_m[-1])
        moving = max(int(np.searchsorted(self.x_m, far)) + 1, 3)
        return max(float(np.polyfit(self.t_s[:moving], self.x_m[:moving], 2)[1]), 0.05)


def at_rest(tracks: Sequence[PushTrack], c: Floats, f: Floats) -> tuple[Floats, Floats]:
    """Return speeds at the start and what remains, in sigmas, (K, N), of pushes by their rest.

    c, f: (K, N), for all pushes at once. One of time and way is free, for the speed fits it: the
    part across what the speed may do remains.
    """
    rows = [(t.t_s[0], t.x_m[0], t.sigma_s, t.sigma_m) for t in tracks]
    t_s, x_m, sigma_s, sigma_m = np.array(rows).reshape(-1, 4).T[..., None]
    c, f = c[..., None], np.maximum(f, _LEAST_DRY)[..., None]

    def off_of(speed: Floats) -> tuple[Floats, Floats]:
        time, way = rest(speed, c, f)
        off = (way - x_m) / sigma_m, (time - t_s) / sigma_s
        braking = c * speed + f
        slopes = speed / braking / sigma_m, 1.0 / braking / sigma_s
        return np.concatenate(off, axis=-1), np.concatenate(slopes, axis=-1)

    speed, off, slopes = _likeliest(np.broadcast_to(2 * x_m / t_s, c.shape), off_of)
    size = np.maximum(np.linalg.norm(slopes, axis=-1), 1e-12)
    across = off[..., 1] * slopes[..., 0] - off[..., 0] * slopes[..., 1]
    return speed[..., 0], across / size


def _likeliest(
    speed: Floats, off_of: Callable[[Floats], tuple[Floats, Floats]]
) -> tuple[Floats, Floats, Floats]:
    """Return speeds (..., 1) by Newton's steps; residuals (..., rows) and their slopes there."""
    for _ in range(_NEWTON):
        off, by_speed = off_of(speed)
        size = np.sum(by_speed**2, axis=-1, keepdims=True)
        step = np.sum(by_speed * off, axis=-1, keepdims=True) / np.maximum(size, 1e-12)
        speed = np.maximum(speed - step, np.maximum(0.3 * speed, _LEAST_SPEED_M_S))
    return (speed, *off_of(speed))


def tracks_of(session: Session) -> tuple[PushTrack, ...]:
    """Return a session's kept pushes."""
    pushes = session.kept_pushes
    places = sorted({p.place for p in pushes})
    off = {number: o for place in places for number, o in _off_line(pushes, place).items()}
    return tuple(
        _track(p, session.setup.instruments.push_time_sigma_s, off.get(p.number)) for p in pushes
    )


def _track(push: Push, time_sigma_s: float, off_rad: Floats | None) -> PushTrack:
    if push.track is None:
        sigma_s = time_sigma_s if push.time_sigma_s is None else push.time_sigma_s
        assert push.duration_s is not None  # Push has checked
        assert push.distance_m is not None
        one = np.ones(1)
        t, x = push.duration_s * one, push.distance_m * one
        return PushTrack(
            push.number, t, x, push.distance_sigma_m or TAPE_M, sigma_s, 0.0 * one, "rest"
        )
    t, x, y = (np.array(column) for column in push.counted)
    sigma_m = push.distance_sigma_m or _FILM_M
    way = along(x, y, sigma_m)
    off = np.zeros_like(t) if off_rad is None else off_rad
    own = push.number, t - t[0], way - way[0], sigma_m, push.time_sigma_s or 0.0
    return PushTrack(*own, off, push.by, across(x, y))


def _off_line(pushes: tuple[Push, ...], place: str) -> dict[int, Floats]:
    """Return by number the angle of each filmed path to the line that all at one place follow.

    The line has no sense: a path there and one back along it are both at 0.
    """
    filmed = [p for p in pushes if p.place == place and p.by == "film"]
    angles = {}
    for push in filmed:
        _, x, y = (np.array(column) for column in push.counted)
        angles[push.number] = directions_rad(x, y, push.distance_sigma_m or _FILM_M)
    if not angles:
        return {}
    doubled = np.array([2.0 * a.mean() for a in angles.values()])
    line = 0.5 * math.atan2(np.sin(doubled).sum(), np.cos(doubled).sum())
    out = {}
    for number, angle in angles.items():
        mean = float(angle.mean())
        off = (mean - line + math.pi / 2) % math.pi - math.pi / 2
        if abs(off) < _CROOKED:
            out[number] = angle - mean + off
    return out
