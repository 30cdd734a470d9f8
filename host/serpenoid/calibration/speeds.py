"""Speeds of gaits by the exact model, over frictions, the joints' amplitude and servos.

No other file of calibration solves states for speeds. Where a film showed a gait's joints, their
common amplitude is in no doubt, and of a servo only the ripple counts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..base.errors import NotConverged
from ..base.long_calls import in_threads
from ..model.drives import Servo
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.neighbours import Draw, drawn_speeds, drawn_states
from ..periodic.servo_steady import (
    drawn_servo_speeds,
    moved_by,
    ripple_share,
    servo_speed,
)
from ..periodic.steady import steady_gait
from .friction_result import ground_of

Array = NDArray[np.float64]
Progress = Callable[[int], None]
Speeds = Callable[[Array, Array], Array]  # (K, P) frictions, (K,) amplitudes -> (K, gaits), m/s
MODEL_SIGMA = 0.015  # of a predicted speed: joints' centres that are off, wheels that turn
AMPLITUDE_SIGMA = 0.03  # of the joints' true over commanded amplitude, common to all gaits
SERVO_SIGMA = 0.005  # relative, of what a servo is predicted to do
GRAIN = 0.01  # the same, where few servos are drawn of many; a rough state is off by 0.003
LEAST_M_S = 0.001  # of a predicted speed, beside MODEL_SIGMA
_SMOOTHING = 1e-4  # states are right to 1e-4, and some points are all but the same
ENDS = 1 / 1.04, 1.04  # of the common amplitude, where it is known within some per cent


def speed(robot: Robot, ground: Ground, gait: Gait, servo: Servo | None = None) -> float:
    """Return the exact model's speed to 1e-3 of itself, m/s; servo: what moves the joints."""
    ideal = steady_gait(robot, ground, gait, rtol=1e-3, powers=False)
    return ideal.speed_m_s if servo is None else servo_speed(ideal, servo)


def scaled(gait: Gait, amplitude: float) -> Gait:
    """Return the gait as joints run it that reach this share of their amplitude, at most pi."""
    return replace(gait, alpha_rad=min(gait.alpha_rad * amplitude, math.pi))


class SpeedTable:
    """Speeds that were solved for at some points, and interpolated between them.

    Points are logarithms of frictions and of the joints' amplitude. Cubic radial functions go
    through the logarithms of the speeds and LEAST_M_S together: at the foot of a cliff these still
    tell where it is, and what crawls slower is as good as at rest. No speed lies beyond all solved.
    """

    def __init__(self, solve: Speeds):
        self._solve, self._points, self._logs = solve, np.empty((0, 0)), np.empty((0, 0))

    @property
    def known(self) -> bool:
        """Tell whether there are any."""
        return self._logs.size > 0

    def add(self, whole: Array, amplitude: Array) -> Array:
        """Solve at points; return by how much the table was off there, (K, gaits), logarithms.

        The first time that is infinite. Points at which a speed is nan are left out.
        """
        speeds = self._solve(whole, amplitude)
        finite = np.isfinite(speeds).all(axis=1)
        if not finite.any():
            raise NotConverged("no periodic state was found for any friction that may be")
        whole, amplitude = whole[finite], amplitude[finite]
        logs, points = np.log(speeds[finite] + LEAST_M_S), _logs(whole, amplitude)
        if not self.known:
            self._points, self._logs, off = points, logs, np.full(logs.shape, np.inf)
        else:
            off = np.log(self(whole, amplitude) + LEAST_M_S) - logs
            self._points = np.vstack([self._points, points])
            self._logs = np.vstack([self._logs, logs])
        from scipy.interpolate import RBFInterpolator

        self._mean, self._spread = self._points.mean(axis=0), self._points.std(axis=0) + 1e-9
        unit = (self._points - self._mean) / self._spread
        self._between = RBFInterpolator(unit, self._logs, kernel="cubic", smoothing=_SMOOTHING)
        return off

    def __call__(self, whole: Array, amplitude: Array) -> Array:
        """Return the speeds (K, gaits), m/s."""
        unit = (_logs(whole, amplitude) - self._mean) / self._spread
        ends = self._logs.min(axis=0), self._logs.max(axis=0)
        return np.exp(np.clip(self._between(unit), *ends)) - LEAST_M_S


def _logs(whole: Array, amplitude: Array) -> Array:
    return np.log(np.column_stack([whole, amplitude]))


