"""How a robot without a straight link slips sideways: by a floor that falls, or a crooked start.

All its links stand at +-lambda to its axis, as many to either side. While it rolls fast, half of
the wheels slip to the left and half to the right, so that dry friction has no part across the axis
and no moment. Viscous friction has both. With speed v along the axis, w across it and turning rate
r, and with a the floor's pull across,

    w' = a - c w - r v,    r' = -c r,    v' = -(c_along v + f) + r w,

since n equal links spread along the axis resist a turn, over their moment of inertia, as they
resist the slip, over their mass (but for the links' own inertia: 2 % with 8 links, 9 % with 4).
When v has fallen to |w| / tan(lambda), half of the wheels slip no longer. From then on the robot
rolls along these without turning, and is braked as one whose other half is bent by twice lambda.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .parameters import Floats
from .rolling_law import rest, way_m

MOMENTS = 200  # of the motion, equally spaced: its integrals are then right to 1e-5 m


@dataclass(frozen=True)
class Start:
    """How a push is let go: how fast across its axis and how fast turning, + to the left."""

    across_m_s: float = 0.0
    turn_rad_s: float = 0.0


@dataclass(frozen=True)
class Slip:
    """What a push slips by.

    angle_rad: of all links to the axis. c_across: 1/s, of the slip. c_end, f_end: of the end, on
    level ground.
    """

    angle_rad: float
    c_across: float
    c_end: float
    f_end: float

    def places(
        self,
        t_s: Floats,
        law: tuple[Floats, ...],
        pull: tuple[float, float] | Floats,
        start: Start,
        axis_rad: float = 0.0,
    ) -> tuple[Floats, Floats, Floats]:
        """Return places (T,) along the first axis and across it, m, and the turn since, rad.

        t_s: from the start. law: speed at the start, c and f along the axis, (1,). pull: of the
        floor, m/s^2, along its line and to the left. axis_rad: of the first axis to that line.
        """
        t = np.linspace(0.0, min(rest(*law)[0][0], t_s[-1]), MOMENTS)

        def integral(rate: Floats) -> Floats:
            """Return the integral since the start, by the trapezoidal rule."""
            steps = 0.5 * t[1] * (rate[1:] + rate[:-1])
            return np.concatenate([[0.0], np.cumsum(steps)])

        def slowed(speed: float, c: float, push: Floats) -> Floats:
            """Return a speed that viscous friction c and an acceleration change."""
            grown = np.exp(c * t)
            return (speed + integral(grown * push)) / grown

        speed, c, f = (float(part[0]) for part in law)
        turn = start.turn_rad_s * np.exp(-self.c_across * t)
        heading, v = integral(turn), slowed(speed, c, np.full_like(t, -f))
        off_line = axis_rad + heading
        across = pull[1] * np.cos(off_line) - pull[0] * np.sin(off_line)
        w = slowed(start.across_m_s, self.c_across, across - turn * v)
        v = slowed(speed, c, turn * w - f)
        x = integral(v * np.cos(heading) - w * np.sin(heading))
        y = integral(v * np.sin(heading) + w * np.cos(heading))
        until_s = self._end_s(t, v, w)
        before = np.minimum(t_s, until_s)
        x_m, y_m, turned_rad = (np.interp(before, t, part) for part in (x, y, heading))
        v, w, heading = (np.interp(until_s, t, part) for part in (v, w, heading))
        side = np.copysign(1.0, w)
        direction = heading + side * self.angle_rad
        off_line = axis_rad + direction
        f = self.f_end - pull[0] * np.cos(off_line) - pull[1] * np.sin(off_line)
        rolled = way_m(np.maximum(t_s - until_s, 0.0), np.hypot(v, w), np.array([self.c_end]), f)[0]
        return x_m + np.cos(direction) * rolled, y_m + np.sin(direction) * rolled, turned_rad

    def _end_s(self, t: Floats, v: Floats, w: Floats) -> Floats:
        """Return the time (1,) at which half of the wheels slip no longer; the last if none."""
        slower = np.abs(w) - np.tan(self.angle_rad) * v
        ended = np.flatnonzero(slower[1:] > 0.0)[:1]
        if not len(ended):
            return t[-1:]
        about = slice(int(ended[0]), int(ended[0]) + 2)
        return np.interp(np.zeros(1), slower[about], t[about])
