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
        """Take readings' places, "" where one was held; rolling: as floor.data's."""
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

    def drag(self, viscous: Floats, slip_m_s: Floats) -> tuple[Floats, Floats]:
        """Return -m_e f of each reading, N, and its derivative by A, m/s, at viscous frictions A.

        A v and v where the robot was held.
        """
        force, speed, on = viscous * slip_m_s, slip_m_s.copy(), self.watched
        if on.any():
            f, by_c, _ = self.picked(on)._told(viscous[on] / self.effective_kg)
            force[on] -= self.effective_kg * f
            speed[on] -= by_c
        return force, speed

    def inertia(self) -> tuple[Floats, Floats]:
        """Return the force that changes each reading's speed, roughly, and its error, N."""
        force, sigma, on = np.zeros(len(self.t_s)), np.zeros(len(self.t_s)), self.watched
        if on.any():
            f, _, f_sigma = self.picked(on)._told(np.zeros(int(on.sum())))
            force[on] = -self.effective_kg * f
            sigma[on] = np.hypot(self.effective_kg * f_sigma, force[on] * self.rolling_sigma)
        return force, sigma

    def _told(self, c: Floats) -> tuple[Floats, Floats, Floats]:
        """Return f, its derivative by c, and its standard deviation; (N,) each."""
        t, w = self.t_s, self.weight[..., None]
        p, q, by_p, by_q = shapes(c[:, None] * t)
        design = np.stack([np.ones_like(t), t * p, -(t**2) * q], axis=-1)
        slopes = np.stack([np.zeros_like(t), t**2 * by_p, -(t**3) * by_q], axis=-1)
        weighted = np.swapaxes(w * design, 1, 2)
        inverse = np.linalg.inv(weighted @ design)
        x = inverse @ weighted @ self.off_m[..., None]
        left = self.off_m[..., None] - design @ x
        by_c = inverse @ (np.swapaxes(w * slopes, 1, 2) @ left - weighted @ (slopes @ x))
        return x[:, 2, 0], by_c[:, 2, 0], np.sqrt(inverse[:, 2, 2])
