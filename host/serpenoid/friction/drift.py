"""Short readings of a robot that still drifts on the belt, in which inertia counts.

Its slip v obeys m_e v' = m g sin(gamma) - A v - B, of which rolling_law has the solution: with
c = A / m_e and f = (B - m g sin(gamma)) / m_e the position is x0 + v0 t p(c t) - f t^2 q(c t). For
a given c it is linear in x0, v0 and f, so that f follows by least squares, without derivatives of
the track. For the fit remains one balance of forces for each reading,

    m g sin(gamma) = B - m_e f(A / m_e),

which is that of a station, A v + B, if the slip is steady, with f = -c v. Positions are relative to
motion at the mean slip, so that a short reading only adds the f of these small displacements. Its
error comes from positions and times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..session.session import Session
from .parameters import Floats
from .rolling_law import coefficients


@dataclass(frozen=True, eq=False)
class Drift:
    """Positions of one short reading.

    t_s: (J,). off_m: displacement downhill from motion at the mean slip, (J,). sigma_m: sigma of a
    position, which contains the error of its time. effective_kg, effective_sigma: m_e, and its
    relative sigma.
    """

    t_s: Floats
    off_m: Floats
    sigma_m: float
    effective_kg: float
    effective_sigma: float

    def force_n(self, viscous: Floats) -> Floats:
        """Return m_e f, N, (K,), for viscous frictions A (K,), N s/m."""
        column = self._own_column(viscous / self.effective_kg)
        return self.effective_kg * (column @ self.off_m) / np.sum(column**2, axis=1)

    @property
    def force_sigma_n(self) -> float:
        """Return the sigma of m_e f, N."""
        level = np.zeros(1)
        by_places_n = self.effective_kg * self.sigma_m / np.linalg.norm(self._own_column(level))
        return float(np.hypot(by_places_n, self.force_n(level)[0] * self.effective_sigma))

    def _own_column(self, c: Floats) -> Floats:
        """Return the column of f, (K, J), made orthogonal to those of x0 and v0."""
        p, q = coefficients(c[:, None] * self.t_s)
        rolled = self.t_s * p
        braked = -(self.t_s**2) * q
        rolled = rolled - rolled.mean(axis=1, keepdims=True)
        braked = braked - braked.mean(axis=1, keepdims=True)
        share = np.sum(braked * rolled, axis=1) / np.sum(rolled**2, axis=1)
        return np.asarray(braked - share[:, None] * rolled)


def drifts_of(session: Session) -> dict[int, Drift]:
    """Return the drifts of short readings, index among the kept stations -> drift."""
    tools, robot = session.setup.instruments, session.setup.robot
    rolling, rolling_sigma = wheels_share(session)
    mass = robot.links * robot.link_mass_kg * (1.0 + rolling), rolling_sigma / (1.0 + rolling)
    drifts = {}
    for k, reading in enumerate(session.kept_stations):
        if reading.track is not None:
            t, y, _ = (reading.track.values - reading.track.values[0]).T
            speed = float(np.abs(np.diff(y) / np.diff(t)).max())
            sigma_m = math.hypot(tools.distance_sigma_m, speed * tools.time_sigma_s)
            off_m = y[-1] / t[-1] * t - y
            drifts[k] = Drift(t, off_m, max(sigma_m, 1e-4), *mass)
    return drifts


def wheels_share(session: Session) -> tuple[float, float]:
    """Return J / r^2 of all wheels over the robot's mass, and its sigma."""
    wheels_kg = session.setup.robot_table.wheels_kg
    if wheels_kg is None:
        return 0.045, 0.03
    # J / r^2 over a wheel's mass: 0.5 for a disc, 1 for a ring; with the spread of what is sold
    mean, sigma = 0.75, 0.15
    share = wheels_kg / (session.setup.robot.links * session.setup.robot.link_mass_kg)
    return mean * share, sigma * share
