"""How far a gait stands from the cliff: amplitude or grip it may lose, and speeds around it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..base.errors import NotConverged
from ..base.rows import Result, Row, detail
from ..model.core_model import check_parts
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import speed_floor_m_s, steady_gait
from .shapes import FINE

KEEP = 0.9  # of its speed: a gait's margin ends where it makes less
LESS_AMPLITUDE, LESS_GRIP = 0.10, 0.13  # servos under load; one sigma of a 7.5 deg session
BELOW = 1.0, 3.0  # gaining more than this by 10 % or 60 % of amplitude it lies below one
CLIFF = 0.25  # a gait that loses more than this of its speed to either stands at a cliff
_LOSSES = np.linspace(0, 0.6, 31)  # looked at outwards: a speed may fall and rise again between


@dataclass(frozen=True, slots=True)
class Margins(Result):
    """Hold how much a gait can bear; all are NaN for a gait that does not travel.

    Attributes
    ----------
    amplitude, grip
        The share that the joints' amplitude, or fn0, may lose before the speed loses a tenth; inf:
        at 60 % less it has not. grip is NaN without dry friction across the links.
    amplitude_loss, grip_loss
        The share of speed lost when the amplitude is 10 %, or fn0 13 % less.
    amplitude_gain, far_gain
        The share of speed gained when the amplitude is 10 %, or 60 % more.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> margins = sn.gait_margins(robot, ground, gait)
    >>> round(margins.amplitude, 2), round(margins.amplitude_loss, 2)
    (0.11, 0.08)
    """

    amplitude: float
    grip: float
    amplitude_loss: float
    grip_loss: float
    amplitude_gain: float = 0.0
    far_gain: float = 0.0

    @property
    def travels(self) -> bool:
        """Tell whether the gait gets along at all."""
        return not math.isnan(self.amplitude_loss)

    @property
    def below_cliff(self) -> bool:
        """Tell whether 10 % more amplitude would double the speed, or 60 % make it fourfold."""
        return self.amplitude_gain > BELOW[0] or self.far_gain > BELOW[1]

    @property
    def near_cliff(self) -> bool:
        """Tell whether 10 % of amplitude or 13 % of fn0 costs more than a quarter of the speed."""
        return max(self.amplitude_loss, self.grip_loss) > CLIFF

    @property
    def warning(self) -> str:
        """Return what a user must know, or nothing."""
        if not self.travels:
            return "this gait does not travel: there is no speed to lose"
        if self.below_cliff:
            more, gain = max((self.amplitude_gain, 10), (self.far_gain, 60))[::-1]
            return (
                f"this gait is below a cliff: {more} % more amplitude makes it {1 + gain:.2g} "
                "times as fast"
            )
        if not self.near_cliff:
            return ""
        losses = {
            "10 % less amplitude": self.amplitude_loss,
            "13 % less dry friction across (fn0)": self.grip_loss,
        }
        costs = ", ".join(f"{n} costs {100 * by:.0f} %" for n, by in losses.items() if by > 0.005)
        return f"this gait stands at a cliff: {costs} of the speed"

    def rows(self) -> list[Row]:
        """Return how far the cliff is, and what is lost near by; nothing for a gait at rest."""
        falls = "may fall by, for a tenth of the speed"
        parts = {
            f"amplitude {falls}": self.amplitude,
            f"dry friction across (fn0) {falls}": self.grip,
            "speed lost with 10 % less amplitude": self.amplitude_loss,
            "speed lost with 13 % less fn0 (1 sigma of a session bent by 7.5°)": self.grip_loss,
        }
        return [
            detail(name, "%", 100 * part, "more than 60" if math.isinf(part) else "")
            for name, part in parts.items()
            if not math.isnan(part)
        ]

    def in_sigmas(self, amplitude_sigma: float, grip_sigma: float) -> dict[str, float]:
        """Return both margins in standard deviations, by name.

        amplitude_sigma, grip_sigma: of the joints' amplitude and of fn0, relative.
        """
        return {
            f"{name}_sigmas": margin / sigma if sigma > 0 else math.inf
            for name, margin, sigma in (
                ("amplitude", self.amplitude, amplitude_sigma),
                ("grip", self.grip, grip_sigma),
            )
        }

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name, for JSON."""
        return asdict(self) | {"near_cliff": self.near_cliff, "below_cliff": self.below_cliff}


def _fall(speed_at: Callable[[float], float], full: float) -> float:
    """Return the least loss at which the speed has fallen by a tenth: outwards, then Brent."""
    from scipy.optimize import brentq

    def spare(loss: float) -> float:
        return speed_at(loss) / full - KEEP

    for low, high in pairwise(_LOSSES.tolist()):
        if spare(high) <= 0:
            return float(brentq(spare, low, high, rtol=FINE))  # pyright: ignore
    return math.inf


def gait_margins(robot: Robot, ground: Ground, gait: Gait) -> Margins:
    """Find how much amplitude or fn0 a gait may lose, by solving gaits and grounds with less.

    Parameters
    ----------
    robot, ground, gait
        What crawls, on what and how.

    Returns
    -------
    Margins
        Losses that the gait bears, and the speed that smaller ones cost.

    Raises
    ------
    BadInput
        For arguments of a wrong kind.
    NotConverged
        If a gait with less has no periodic state.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> margins = sn.gait_margins(robot, ground, gait)
    >>> bool(margins.amplitude > 0)
    True
    """

    def speed(ground: Ground, gait: Gait) -> float:
        try:
            return steady_gait(robot, ground, gait, rtol=FINE, powers=False).speed_m_s
        except NotConverged as error:
            if error.best is None or not error.best.error_estimate < 0.03:
                raise
            return error.best.speed_m_s

    def weaker(loss: float) -> float:
        return speed(ground, replace(gait, alpha_rad=min((1 - loss) * gait.alpha_rad, math.pi)))

    def looser(loss: float) -> float:
        return speed(replace(ground, fn0=(1 - loss) * ground.fn0), gait)

    check_parts(robot, ground, gait)
    full = speed(ground, gait)
    if full <= speed_floor_m_s(robot, gait.omega_rad_s):
        return Margins(*(math.nan,) * 6)
    grip = ground.fn0 > 0
    return Margins(
        _fall(weaker, full),
        _fall(looser, full) if grip else math.nan,
        1 - weaker(LESS_AMPLITUDE) / full,
        1 - looser(LESS_GRIP) / full if grip else math.nan,
        *(
            weaker(-min(gain, math.pi / gait.alpha_rad - 1)) / full - 1
            for gain in (LESS_AMPLITUDE, _LOSSES[-1])
        ),
    )
