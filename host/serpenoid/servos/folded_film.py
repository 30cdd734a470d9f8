"""How unevenly joints turn in a film of a gait: all pictures folded onto one cycle and one frame.

What is beside the gait's first harmonic loosens wheels that should hold. A servo that runs to each
setpoint and rests has lines at the frames' rate, and beside it by multiples of the gait's; jerks at
the joints' reversals have the gait's own harmonics. All are fitted to all pictures at once. Only
their size counts, so the film need not know the board's phase.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.sines import waves

Array = NDArray[np.float64]
_SIDE, _HIGHEST = 4, 32  # lines beside the frames' rate, either way; the gait's own harmonics
_OF_RATE, _ROWS = 0.42, 3  # of the pictures' rate: what is told; pictures a number that is fitted
_SHUTTER = 0.1  # an open shutter takes up to so much
_GRAIN_RAD_S = 0.02  # wheels hold below it, and tags that are glued on askew show it


@dataclass(frozen=True)
class Ripple:
    """Mean square of the joints' rates in some harmonics of the gait, (rad/s)^2; its sigma.

    The noise's share is taken away, so it may be below 0. harmonics: which; those near the frames'
    rate are the nearest ones of the gait.
    """

    square: float
    sigma: float
    harmonics: tuple[int, ...]

    def chi2(self, made_rad_s: float) -> float:
        """Return how far a servo that makes so much is off; the last hundredths do not count."""
        doubt = 2 * _GRAIN_RAD_S * max(made_rad_s, _GRAIN_RAD_S)
        return ((made_rad_s**2 - self.square) / math.hypot(self.sigma, doubt)) ** 2


def film_ripples(
    t_s: Array, joints_rad: Array, omega_rad_s: float, frame_s: float
) -> tuple[Ripple, ...]:
    """Return the ripples that a film shows: slow ones, and if it is quick those of the frames.

    joints_rad (T, n-1) at times t_s (T,), NaN where a tag was not seen. omega_rad_s: of the gait.
    Nothing is returned where the pictures are too few or too slow.
    """
    whole = np.isfinite(joints_rad).all(axis=1)
    if whole.sum() < 10:
        return ()
    t, joints = t_s[whole] - t_s[0], joints_rad[whole]
    most = math.tau * _OF_RATE / float(np.median(np.diff(t))) / omega_rad_s
    frames = math.tau / frame_s / omega_rad_s
    beside = np.arange(-_SIDE, _SIDE + 1) if frames + _SIDE <= most else np.arange(0)
    top = min(_HIGHEST, int(most), int(frames) - 2 * _SIDE)
    top = min(top, (len(t) // _ROWS - 2) // 2 - len(beside))
    if top < 2 or np.ptp(t) * omega_rad_s < math.tau:
        return ()
    orders = np.concatenate([np.arange(1, top + 1), frames + beside])
    size, doubt = _squares(t, joints, np.asarray(orders * omega_rad_s, dtype=np.float64))
    ripples = [_ripple(size[1:top], doubt[1:top], range(2, top + 1))]
    if len(beside):
        ripples.append(_ripple(size[top:], doubt[top:], (round(frames) + beside).tolist()))
    return tuple(ripples)


def _squares(t: Array, joints: Array, rates: Array) -> tuple[Array, Array]:
    """Return squares of the lines' rates and their variances, (lines, 2 (n-1)), cos and sin."""
    design = np.column_stack([waves(t, rates), t])
    sines = np.linalg.lstsq(design, joints)[0]
    noise = np.sum((joints - design @ sines) ** 2, axis=0) / (len(t) - design.shape[1])
    spread = np.diag(np.linalg.inv(design.T @ design))
    rate = np.repeat(rates, 2)[:, None]
    size, doubt = (rate * sines[1:-1]) ** 2, rate**2 * spread[1:-1, None] * noise
    return size.reshape(len(rates), -1), doubt.reshape(len(rates), -1)


def _ripple(size: Array, doubt: Array, harmonics: Sequence[int]) -> Ripple:
    """Return the mean square of some lines, the noise's share taken away."""
    joints = size.shape[1] / 2
    square = float(0.5 * np.sum(size - doubt) / joints)
    variance = np.sum(2 * doubt**2 + 4 * doubt * np.maximum(size - doubt, 0.0))
    sigma = 0.5 * math.sqrt(float(variance)) / joints
    return Ripple(square, math.hypot(sigma, 2 * _SHUTTER * max(square, 0.0)), tuple(harmonics))
