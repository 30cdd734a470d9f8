"""Residuals of one push, linearised, with its own parameters eliminated.

A film has its own initial speed and position; for a robot without a straight link also the angle
and the turning rate at the release. Positions are linearised in these. After their elimination two
residuals remain, for the difference of the common c and f from those of the film, and a third for
the floor's pull across if the robot slips.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .parameters import Floats
from .rolling_law import integral, rolled_m, stop_point


@dataclass(frozen=True, eq=False)
class PushTrack:
    """One push: the distance along_m at times t_s, both from its first position.

    source: "film", or "rest" for a push with one distance and time to rest. sigma_m, sigma_s: of a
    position and a time. heading_rad: angle of the path to the line of its floor at each time.
    slips: whether the robot may slip sideways. along_m is then along the chord of its path, left_m
    to the left of it, and chord_rad is the angle of the chord to the floor's line.
    """

    number: int
    source: str
    t_s: Floats
    along_m: Floats
    sigma_m: float
    sigma_s: float
    heading_rad: Floats
    left_m: Floats
    chord_rad: float = 0.0
    slips: bool = False

    @property
    def pushed_m_s(self) -> float:
        """Return a rough initial speed, m/s."""
        if self.source == "rest":
            return 2.0 * float(self.along_m[0] / self.t_s[0])
        far_m = 0.98 * float(self.along_m[-1])
        moving = max(int(np.searchsorted(self.along_m, far_m)) + 1, 3)
        return max(float(np.polyfit(self.t_s[:moving], self.along_m[:moving], 2)[1]), 0.05)

    @property
    def law_columns(self) -> list[int]:
        """Return the indices of the law's parameters that it determines, one for each residual."""
        return {"rest": [0], "film": [0, 1, 3] if self.slips else [0, 1]}[self.source]

    @cached_property
    def place_sigma_m(self) -> Floats:
        """Return the sigma of each position, m, which contains the error of its time."""
        if self.source == "rest":
            return np.full(1, self.sigma_m)
        moving_m_s = np.maximum(np.gradient(self.along_m, self.t_s), 0.0)
        return np.hypot(self.sigma_m, moving_m_s * self.sigma_s)

    def residuals(self, numbers: Floats) -> Floats:
        """Return predicted less measured positions over their sigma, (K, rows).

        numbers: (K, start + 8), a push's start, then its law. The start is speed and position; with
        slip, start and law are those of `slipped_places`.
        """
        start, law = numbers[:, :-8], numbers[:, -8:]
        if self.source == "rest":
            # a push that would not come to rest takes long, not for ever
            dry = np.maximum(law[:, 1] - law[:, 2], 1e-6)
            stop_s, stop_m = stop_point(start[:, 0], law[:, 0], dry)
            errors = (stop_m - self.along_m) / self.sigma_m, (stop_s - self.t_s) / self.sigma_s
            return np.stack(errors, axis=1)
        if self.slips:
            from .slip import slipped_places

            places_m = slipped_places(self.t_s, self.chord_rad, start, law)
            residuals = (places_m - [self.along_m, self.left_m]) / self.place_sigma_m
            return np.concatenate([residuals[:, 0], residuals[:, 1], start[:, 4:]], axis=1)
        speed, place = start.T[..., None]
        c, f = law.T[:2, :, None]
        pull = law[:, 2:4]
        headings = np.stack([np.cos(self.heading_rad), np.sin(self.heading_rad)])
        mean = headings.mean(axis=1, keepdims=True)
        level = f - pull @ mean
        # The change of the slope's pull along a turning path, relative to its mean heading.
        moving = np.minimum(self.t_s, stop_point(speed, c, level)[0])
        grown = np.exp(c * moving)
        faster = integral(grown * (pull @ (headings - mean)), moving) / grown
        way = place + rolled_m(self.t_s, speed, c, level) + integral(faster, moving)
        return np.asarray((way - self.along_m) / self.place_sigma_m)

    def linear_about(self, law: Floats, nearby: LinearTrack | None = None) -> LinearTrack:
        """Return the linearisation about a law (8,); nearby: one about another law, as a start."""
        if nearby is None:
            count = 6 if self.slips else len(self.law_columns)
            start = self.pushed_m_s * np.eye(1, count)[0]
            nearby = LinearTrack(law, start, np.zeros((len(start), 8)), law[:0], law[:0])
            for _ in range(4):  # steps of Gauss-Newton; the last one is below 1e-3 sigma
                nearby = self.linear_about(law, nearby)
        start = nearby.start + nearby.start_slopes @ (law - nearby.law)
        start[0] = max(start[0], 0.3 * self.pushed_m_s, 1e-3)
        count = len(start)
        steps = np.full(count + 8, 1e-3)
        steps[4:count] = 0.03  # slip and turning, in standard deviations of how hands let go
        changes = np.vstack([np.zeros_like(steps), np.diag(steps)])
        rows = self.residuals(np.concatenate([start, law]) + changes)
        slopes = (rows[1:] - rows[0]).T / steps
        by_start, columns = slopes[:, :count], np.column_stack([slopes[:, count:], rows[0]])
        follows = -np.linalg.lstsq(by_start, columns, rcond=None)[0]
        columns = columns + by_start @ follows
        told_rows = np.linalg.qr(columns[:, self.law_columns])[0].T @ columns
        start = start + follows[:, -1]
        return LinearTrack(law, start, follows[:, :-1], told_rows[:, -1], told_rows[:, :-1])


@dataclass(frozen=True, eq=False)
class LinearTrack:
    """The residuals of a push near a law (8,): offsets (rows,) and slopes (rows, 8).

    start: the push's own parameters there. start_slopes: their derivatives by the law, (start, 8).
    """

    law: Floats
    start: Floats
    start_slopes: Floats
    offsets: Floats
    slopes: Floats
