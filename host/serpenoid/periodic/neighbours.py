"""Periodic states of draws that make one band, each begun from one that is near."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import _core
from ..base.long_calls import threads_to_use
from ..base.vectors import Array
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .steady import Steady, check_ground, from_core, steady_gait

Draw = tuple[Ground, Gait]
Parts = tuple[Robot, Ground, Gait]
_RTOL = 1e-3


def neighbours(
    near: Parts, others: Sequence[Parts], rough: bool = False
) -> list[_core.SteadyState]:
    """Return the core's states of others to 1e-3, also those that did not converge.

    rough: speeds mostly to a thousandth or two, at a cliff far worse; for searches alone.
    """
    for _, ground, _ in (near, *others):
        check_ground(ground, _RTOL)
    middle, *models = (core_model(*parts) for parts in (near, *others))
    threads = min(threads_to_use(), max(len(models), 1))
    return _core.neighbours(middle, models, _RTOL, False, threads, rough=rough)


def drawn_states(robot: Robot, near: Draw, draws: Sequence[Draw]) -> list[Steady]:
    """Return the periodic state of each draw to 1e-3 of its speed, begun from one that is near.

    Raises BadInput and NotConverged as `steady_gait` does.
    """
    parts = [(robot, *draw) for draw in draws]
    return [
        from_core(*part, state) if state.converged else steady_gait(*part, rtol=_RTOL, powers=False)
        for part, state in zip(parts, neighbours((robot, *near), parts), strict=True)
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
    states = neighbours((robot, *near), [(robot, *draw) for draw in draws])
    return np.array([s.speed if s.converged else unfound_m_s for s in states])
