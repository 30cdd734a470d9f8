"""Short readings: a robot watched for some seconds on the belt, while it still drifts.

Its slip v obeys m_e v' = m g sin(gamma) - A v - B, of which rolling_law has the solution: with
c = A / m_e and f = (B - m g sin(gamma)) / m_e the way is x0 + v0 t p(c t) - f t^2 q(c t). Nothing
is differentiated: with c given the track's places are linear in x0, v0 and f, so that least squares
tell f, whatever x0 and v0 are. What is left for the fit is one balance a reading,

    m g sin(gamma) = B - m_e f(A / m_e),

which is that of a station, A v + B, where the robot holds: a steady slip v has f = -c v. So a
place is counted from where the mean slip would be, and all that a short reading adds is the f of
these small ways. Its error is that of places and times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...session.instruments import Instruments
from ...session.places import track_of
from .rolling_law import shapes

Floats = NDArray[np.float64]
_FEWEST, _HELD = 3, 1e24  # places, and the weight of each, 1 / m^2, where a robot was held


@dataclass(frozen=True)
class Tracks:
    """Places of N readings, (N, J): t_s; off_m, downhill, from the mean slip; weight, 1 / m^2.

    The weights of places that a reading has not are 0. One that was held has some at the mean slip,
    all but exact. effective_kg: of the robot with its wheels' turning, and rolling_sigma that
    share's standard deviation.
    """

    t_s: Floats
    off_m: Floats
    weight: Floats
    effective_kg: float
    rolling_sigma: float

    @classmethod
    def of(
        cls,
        places: Sequence[str],
        watches: Sequence[Instruments],
        mass_kg: float,
        rolling: tuple[float, float],
    ) -> Tracks:
        """Take readings' places, "" where one was held.

        rolling: J / r^2 of the wheels over the mass, and its standard deviation.
        """
        tracks = [track_of(text) for text in places]
        shape = len(tracks), max([_FEWEST, *(track.shape[1] for track in tracks)])
        t_s, off_m = np.tile(np.arange(shape[1], dtype=float), (shape[0], 1)), np.zeros(shape)
        weight = np.full(shape, _HELD)
        for k, (track, watch) in enumerate(zip(tracks, watches, strict=True)):
            t, y = track
            if not t.size:
                continue
            speed = np.abs(np.diff(y) / np.diff(t)).max()
            sigma_m = max(np.hypot(watch.distance_sigma_m, speed * watch.time_sigma_s), 1e-4)
            t_s[k, : t.size], off_m[k, : t.size] = t, y[-1] / t[-1] * t - y
            weight[k] = np.where(np.arange(shape[1]) < t.size, sigma_m**-2, 0.0)
        return cls(t_s, off_m, weight, mass_kg * (1.0 + rolling[0]), rolling[1] / (1 + rolling[0]))

    def drag(self, viscous: Floats, slip_m_s: Floats) -> Floats:
        """Return -m_e f of each reading, (K, N), N, at viscous frictions A (K, N), N s/m.

        A v where the robot was held.
        """
        force = viscous * slip_m_s
        if not self.off_m.any():
            return force
        return force - self.effective_kg * self._acceleration(viscous / self.effective_kg)[0]

    def inertia(self) -> tuple[Floats, Floats]:
        """Return the force that changes each reading's speed, roughly, and its error, N."""
        f, f_sigma = self._acceleration(np.zeros((1, len(self.t_s))))
        force = -self.effective_kg * f[0]
        return force, np.hypot(self.effective_kg * f_sigma[0], force * self.rolling_sigma)

    def _acceleration(self, c: Floats) -> tuple[Floats, Floats]:
        """Return f and its standard deviation at c, (K, N) each.

        The column of f is made orthogonal to those of x0 and v0: what remains of it tells f alone.
        """
        p, q = shapes(c[..., None] * self.t_s)[:2]

        def dot(a: Floats, b: Floats) -> Floats:
            return np.sum(self.weight * a * b, axis=-1, keepdims=True)

        level = np.ones_like(p)
        even, brake = self.t_s * p, -(self.t_s**2) * q
        even = even - dot(level, even) / dot(level, level)
        brake = brake - dot(level, brake) / dot(level, level)
        brake = brake - dot(even, brake) / dot(even, even) * even
        size = dot(brake, brake)[..., 0]
        return dot(brake, self.off_m)[..., 0] / size, size**-0.5
