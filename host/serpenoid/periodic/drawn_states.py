"""Periodic states of draws that make one band, each begun from one that is near."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .grid import threads_to_use
from .steady import Steady, check_ground, from_core, steady_gait

Array = NDArray[np.float64]
Draw = tuple[Ground, Gait]
_RTOL = 1e-3


def drawn_states(robot: Robot, near: Draw, draws: Sequence[Draw]) -> list[Steady]:
    """Return the periodic state of each draw to 1e-3 of its speed, begun from one that is near.

    Raises BadInput and NotConverged as `steady_gait` does.
    """
    return [
        from_core(robot, *draw, s)
        if s.converged
        else steady_gait(robot, *draw, rtol=_RTOL, powers=False)
        for draw, s in zip(draws, neighbours(robot, near, draws), strict=True)
    ]


def drawn_speeds(
    robot: Robot, near: Draw, draws: Sequence[Draw], unfound_m_s: float | None = None
) -> Array:
    """Return the speeds of draws, m/s, as `drawn_states`.

    unfound_m_s: stands for a state that was not found; None: such a state is solved for alone, or
    NotConverged.
    """
    if unfound_m_s is None:
        return np.array([state.speed_m_s for state in drawn_states(robot, near, draws)])
    states = neighbours(robot, near, draws)
    return np.array([s.speed if s.converged else unfound_m_s for s in states])


def neighbours(
    robot: Robot, near: Draw, draws: Sequence[Draw], rough: bool = False
) -> list[_core.SteadyState]:
    """Return the core's states of draws to 1e-3, also those that did not converge.

    rough: speeds mostly to a thousandth or two, at a cliff far worse; for searches alone.
    """
    for ground, _ in (near, *draws):
        check_ground(ground, _RTOL)
    middle, *models = (core_model(robot, *draw) for draw in (near, *draws))
    threads = min(threads_to_use(None), max(len(models), 1))
    return _core.neighbours(middle, models, _RTOL, False, threads, rough=rough)