@dataclass(frozen=True)
class ServoEffects:
    """What each of S servos does to G gaits.

    share: of the ideal speed, (S, G); where a film showed the joints, of that with the amplitude
    filmed. amplitude: made over commanded, (S, films). Both with the joints' common amplitude as
    commanded; they change with its powers share_power and amplitude_power: a weak servo does not
    follow further. sigma: what both may be off by, relative.
    log_weight: (S,), of the kind's density over that of the draws.
    """

    servos: tuple[Servo, ...]
    share: Array
    amplitude: Array
    sigma: float = SERVO_SIGMA
    share_power: Array | float = 0.0
    amplitude_power: Array | float = 0.0
    log_weight: Array | float = 0.0

    def shares(self, amplitude: Array) -> Array:
        """Return the shares with common amplitudes (K,): (K, S, G)."""
        return self.share * amplitude[:, None, None] ** self.share_power

    def gains(self, amplitude: Array) -> Array:
        """Return filmed over commanded amplitudes, with common ones (K,): (K, S, films)."""
        return self.amplitude * amplitude[:, None, None] ** (1.0 + self.amplitude_power)

    def beside(self, other: ServoEffects) -> ServoEffects:
        """Return these servos and others."""
        names = ("share", "amplitude", "share_power", "amplitude_power")
        both = {name: np.vstack([getattr(self, name), getattr(other, name)]) for name in names}
        return replace(self, servos=self.servos + other.servos, **both)


@dataclass(frozen=True)
class SpeedModel:
    """Speeds of a robot in G gaits.

    ground: from whose states those of others are sought. gaits: as the joints make them.
    commanded: of a gait whose joints a film showed, what the robot was told; else None.
    """

    robot: Robot
    ground: Ground
    gaits: tuple[Gait, ...]
    commanded: tuple[Gait | None, ...]

    def ideal(self, whole: Array, amplitude: Array, unfound_m_s: float | None = None) -> Array:
        """Return (K, G) speeds of joints that follow the gait, m/s.

        whole, amplitude: K frictions of the whole snake, (K, P), and common amplitudes, (K,).
        unfound_m_s: as for `drawn_speeds`.
        """
        speeds = {
            pair: drawn_speeds(self.robot, *self._draws(whole, amplitude, *pair), unfound_m_s)
            for pair in dict.fromkeys(self._every)
        }
        return np.stack([speeds[pair] for pair in self._every], axis=1)

    def driven(self, whole: Array, amplitude: Array, servos: list[Servo]) -> tuple[Array, Array]:
        """Return (K, G) speeds of joints that follow the gait, and with a servo each, m/s."""
        speeds = []
        for gait, commanded in self._every:
            near, draws = self._draws(whole, amplitude, gait, commanded)
            states = drawn_states(self.robot, near, draws)
            ideal = np.array([state.speed_m_s for state in states])
            if commanded is None:
                speeds.append((ideal, drawn_servo_speeds(states, servos)))
            else:
                asked = [(ground, commanded) for ground, _ in draws]
                states = drawn_states(self.robot, (self.ground, commanded), asked)
                speeds.append(
                    (ideal, ideal * drawn_servo_speeds(states, servos, value=ripple_share))
                )
        ideal, both = np.array(speeds).transpose(1, 2, 0)
        return ideal, both

    def effects(self, servos: tuple[Servo, ...], ends: tuple[float, float] = ENDS) -> ServoEffects:
        """Return what some servos do to the gaits; none of them: joints follow the gait.

        ends: common amplitudes at which that is solved for.
        """
        films = np.array([commanded is not None for commanded in self.commanded], dtype=bool)
        if not servos:
            return ServoEffects((), np.ones((1, len(films))), np.ones((1, films.sum())), 0.0)
        several = len(servos) > 1
        # films of one command have it alike
        pairs = [(asked or gait, asked is not None) for gait, asked in self._every]
        once = list(dict.fromkeys(pairs))
        ideal = [
            (steady_gait(self.robot, self.ground, scaled(g, end), rtol=1e-3, powers=False), film)
            for end in ends
            for g, film in once
        ]
        jobs = [(state, servo, film, several) for state, film in ideal for servo in servos]
        moved = np.array(in_threads(lambda job: moved_by(*job), jobs))
        moved = moved.reshape(2, len(once), len(servos), 2)
        logs = np.log(np.maximum(moved[:, [once.index(pair) for pair in pairs]], 1e-3))
        power = ((logs[1] - logs[0]) / np.log(ends[1] / ends[0])).swapaxes(0, 1)
        middle = np.exp(logs[1].swapaxes(0, 1) - power * np.log(ends[1]))
        return ServoEffects(
            servos,
            middle[..., 0],
            middle[:, films, 1],
            GRAIN if several else SERVO_SIGMA,
            power[..., 0],
            power[:, films, 1],
        )

    @property
    def _every(self) -> list[tuple[Gait, Gait | None]]:
        return list(zip(self.gaits, self.commanded, strict=True))

    def _draws(
        self, whole: Array, amplitude: Array, gait: Gait, commanded: Gait | None
    ) -> tuple[Draw, list[Draw]]:
        """Return the state to begin from, and the draws of one gait."""
        gaits = [gait if commanded else scaled(gait, a) for a in amplitude.tolist()]
        grounds = [ground_of(self.robot.links, row) for row in whole.tolist()]
        return (self.ground, gaits[0]), list(zip(grounds, gaits, strict=True))
