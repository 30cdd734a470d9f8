"""Periodic states of draws that make one band, each begun from one that is near."""

from __future__ import annotations

from collections.abc import Sequence

from .. import _core
from ..base.long_calls import threads_to_use
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .steady import Steady, check_ground, from_core, steady_gait

Draw = tuple[Ground, Gait]
_RTOL = 1e-3


def drawn_states(robot: Robot, middle_draw: Draw, draws: Sequence[Draw]) -> list[Steady]:
    """Return the periodic state of each draw to 1e-3 of its speed, begun from one that is near.

    Raises BadInput and NotConverged as `steady_gait` does.
    """
    parts = [(robot, *draw) for draw in (middle_draw, *draws)]
    for _, ground, _ in parts:
        check_ground(ground, _RTOL)
    middle, *models = (core_model(*part) for part in parts)
    threads = min(threads_to_use(), max(len(models), 1))
    states = _core.neighbours(middle, models, _RTOL, False, threads)
    return [
        from_core(*part, state) if state.converged else steady_gait(*part, rtol=_RTOL, powers=False)
        for part, state in zip(parts[1:], states, strict=True)
    ]
