"""How a filmed push that slips was let go, told by its path, and what slip does to its places.

A hand lets a robot go some degrees crooked, and turning. A robot with a straight link follows its
wheels all the same. One without slips, and rolls farther at the end, by how fast it then is across.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..fitting.rolling_law import way_m
from ..fitting.unknowns import Floats
from .arc import along, directions_rad
from .slip import Slip, Start

# Standard deviations of how hands let go: of the axis to the push, and of its turning. With less,
# sound sessions are called contradictory. A path too short to tell counts as a straight start.
CROOKED_RAD, TURNING_RAD_S = math.radians(2.0), math.radians(4.0)
_ROUNDS = 3  # of Gauss-Newton for the start: its last step is below 1e-3 standard deviations
# Of differences: of the law's three numbers and the floor's two pulls, the start's two, the slip's.
_STEPS = np.array([1e-3] * 5 + [0.03] * 2 + [1e-3] * 4)
_PULL, _START, _SLIP = slice(3, 5), slice(5, 7), slice(7, 11)


@dataclass(frozen=True)
class CrookedPush:
    """What is known of a push that slips.

    slip: the numbers of `Slip`. law: speed at the start, c and f along the axis. pull: the floor's,
    along its line and to the left. axis_rad: of the first axis to that line. t_s, across_m (T,):
    times from the start, and places to the left of a straight line. sigma_m: of a place.
    """

    slip: Floats
    law: tuple[float, float, float]
    pull: Floats
    axis_rad: float
    t_s: Floats
    across_m: Floats
    sigma_m: float

    def near(self) -> Sideways:
        """Return what slip does to its places, with the likeliest start."""
        start = self._likeliest_start()
        numbers = self._numbers(start)
        x, y, turned_rad = self._places(numbers)
        further = self._rows(numbers)[: len(x)]
        axis_rad = directions_rad(x, y, self.sigma_m) - turned_rad
        return Sideways(self, further, x, axis_rad, y - self.across_m, start)

    def slopes(self, start: Floats) -> Floats:
        """Return slopes of how far it is carried, and below of its places across, (2 T, 11).

        They are by speed, c and f, the two pulls, the start's two, and the slip's four.
        """
        numbers = self._numbers(start)
        here = self._rows(numbers)
        changes = [self._rows(numbers + step) - here for step in np.diag(_STEPS)]
        return np.stack(changes, axis=1) / _STEPS

    def _numbers(self, start: Floats) -> Floats:
        return np.array([*self.law, *self.pull, *start, *self.slip])

    def _places(self, numbers: Floats) -> tuple[Floats, ...]:
        """Return `Slip.places` of these numbers."""
        across, turning = numbers[_START] * [CROOKED_RAD * self.law[0], TURNING_RAD_S]
        law, pull = tuple(numbers[:3, None]), numbers[_PULL]
        start = Start(float(across), float(turning))
        return Slip(*numbers[_SLIP]).places(self.t_s, law, pull, start, self.axis_rad)

    def _rows(self, numbers: Floats) -> Floats:
        """Return how far slip carries it along its path, then its places across, (2 T,), m."""
        x, y, _ = self._places(numbers)
        way = along(x, y, self.sigma_m)
        return np.concatenate([way - way[0] - way_m(self.t_s, *numbers[:3, None])[0], y])

    def _likeliest_start(self) -> Floats:
        """Return how it was let go, by its places across; place and direction there are free."""
        start = np.zeros(2)
        for _ in range(_ROUNDS):
            numbers = self._numbers(start)
            x, y, _ = self._places(numbers)
            steps = np.diag(_STEPS)[_START]
            by_start = [(self._places(numbers + step)[1] - y) / step.max() for step in steps]
            free = np.linalg.qr(np.stack([np.ones_like(x), x], axis=1))[0]
            rows = np.stack([*by_start, self.across_m - y], axis=1) / self.sigma_m
            rows -= free @ (free.T @ rows)
            rows = np.concatenate([rows, np.column_stack([np.eye(2), -start])])
            start = start + np.linalg.lstsq(rows[:, :2], rows[:, 2], rcond=None)[0]
        return start


@dataclass(frozen=True)
class Sideways:
    """What slip does to a push.

    further_m, x_m (T,): how far slip carries it along its path; its places along the first axis.
    axis_rad (T,): of the path to the axis. off_m (T,): places across, less those measured. start:
    across and turning, in standard deviations of how hands let go.
    """

    push: CrookedPush
    further_m: Floats
    x_m: Floats
    axis_rad: Floats
    off_m: Floats
    start: Floats


@dataclass(frozen=True)
class PushRows:
    """A push's residuals near a point, in sigmas, with their slopes, before its own are eliminated.

    own: by what each push has of its own. by_law, by_pull, by_slip: by what all share: c and f, the
    floor's pull, and the slip's numbers.
    """

    off: Floats
    own: Floats
    by_law: Floats
    by_pull: Floats
    by_slip: Floats | None = None

    def with_sideways(self, sideways: Sideways, sigma_m: Floats, heading: Floats) -> PushRows:
        """Return them with places across, and the start's own, below those along.

        sigma_m: of each place. heading: mean cosine and sine of the axis to the floor's line.
        """
        count = len(sigma_m)
        slopes = sideways.push.slopes(sideways.start) / np.tile(sigma_m, 2)[:, None]
        slopes = np.concatenate([slopes, np.zeros((2, slopes.shape[1]))])

        def below(rows: Floats) -> Floats:
            return np.concatenate([rows, np.zeros((count + 2, rows.shape[1]))])

        own = np.zeros((2 * count + 2, 4))
        own[count : 2 * count, 0] = 1.0 / sigma_m
        own[count : 2 * count, 1] = sideways.x_m / sigma_m
        own[:, 2:] = slopes[:, _START]
        own[-2:, 2:] = np.eye(2)
        started = below(self.own)
        started[:, 0] += slopes[:, 0]
        by_pull = below(self.by_pull) - slopes[:, 2:3] * heading + slopes[:, _PULL]
        return replace(
            self,
            off=np.concatenate([self.off, sideways.off_m / sigma_m, sideways.start]),
            own=np.column_stack([started, own]),
            by_law=below(self.by_law) + slopes[:, 1:3],
            by_pull=by_pull,
            by_slip=slopes[:, _SLIP],
        )
