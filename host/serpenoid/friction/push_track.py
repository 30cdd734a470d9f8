"""One push over time: where the law puts it, and what its places tell of that law.

A film tells a speed and a place at the start of its own; one of a robot without a straight link
also how a hand let it go: some degrees crooked, and turning. Its places are linear in all of these
near a point. With its own numbers eliminated two residuals remain, which say how far the common c
and f are from those of the film; and a third where the robot slips, of the floor's pull across.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .arc import along
from .parameters import Floats
from .rolling_law import rest, way_m
from .slip import Slip, Start

# Standard deviations of how hands let go: of the axis to the push, and of its turning. With less,
# sound sessions are called contradictory. A path too short to tell counts as a straight start.
CROOKED_RAD, TURNING_RAD_S = math.radians(2.0), math.radians(4.0)
MIN_SPEED_M_S = 1e-3
MIN_DRY_M_S2 = 1e-6  # of a push that would not come to rest: it then takes long, not for ever
ROUNDS = 4  # of Gauss-Newton for a push's own numbers: its last step is below 1e-3 sigma
# Steps of differences: of c, f, the floor's two pulls and the slip's four numbers; then of the
# push's own: speed and place; place across, direction and the start's two.
LAW_STEPS = np.array([1e-3] * 8)
OWN_STEPS = np.array([1e-3, 1e-3, 1e-3, 1e-3, 0.03, 0.03])


@dataclass(frozen=True, eq=False)
class PushTrack:
    """One push: the way along_m at times t_s, both from its first place.

    Of a push that is known by its rest alone that one way and time. sigma_m, sigma_s: of a place
    and a time. heading_rad: of the path to the line of its floor, at each time. by: as Push's.
    slips: it has no straight link, and nothing guides it; across_m: its places to the left of its
    chord, whose angle to the floor's line is chord_rad.
    """

    number: int
    t_s: Floats
    along_m: Floats
    sigma_m: float
    sigma_s: float
    heading_rad: Floats
    by: str
    slips: bool = False
    across_m: Floats = field(default_factory=lambda: np.zeros(1))
    chord_rad: float = 0.0

    @property
    def pushed_m_s(self) -> float:
        """Return the speed at the start, m/s, roughly."""
        if self.by == "rest":
            return 2.0 * float(self.along_m[0] / self.t_s[0])
        far = 0.98 * float(self.along_m[-1])
        moving = max(int(np.searchsorted(self.along_m, far)) + 1, 3)
        return max(float(np.polyfit(self.t_s[:moving], self.along_m[:moving], 2)[1]), 0.05)

    def residuals(self, numbers: Floats) -> Floats:
        """Return how far the law is from a film's places, in sigmas, (K, rows).

        numbers (K, own + 8): a push's own, then its law. Own are speed and place at the start, and
        of one that slips place across, the axis's angle to the chord, and across and turning in
        standard deviations of how hands let go. The law is c, f on level ground, the floor's pull
        along its line and to the left, and the numbers of `Slip`.
        """
        if self.slips:
            return np.stack([self._slipped(row[:6], row[6:]) for row in numbers])
        speed, place, c, f = numbers.T[:4, :, None]
        pull = numbers[:, 4:6]
        headings = np.stack([np.cos(self.heading_rad), np.sin(self.heading_rad)])
        mean = headings.mean(axis=1, keepdims=True)
        level = f - pull @ mean
        way = place + way_m(self.t_s, speed, c, level)[0]
        # what a turning path feels of the slope but for that of its mean heading
        moving = np.minimum(self.t_s, rest(speed, c, level)[0])
        grown = np.exp(c * moving)
        faster = integral(grown * (pull @ (headings - mean)), moving) / grown
        return np.asarray((way + integral(faster, moving) - self.along_m) / self.place_sigma_m)

    def _slipped(self, own: Floats, law: Floats) -> Floats:
        speed, axis_rad = own[:1], self.chord_rad + float(own[3])
        start = Start(float(own[4] * CROOKED_RAD * speed[0]), float(own[5] * TURNING_RAD_S))
        slip, pull = Slip(*law[4:].tolist()), law[2:4]
        level = law[1:2] - pull @ [math.cos(axis_rad), math.sin(axis_rad)]
        x, y, _ = slip.places(self.t_s, (speed, law[:1], level), pull, start, axis_rad)
        way = along(x, y, self.sigma_m)
        off_along = own[1] + way - way[0] - self.along_m
        off_across = own[2] + own[3] * x + y - self.across_m
        return np.concatenate(
            [off_along / self.place_sigma_m, off_across / self.place_sigma_m, own[4:]]
        )

    @cached_property
    def place_sigma_m(self) -> Floats:
        """Return the standard deviation of each place, the error of its time in it."""
        moving_m_s = np.maximum(np.gradient(self.along_m, self.t_s), 0.0)
        return np.hypot(self.sigma_m, moving_m_s * self.sigma_s)

    def linear_about(self, law: Floats, near: LinearTrack | None = None) -> LinearTrack:
        """Return what a film tells of the law near one (8,); near: what it told at another one."""
        count = 6 if self.slips else 2
        own = near.own if near else np.append(self.pushed_m_s, np.zeros(count - 1))
        own, slopes = self._stepped(own, law)
        for _ in range(0 if near else ROUNDS - 1):
            own, slopes = self._stepped(own, law)
        own_basis = np.linalg.qr(slopes[:, :count])[0]
        by_law = slopes[:, count:] - own_basis @ (own_basis.T @ slopes[:, count:])
        told = [0, 1, 3] if self.slips else [0, 1]
        basis = np.linalg.qr(by_law[:, told])[0]
        off = self.residuals(np.concatenate([own, law])[None])[0]
        off = off - own_basis @ (own_basis.T @ off)
        return LinearTrack(law, own, basis.T @ off, basis.T @ by_law)

    def _stepped(self, own: Floats, law: Floats) -> tuple[Floats, Floats]:
        """Return own numbers after a step of Gauss-Newton, and the slopes before it, by all."""
        steps = np.append(OWN_STEPS[: len(own)], LAW_STEPS)
        changes = np.vstack([np.zeros_like(steps), np.diag(steps)])
        rows = self.residuals(np.concatenate([own, law]) + changes)
        slopes = (rows[1:] - rows[0]).T / steps
        own = own - np.linalg.lstsq(slopes[:, : len(own)], rows[0], rcond=None)[0]
        own[0] = max(own[0], 0.3 * self.pushed_m_s, MIN_SPEED_M_S)
        return own, slopes

    def rest_residuals(self, c: Floats, f: Floats) -> Floats:
        """Return what remains of a push by its rest, in sigmas, (K, 1), at c and f (K,).

        One of time and way is free, for the speed fits it: the part across what the speed may do
        remains.
        """
        off, slope = self._rest(self.rest_speed(c, f), c, f)
        size = np.maximum(np.linalg.norm(slope, axis=0), 1e-12)
        return np.asarray((off[1] * slope[0] - off[0] * slope[1]) / size)[:, None]

    def rest_speed(self, c: Floats, f: Floats) -> Floats:
        """Return the likeliest speed at the start (K,) of a push by its rest."""
        speed = np.full_like(c, self.pushed_m_s)
        for _ in range(ROUNDS):
            off, slope = self._rest(speed, c, f)
            step = np.sum(slope * off, axis=0) / np.maximum(np.sum(slope**2, axis=0), 1e-12)
            speed = np.maximum(speed - step, np.maximum(0.3 * speed, MIN_SPEED_M_S))
        return speed

    def _rest(self, speed: Floats, c: Floats, f: Floats) -> tuple[Floats, Floats]:
        """Return way and time to rest less those measured, in sigmas, and slopes by the speed."""
        sigmas, f = np.array([[self.sigma_m], [self.sigma_s]]), np.maximum(f, MIN_DRY_M_S2)
        time, way = rest(speed, c, f)
        off = np.stack([way - self.along_m[0], time - self.t_s[0]])
        slopes = np.stack([speed, np.ones_like(speed)]) / (c * speed + f)
        return off / sigmas, slopes / sigmas


@dataclass(frozen=True, eq=False)
class LinearTrack:
    """Residuals of a film near a law (8,): off (rows,) at it, and their slopes (rows, 8).

    own: the push's own numbers there.
    """

    law: Floats
    own: Floats
    off: Floats
    slopes: Floats

    def residuals(self, law: Floats) -> Floats:
        """Return the residuals (K, rows) at laws (K, 8)."""
        return np.asarray(self.off + (law - self.law) @ self.slopes.T)


def integral(rate: Floats, t_s: Floats) -> Floats:
    """Return the integrals (K, T) of rates since the first time, by the trapezoidal rule."""
    steps = 0.5 * np.diff(t_s) * (rate[:, 1:] + rate[:, :-1])
    return np.concatenate([np.zeros((len(rate), 1)), np.cumsum(steps, axis=1)], axis=1)
