"""Speeds of crawls on many grounds: each state is sought from a neighbour's, on all processors."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...model.gait import Gait
from ...model.robot import Robot
from ...periodic.drawn_states import drawn_speeds
from ..friction_result import ground_of
from ..speed_samples import scaled

Array = NDArray[np.float64]
Speeds = Callable[[Array, Array], Array]  # (K, 4) frictions, (K,) amplitudes -> (K, gaits), m/s


class SpeedSolver:
    """Predict the speeds of G gaits of a robot whose joints follow them.

    seen: gaits whose joints a film showed; the amplitude does not count there. at: frictions, whole
    snake, from whose states the others are sought. A gait that is there twice is solved for once.
    """

    def __init__(self, robot: Robot, gaits: Sequence[Gait], seen: Sequence[bool], at: Array):
        self._robot, self._at = robot, at
        pairs = list(zip(gaits, seen, strict=True))
        self._unlike = list(dict.fromkeys(pairs))
        self._column = [self._unlike.index(pair) for pair in pairs]

    def __call__(self, whole: Array, amplitude: Array) -> Array:
        """Return speeds, (K, G), m/s, 0 where the solver finds none.

        So strange frictions are not the answer.
        """
        columns = [
            self._solve([gait if seen else scaled(gait, a) for a in amplitude.tolist()], whole)
            for gait, seen in self._unlike
        ]
        return np.stack(columns, axis=1)[:, self._column]

    def _solve(self, gaits: Sequence[Gait], whole: Sequence[Array] | Array) -> Array:
        links = self._robot.links
        near = ground_of(links, self._at.tolist()), gaits[0]
        draws = [
            (ground_of(links, own.tolist()), gait) for own, gait in zip(whole, gaits, strict=True)
        ]
        return drawn_speeds(self._robot, near, draws, unfound_m_s=0.0)
