"""The joint fit's residuals: pushes, slides and stations by one likelihood, with all they share.

A push that went one way along a floor with slope a (it falls towards "there") obeys, while it
moves, v' = -(c v + f) with

    c = A / m_e,   f = (B -+ m g sin a) / m_e,   m_e = m (1 + rho k_t),

A = ct k_t + cn k_n, B = ft0 k_f + fn0 (k_g + s): the same projections of the bend as a station's
(`fitting.data`), s the drag of links that stand off their path (`fitting.shared`). rho is the
wheels' J / r^2 over the mass m: wheels turn by the speed along their links alone, so that their
share of the motion's energy is that of ct. Places are compared with x0 + x(t), the law's closed
form (`law`), scaled as a film may be; a way and a time to rest with x(t_s) and t_s; a slide's time
with the law's from rest, with sin of the board in place of the floor's.

Unknown are the frictions; in sigmas of their priors rho, the films' scale, s, the inclinometer's
zero, each place's slope, each bend's offset; v0 and x0 of every push; and a station's own nuisances
(`fitting.joint`), the belt's scale with them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ..fitting import joint as station_law
from ..fitting.data import FitData, Floats
from ..fitting.rolling_law import slide_s, stop_s, way_m
from .data import FloorData, Poses

_STEP = 1e-20  # of the complex step, which cancels nothing
_LEAST_PULL = 1e-3  # m/s^2, of a slide that would not begin: its time is then long, not infinite
ROLLING, SCALE, ASTRAY, ZERO = range(4)
_SHARED = 4


@dataclass(frozen=True)
class Layout:
    """Where which unknown is: frictions first, then what pushes share, then what is theirs."""

    parameters: int
    places: int
    postures: int
    pushes: int
    station: int

    @property
    def shared(self) -> int:
        """Return the index of the first shared unknown (ROLLING, SCALE, ASTRAY, ZERO)."""
        return self.parameters

    @property
    def slopes(self) -> slice:
        """Return where the places' slopes are."""
        first = self.shared + _SHARED
        return slice(first, first + self.places)

    @property
    def offsets(self) -> slice:
        """Return where the bends' offsets are."""
        return slice(self.slopes.stop, self.slopes.stop + self.postures)

    @property
    def common(self) -> int:
        """Return how many unknowns all pushes share, frictions among them."""
        return self.offsets.stop

    @property
    def speeds(self) -> slice:
        """Return where the pushes' speeds at the start are."""
        return slice(self.common, self.common + self.pushes)

    @property
    def starts(self) -> slice:
        """Return where the pushes' places at the start are."""
        return slice(self.speeds.stop, self.speeds.stop + self.pushes)

    @property
    def of_stations(self) -> slice:
        """Return where the stations' own nuisances are, the belt's scale last."""
        return slice(self.starts.stop, self.starts.stop + self.station)

    @property
    def count(self) -> int:
        """Return how many unknowns there are."""
        return self.of_stations.stop


