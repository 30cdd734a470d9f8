"""Speed around a gait when servos make less or more of it and wheels grip less or more."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import steady_gait
from .shape_search import on_threads
from .uncertainty import FRICTION, Uncertainty

Array = NDArray[np.float64]
_RTOL = 3e-3


@dataclass(frozen=True, slots=True)
class Cliff:
    """Hold speeds over factors of amplitude (A,) and of the grip across the links (F,).

    speed_m_s: (A, F), NaN where no periodic state was found. grip: the friction that is varied,
    "fn0", or "cn" on ground without. sigma: of both factors, as the uncertainty states them.
    """

    robot: Robot
    ground: Ground
    gait: Gait
    grip: str
    amplitude: Array
    factor: Array
    speed_m_s: Array
    full_m_s: float
    sigma: tuple[float, float]


def cliff_around(
    robot: Robot, ground: Ground, gait: Gait, uncertainty: Uncertainty, points: int = 17
) -> Cliff:
    """Solve a gait for a grid of amplitudes and grips around it. Raises BadInput."""
    grip = "fn0" if ground.fn0 > 0 else "cn"
    amplitude, factor = np.linspace(0.7, 1.2, points), np.linspace(0.5, 1.5, points)
    top = math.pi / gait.alpha_rad
    amplitude = amplitude[amplitude <= top]

    def speed(pair: tuple[float, float]) -> float:
        a, f = pair
        other = replace(ground, **{grip: f * getattr(ground, grip)})
        weak = replace(gait, alpha_rad=a * gait.alpha_rad)
        try:
            return steady_gait(robot, other, weak, rtol=_RTOL, powers=False).speed_m_s
        except NotConverged as error:
            return error.best.speed_m_s if error.best is not None else math.nan

    pairs = [(a, f) for a in amplitude.tolist() for f in factor.tolist()]
    speeds = np.array(on_threads(speed, pairs)).reshape(amplitude.size, factor.size)
    joints = robot.links - 1
    of_all = math.hypot(uncertainty.common_amplitude, uncertainty.amplitude / math.sqrt(joints))
    return Cliff(
        robot, ground, gait, grip, amplitude, factor, speeds, speed((1.0, 1.0)),
        (of_all, _sigma(uncertainty, grip)),
    )  # fmt: skip


def _sigma(uncertainty: Uncertainty, grip: str) -> float:
    """Return the relative sigma of a friction."""
    if not uncertainty.grounds:
        return uncertainty.friction[FRICTION.index(grip)]
    values = np.array([getattr(ground, grip) for ground in uncertainty.grounds])
    return float(values.std() / values.mean())
