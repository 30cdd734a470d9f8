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
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..kinds.instruments import Stopwatch
from ..kinds.places import track_of
from .rolling_law import shapes

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Tracks:
    """Places of N readings, (N, J): t_s; off_m, downhill, from the mean slip; weight, 1 / m^2.

    All weights of a reading that was held, and those of places it has not, are 0. effective_kg: of
    the robot with its wheels' turning, and rolling_sigma that share's standard deviation.
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
        watches: Sequence[Stopwatch],
        mass_kg: float,
        rolling: tuple[float, float],
    ) -> Tracks:
        """Take readings' places, "" where one was held.

        rolling: J / r^2 of the wheels over the mass, and its standard deviation.
        """
        tracks = [track_of(text) for text in places]
        shape = len(tracks), max((track.shape[1] for track in tracks), default=0)
        t_s, off_m, weight = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        for k, (track, watch) in enumerate(zip(tracks, watches, strict=True)):
            t, y = track
            if not t.size:
                continue
            speed = np.abs(np.diff(y) / np.diff(t)).max()
            sigma_m = max(np.hypot(watch.distance_sigma_m, speed * watch.time_sigma_s), 1e-4)
            t_s[k, : t.size], weight[k, : t.size] = t, sigma_m**-2
            off_m[k, : t.size] = y[-1] / t[-1] * t - y
        return cls(t_s, off_m, weight, mass_kg * (1.0 + rolling[0]), rolling[1] / (1 + rolling[0]))

    @property
    def watched(self) -> NDArray[np.bool_]:
        """Tell which readings are short ones."""
        return np.any(self.weight > 0.0, axis=1)

    def picked(self, index: NDArray[np.intp] | NDArray[np.bool_]) -> Tracks:
        """Return those of some readings."""
        return replace(
            self, t_s=self.t_s[index], off_m=self.off_m[index], weight=self.weight[index]
        )

    def drag(self, viscous: Floats, slip_m_s: Floats) -> Floats:
        """Return -m_e f of each reading, (K, N), N, at viscous frictions A (K, N), N s/m.

        A v where the robot was held.
        """
        force, on = viscous * slip_m_s, self.watched
        if on.any():
            f, _ = self.picked(on)._acceleration(viscous[:, on] / self.effective_kg)
            force[:, on] -= self.effective_kg * f
        return force

    def inertia(self) -> tuple[Floats, Floats]:
        """Return the force that changes each reading's speed, roughly, and its error, N."""
        force, sigma, on = np.zeros(len(self.t_s)), np.zeros(len(self.t_s)), self.watched
        if on.any():
            f, f_sigma = self.picked(on)._acceleration(np.zeros((1, int(on.sum()))))
            force[on] = -self.effective_kg * f[0]
            sigma[on] = np.hypot(self.effective_kg * f_sigma[0], force[on] * self.rolling_sigma)
        return force, sigma

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
