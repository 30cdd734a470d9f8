"""How a robot without a straight link slips sideways, down a floor that falls across its way.

All its links stand at +-lambda to its axis, as many to either side. While it rolls fast, half of
the wheels slip to the left and half to the right, so that dry friction has no part across the axis.
Viscous friction has, and the robot slips by w' = a - c w, with a the floor's pull across. When the
speed along the axis has fallen to w / tan(lambda), half of the wheels slip no longer. From then on
the robot rolls along these, and is braked as one whose other half is bent by twice lambda.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..fitting.rolling_law import rest, way_m
from ..fitting.unknowns import Floats

_TRIED = 500  # moments at which the end of the slip is looked for


@dataclass(frozen=True)
class Slip:
    """What a push slips by.

    angle_rad: of all links to the axis. c_across: 1/s, of the slip. c_end, f_end: of the end, on
    level ground. pull_along: of the floor along the axis, m/s^2.
    """

    angle_rad: float
    c_across: float
    c_end: float
    f_end: float
    pull_along: float

    def places(self, t_s: Floats, law: tuple[Floats, ...], across: float) -> tuple[Floats, Floats]:
        """Return places (T,) along the axis and across it, m, at times from the start.

        law: speed at the start, c and f along the axis, (1,). across: the floor's pull across it,
        m/s^2, + to the left.
        """
        cos, sin = np.cos(self.angle_rad), np.sin(self.angle_rad)
        drift = np.zeros(1), np.array([self.c_across]), np.array([-abs(across)])

        def moved(t: Floats) -> tuple[Floats, ...]:
            (x, _, v), (y, _, w) = way_m(t, *law), way_m(t, *drift)
            return x, y, v, w

        every = np.linspace(0.0, min(rest(*law)[0][0], t_s[-1]), _TRIED)
        *_, v, w = moved(every)
        at = np.interp(np.zeros(1), w * cos - v * sin, every)
        *_, v, w = moved(at)
        f = self.f_end - self.pull_along * cos - abs(across) * sin
        end = np.hypot(v, w), np.array([self.c_end]), np.array([f])
        rolled = way_m(np.maximum(t_s - at, 0.0), *end)[0]
        x, y, *_ = moved(np.minimum(t_s, at))
        return x + cos * rolled, np.copysign(1.0, across) * (y + sin * rolled)