@dataclass(frozen=True, eq=False)
class Problem:
    """The residuals and their Jacobian.

    spreads: standard deviations of all rows that are readings: they depend on the speeds a little,
    and are frozen while a minimum is sought (`spread_at`).
    """

    floor: FloorData
    stations: FitData | None
    spreads: Floats

    @property
    def parameters(self) -> int:
        """Return how many frictions there are."""
        if self.stations is None:
            return 6 if self.floor.ratchet else 4
        return self.stations.parameters

    @cached_property
    def layout(self) -> Layout:
        """Return where which unknown is."""
        own = 0 if self.stations is None else self.stations.nuisances + 1
        return Layout(
            self.parameters,
            len(self.floor.places),
            len(self.floor.posture_sigma_rad),
            self.floor.pushes,
            own,
        )

    @cached_property
    def lowest(self) -> Floats:
        """Return the unknowns' lower bounds: what cannot be below 0."""
        low = np.full(self.layout.count, -np.inf)
        low[: self.parameters], low[self.layout.speeds] = 0.0, 1e-3
        for k, (mean, sigma) in (
            (ROLLING, self.floor.rolling),
            (ASTRAY, self.floor.straightness_rad),
        ):
            if sigma > 0.0:
                low[self.layout.shared + k] = -mean / sigma
        return low

    @cached_property
    def rows(self) -> tuple[slice, slice, slice, slice]:
        """Return the rows of places, ways to rest, times to rest, and slides."""
        counts = (
            len(self.floor.tracks.push),
            len(self.floor.rests.push),
            len(self.floor.rests.push),
            len(self.floor.slides.time_s),
        )
        ends = np.cumsum((0, *counts)).tolist()
        a, b, c, d = (slice(*pair) for pair in pairwise(ends))
        return a, b, c, d

    def motion(self, x: Any) -> tuple[Any, Any, Any, Any]:
        """Return c and f of every push, and of every slide."""
        at, floor = self.layout, self.floor
        own = x[at.shared : at.shared + _SHARED]
        share = np.sin(floor.slope_sigma_rad * x[at.slopes])[floor.place]
        push = self.resisting(x, floor.poses)
        pull = floor.mass_kg * floor.gravity_m_s2
        incline = floor.slides.incline_rad - floor.zero_sigma_rad * own[ZERO]
        slide = self.resisting(x, floor.slides.poses)
        return (
            push[0] / push[2],
            (push[1] - floor.way * pull * share) / push[2],
            slide[0] / slide[2],
            (slide[1] - pull * np.sin(incline)) / slide[2],
        )

    def resisting(self, x: Any, poses: Poses) -> tuple[Any, Any, Any]:
        """Return A, B and m_e in some poses."""
        at, floor = self.layout, self.floor
        offsets = np.append(floor.posture_sigma_rad * x[at.offsets], 0.0)[poses.posture]
        angle, q = poses.lambda_rad + offsets, poses.bent_share
        q_sin2 = q * np.sin(angle) ** 2
        by_ft0, by_fn0 = 1.0 - q + q * np.cos(angle), q * np.sin(angle)
        (mean, sigma), (rolls, spread) = floor.straightness_rad, floor.rolling
        astray = (1.0 - q) * (mean + sigma * x[at.shared + ASTRAY])
        ct, ft0 = x[0], x[2]
        if self.parameters == 6:
            ct, ft0 = np.where(poses.back, x[4], ct), np.where(poses.back, x[5], ft0)
        slope = ct * (1.0 - q_sin2) + x[1] * q_sin2
        dry = ft0 * by_ft0 + x[3] * (by_fn0 + astray)
        mass = floor.mass_kg * (1.0 + (rolls + spread * x[at.shared + ROLLING]) * (1.0 - q_sin2))
        return slope, dry, mass

    def _motion_slopes(self, x: Floats) -> tuple[Floats, ...]:
        """Return the derivatives of motion's four by the common unknowns, (common, K) each."""
        out = []
        for k in range(self.layout.common):
            off = x.astype(complex)
            off[k] += 1j * _STEP
            out.append([np.imag(part) / _STEP for part in self.motion(off)])
        return tuple(np.array(part) for part in zip(*out, strict=True))

    def predicted(self, x: Floats) -> tuple[Floats, Floats]:
        """Return what all rows of readings are predicted to be, and their Jacobian."""
        at, floor = self.layout, self.floor
        c, f, c_slide, f_slide = self.motion(x)
        by_c, by_f, by_c_slide, by_f_slide = self._motion_slopes(x)
        ways, resting, stopping, sliding = self.rows
        out, rate = np.zeros(sliding.stop), np.zeros((sliding.stop, at.count))
        v0, x0 = x[at.speeds], x[at.starts]
        scale = np.where(floor.filmed, 1.0 + floor.scale_sigma * x[at.shared + SCALE], 1.0)

        def fill(rows: slice, push: Any, value: Floats, slopes: Floats) -> None:
            out[rows] = value
            rate[rows, : at.common] = (slopes[1] * by_c[:, push] + slopes[2] * by_f[:, push]).T
            rate[np.arange(rows.start, rows.stop), at.common + push] = slopes[0]

        push = floor.tracks.push
        way, slopes, _ = way_m(floor.tracks.t_s, v0[push], c[push], f[push])
        k = scale[push]
        fill(ways, push, k * (x0[push] + way), k * slopes)
        rate[ways, at.shared + SCALE] += np.where(
            floor.filmed[push], floor.scale_sigma * (x0[push] + way), 0.0
        )
        rate[np.arange(ways.start, ways.stop), at.starts.start + push] = k
        push = floor.rests.push
        stop, by_stop = stop_s(v0[push], c[push], f[push])
        stop = np.minimum(stop, 100.0 * floor.rests.t_s)
        fill(resting, push, *way_m(stop, v0[push], c[push], f[push])[:2])
        fill(stopping, push, stop, by_stop)
        if sliding.stop > sliding.start:
            time, by_time, _ = self._slide(c_slide, f_slide)
            out[sliding] = time
            rate[sliding, : at.common] = (by_time[0] * by_c_slide + by_time[1] * by_f_slide).T
        return out, rate

    def _slide(self, c: Floats, f: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the slides' times, their derivatives by c and f, and the speed at the end."""
        pull = np.maximum(-f, _LEAST_PULL)
        time = slide_s(self.floor.slides.length_m, c, pull)
        _, slopes, speed = way_m(time, np.zeros_like(time), c, -pull)
        return time, -slopes[1:] / speed, speed

    def spread_at(self, x: Floats) -> Floats:
        """Return the standard deviations of all rows of readings, at these unknowns."""
        floor = self.floor
        c, f, c_slide, f_slide = self.motion(x)
        ways, resting, stopping, sliding = self.rows
        out = np.ones(sliding.stop)
        push = floor.tracks.push
        v0 = x[self.layout.speeds]
        speed = way_m(floor.tracks.t_s, v0[push], c[push], f[push])[2]
        out[ways] = np.hypot(floor.tracks.sigma_m, speed * floor.tracks.sigma_s)
        out[resting], out[stopping] = floor.rests.sigma_m, floor.rests.sigma_s
        if sliding.stop > sliding.start:
            slides = floor.slides
            _, by_time, speed = self._slide(c_slide, f_slide)
            by_incline = by_time[1] * floor.gravity_m_s2 * np.cos(slides.incline_rad)
            out[sliding] = np.sqrt(
                slides.sigma_s**2
                + (by_incline * slides.sigma_rad) ** 2
                + (slides.sigma_m / speed) ** 2
            )
        return out

    def with_spreads(self, x: Floats) -> Problem:
        """Return the problem with its spreads as they are at these unknowns."""
        return replace(self, spreads=self.spread_at(x))

    @cached_property
    def measured(self) -> Floats:
        """Return what all rows of readings are compared with."""
        floor = self.floor
        rests = floor.rests
        return np.concatenate([floor.tracks.x_m, rests.x_m, rests.t_s, floor.slides.time_s])

    def residuals(self, x: Floats) -> Floats:
        """Return the residuals of readings, then priors, then of the stations."""
        own = (self.predicted(x)[0] - self.measured) / self.spreads
        parts = [own, self._priors(x)]
        if self.stations is not None:
            stations, of_stations = self._belt(x)
            parts += [station_law.residuals(of_stations, stations), x[-1:]]
        return np.concatenate(parts)

    def jacobian(self, x: Floats) -> Floats:
        """Return d residuals / d x."""
        blocks = [self.predicted(x)[1] / self.spreads[:, None], self._prior_rows()]
        if self.stations is not None:
            blocks.append(self._station_rows(x))
        return np.concatenate(blocks)

    def _priors(self, x: Floats) -> Floats:
        at = self.layout
        return np.concatenate(
            [
                x[at.shared : at.slopes.stop],
                self.floor.posture_whitening @ x[at.offsets],
                x[at.starts][self.floor.rests.push],  # no place tells these: they stay 0
            ]
        )

    def _prior_rows(self) -> Floats:
        at = self.layout
        idle = self.floor.rests.push
        rows = np.zeros((at.common - at.parameters + len(idle), at.count))
        first, last = at.offsets.start - at.shared, at.common - at.parameters
        rows[:first, at.shared : at.slopes.stop] = np.eye(first)
        rows[first:last, at.offsets] = self.floor.posture_whitening
        rows[last + np.arange(len(idle)), at.starts.start + idle] = 1.0
        return rows

    def _belt(self, x: Floats) -> tuple[FitData, Floats]:
        """Return the stations with the belt's scale put in, and their own unknowns."""
        assert self.stations is not None
        factor = 1.0 + self.stations.belt_sigma * x[-1]
        inner = np.concatenate([x[: self.parameters], x[self.layout.of_stations][:-1]])
        return replace(self.stations, slip_m_s=factor * self.stations.slip_m_s), inner

    def _station_rows(self, x: Floats) -> Floats:
        stations, inner = self._belt(x)
        found = station_law.jacobian(inner, stations)
        rows = np.zeros((len(found) + 1, self.layout.count))
        rows[:-1, : self.parameters] = found[:, : self.parameters]
        own = self.layout.of_stations
        rows[:-1, own.start : own.stop - 1] = found[:, self.parameters :]
        ends = []
        for step in (1e-5, -1e-5):
            off = x.copy()
            off[-1] += step
            shifted, _ = self._belt(off)
            ends.append(station_law.residuals(inner, shifted))
        rows[:-1, -1] = (ends[0] - ends[1]) / 2e-5
        rows[-1, -1] = 1.0
        return rows
