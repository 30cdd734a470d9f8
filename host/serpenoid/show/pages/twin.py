"""The predicted twin of a driven robot: its periodic state at any phase that the board tells."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.scene import Scene
from ...simulation.simulate import simulate
from ..plot import along_travel

Array = NDArray[np.float64]
Places = NDArray[np.complex128]  # x + iy


@dataclass(frozen=True)
class Motion:
    """The links at N moments, (N, n) each: centres in m, angles in rad, velocities in m/s."""

    x_m: Array
    y_m: Array
    theta_rad: Array
    vx_m_s: Array
    vy_m_s: Array

    @property
    def slip_m_s(self) -> Array:
        """Return the wheels' speed across their links."""
        return self.vy_m_s * np.cos(self.theta_rad) - self.vx_m_s * np.sin(self.theta_rad)


class Twin:
    """A gait's periodic state: one cycle is simulated, later ones are that one, moved on.

    It travels along x from the origin on, in the mean of the first cycle.
    """

    def __init__(self, robot: Robot, ground: Ground, gait: Gait):
        scene = Scene(
            robot, ground, gait, start="steady", dt_s=gait.period_s / 400, record_every=2,
            method="rk4" if ground.smooth else "nonsmooth", duration_s=gait.period_s,
        )  # fmt: skip
        self.scene = scene
        run = along_travel(simulate(scene))
        self._phase_rad = gait.omega_rad_s * run.t_s
        self._place = run.x_m + 1j * run.y_m
        self._velocity = run.vx_m_s + 1j * run.vy_m_s
        self._theta_rad = run.theta_rad
        self._turn_rad = float(run.theta_rad[-1, 0] - run.theta_rad[0, 0])
        turned = cmath.exp(1j * self._turn_rad)
        self._step = complex(np.mean(self._place[-1] - turned * self._place[0]))

    def at(self, phase_rad: Array) -> Motion:
        """Return the motion at phases counted on over the cycles, (N,)."""
        cycle, within = np.divmod(phase_rad, 2 * math.pi)
        turned = np.exp(1j * self._turn_rad * cycle)[:, None]
        moved = self._step * _geometric(cmath.exp(1j * self._turn_rad), cycle)[:, None]
        place: Places = turned * self._table(within, self._place) + moved
        velocity: Places = turned * self._table(within, self._velocity)
        theta = self._table(within, self._theta_rad) + self._turn_rad * cycle[:, None]
        return Motion(place.real, place.imag, theta, velocity.real, velocity.imag)

    def _table(self, phase_rad: Array, columns: NDArray[Any]) -> NDArray[Any]:
        return np.stack([np.interp(phase_rad, self._phase_rad, c) for c in columns.T], axis=1)


def _geometric(ratio: complex, count: Array) -> Places:
    """Return 1 + ratio + ... to `count` terms, of a ratio of size 1."""
    if abs(ratio - 1) < 1e-9:
        return count.astype(complex)
    return np.asarray((1 - ratio**count) / (1 - ratio), dtype=complex)
