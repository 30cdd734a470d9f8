"""Speeds of crawls on many grounds: each state is sought from a neighbour's, on all processors.

Films of one commanded gait show the same joints, off by what they err by. So these films share a
state, that of their mean joints. The ratio of their speeds to its speed is solved for once. On a
ground some per cent away it is another by some 1e-4, and the opposite for the other film.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...model.gait import Gait
from ...model.robot import Robot
from ...periodic.drawn_states import drawn_speeds
from ..friction_result import ground_of
from ..speed_samples import scaled
from .runs import same_gait

Array = NDArray[np.float64]
Speeds = Callable[[Array, Array], Array]  # (K, 4) frictions, (K,) amplitudes -> (K, gaits), m/s
_ALIKE = 0.02  # of gain, or rad of shift: films whose joints differ by more have their own states


class SpeedSolver:
    """Predict the speeds of G gaits of a robot whose joints follow them.

    seen: gaits whose joints a film showed; the amplitude does not count there. asked: gaits as
    commanded. at: frictions, whole snake, from whose states the others are sought. near: all that
    will be asked for are so near to these that films of one gait can share a state.
    """

    def __init__(
        self,
        robot: Robot,
        gaits: Sequence[Gait],
        seen: Sequence[bool],
        asked: Sequence[Gait],
        at: Array,
        near: bool,
    ):
        self._robot, self._at = robot, at
        groups = _groups(gaits, seen, asked) if near else [[k] for k in range(len(gaits))]
        self._group = np.array(
            [next(k for k, g in enumerate(groups) if i in g) for i in range(len(gaits))],
            dtype=np.intp,
        )
        self._gaits = [_mean([gaits[i] for i in group]) for group in groups]
        self._seen = [seen[group[0]] for group in groups]
        self._ratio = np.ones(len(gaits))
        for group, mean in zip(groups, self._gaits, strict=True):
            if len(group) > 1:
                found = self._solve([*(gaits[i] for i in group), mean], [at] * (len(group) + 1))
                self._ratio[group] = found[:-1] / max(found[-1], 1e-300) if found.all() else 1.0

    def __call__(self, whole: Array, amplitude: Array) -> Array:
        """Return speeds, (K, G), m/s, 0 where the solver finds none.

        So strange frictions are not the answer.
        """
        columns = [
            self._solve([gait if seen else scaled(gait, a) for a in amplitude.tolist()], whole)
            for gait, seen in zip(self._gaits, self._seen, strict=True)
        ]
        return np.stack(columns, axis=1)[:, self._group] * self._ratio

    def _solve(self, gaits: Sequence[Gait], whole: Sequence[Array] | Array) -> Array:
        links = self._robot.links
        near = ground_of(links, self._at.tolist()), gaits[0]
        draws = [
            (ground_of(links, own.tolist()), gait) for own, gait in zip(whole, gaits, strict=True)
        ]
        return drawn_speeds(self._robot, near, draws, unfound_m_s=0.0)


def _groups(gaits: Sequence[Gait], seen: Sequence[bool], asked: Sequence[Gait]) -> list[list[int]]:
    """Return the gaits' indices, together where films show the same joints in the same gait."""
    groups: list[list[int]] = []
    for k, gait in enumerate(gaits):
        same = [
            group
            for group in groups
            if seen[k]
            and all(
                seen[i] and same_gait(asked[i], asked[k]) and _alike(gaits[i], gait) for i in group
            )
        ]
        if same:
            same[0].append(k)
        else:
            groups.append([k])
    return groups


def _alike(one: Gait, other: Gait) -> bool:
    joints = max(len(one.joint_gain), len(other.joint_gain), 1)
    each, others = (np.array(g.joint_factors(joints)) for g in (one, other))
    alike = (
        replace(
            other,
            joint_gain=one.joint_gain,
            joint_shift_rad=one.joint_shift_rad,
            omega_rad_s=one.omega_rad_s,
            offset_rad=one.offset_rad,
        )
        == one
    )
    apart = [
        np.abs(each - others).max(),
        abs(one.omega_rad_s / other.omega_rad_s - 1.0),
        abs(one.offset_rad - other.offset_rad),
    ]
    return alike and max(apart) < _ALIKE


def _mean(gaits: Sequence[Gait]) -> Gait:
    """Return the gait of the mean joints."""
    if len(gaits) == 1:
        return gaits[0]
    joints = max(len(gait.joint_gain) for gait in gaits)
    gain, shift = np.mean([gait.joint_factors(joints) for gait in gaits], axis=0)
    return replace(
        gaits[0],
        omega_rad_s=float(np.mean([g.omega_rad_s for g in gaits])),
        offset_rad=float(np.mean([g.offset_rad for g in gaits])),
        joint_gain=tuple(gain.tolist()),
        joint_shift_rad=tuple(shift.tolist()),
    )
