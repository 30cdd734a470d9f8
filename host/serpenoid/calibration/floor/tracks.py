"""Pushes as samples of a way over time, and the direction that each took along its floor."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fitting.rolling_law import rest, way_m
from ..fitting.unknowns import Floats
from ..kinds.coast import Coast
from ..session import Session
from .arc import along, directions_rad
from .slip import Slip

Rows = Callable[[Floats, Floats, Floats], Floats]
TAPE_M = 0.005  # of a way measured from where a hand let go
_FILM_M = 0.001  # of a place, where nothing states it
# A path further off the line of its floor was filmed by a camera that somebody turned.
_CROOKED = math.radians(25.0)
_NEWTON = 3
_LEAST_PULL = 0.01  # across, m/s^2: below it slip grows with the pull's square as it does there
_LEAST_SPEED_M_S = 1e-3
_LEAST_DRY = 1e-6  # m/s^2, of a push that would not come to rest: it then takes long, not for ever


@dataclass(frozen=True, eq=False)
class PushTrack:
    """One push: the way x_m at times t_s, both from its first place.

    Of a push that is known by its rest alone that one way and time. sigma_m, sigma_s: of a place
    and a time. off_rad: angle of the path to the line of its floor, at each time. by: as Coast's.
    """

    number: int
    t_s: Floats
    x_m: Floats
    sigma_m: float
    sigma_s: float
    off_rad: Floats
    by: str

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
        self, c: float, f: float, pull: Floats, slip: Slip
    ) -> tuple[PushTrack, Floats]:
        """Return the push as it was but for its slip, and how far that goes with the pull across.

        c, f, pull: of the push, as for `near`. Near that pull slip carries the push further by the
        second value, (T,), times the square of the pull across.
        """
        level = np.array([f - float(pull @ self.heading)])
        law = self.profiled(np.array([c]), level)[0], np.array([c]), level

        def slipped(across: float) -> Floats:
            """Return the way of a push with such a pull across."""
            return along(*slip.places(self.t_s, law, across), self.sigma_m)

        places = slip.places(self.t_s, law, pull[1])
        further = along(*places, self.sigma_m) - way_m(self.t_s, *law)[0]
        turned_rad = directions_rad(*places, self.sigma_m)
        made = replace(self, x_m=self.x_m - further, off_rad=self.off_rad - turned_rad)
        low, high = (by * max(abs(pull[1]), _LEAST_PULL) for by in (0.95, 1.05))
        return made, (slipped(high) - slipped(low)) / (high**2 - low**2)

    def near(self, c: float, f: float, pull: Floats, by_slip: Floats | float = 0.0) -> Rows:
        """Return the residuals (K, 2) of a film by c, f (K,) and the floor's pull (K, 2).

        They are linear about a point but for slip. by_slip: the second value of `without_slip`.
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
        started = np.linalg.qr(np.stack([slopes[0], np.ones_like(way)], axis=1) / sigma)[0]
        by_law = slopes[1:].T / sigma
        basis, root = np.linalg.qr(by_law - started @ (started.T @ by_law))
        by_pull = basis.T @ (by_pull / sigma)
        at = basis.T @ (off / sigma[:, 0]) - by_pull @ pull - root @ [c, f]
        slipped, square = basis.T @ (by_slip / sigma[:, 0]), pull[1] ** 2

        def rows(c: Floats, f: Floats, pull: Floats) -> Floats:
            linear = at + np.stack([c, f], axis=1) @ root.T + pull @ by_pull.T
            return linear + (pull[:, 1:] ** 2 - square) * slipped

        return rows

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
        _track(p, session.setup.floor.push_time_sigma_s, off.get(p.number)) for p in pushes
    )


def _track(push: Coast, time_sigma_s: float, off_rad: Floats | None) -> PushTrack:
    if push.track is None:
        sigma_s = time_sigma_s if push.time_sigma_s is None else push.time_sigma_s
        assert push.duration_s is not None  # Coast has checked
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
    sigma_s = push.time_sigma_s or 0.0
    return PushTrack(push.number, t - t[0], way - way[0], sigma_m, sigma_s, off, push.by)


def _off_line(pushes: tuple[Coast, ...], place: str) -> dict[int, Floats]:
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
