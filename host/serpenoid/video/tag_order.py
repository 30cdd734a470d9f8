"""Whether the tags stand along the robot in the order of their numbers."""

from __future__ import annotations

import itertools

import numpy as np

from ..model.errors import BadInput


def refuse_mixed_tags(measured_poses: tuple[np.ndarray, np.ndarray], name: str) -> None:
    """Raise BadInput where tags stand in another order than their numbers."""
    centres, _ = measured_poses
    n = centres.shape[1]
    apart = np.full((n, n), np.inf)
    for i in range(n):
        for j in range(n):
            gaps = np.linalg.norm(centres[:, i] - centres[:, j], axis=-1)
            gaps = gaps[np.isfinite(gaps)]
            if i != j and len(gaps) >= 3:
                apart[i, j] = gaps.mean()
    if not np.isfinite(apart[np.triu_indices(n, 1)]).all():
        return
    order = _shortest_way(apart)
    if order in (list(range(n)), list(range(n))[::-1]):
        return
    if order[0] > order[-1]:
        order = order[::-1]
    own = _way_length(apart, list(range(n)))
    if own > 1.1 * _way_length(apart, order):
        told = ", ".join(str(k + 1) for k in order)
        raise BadInput(
            f"{name}: the tags stand in the order {told} along the robot; number 1 "
            "belongs on the tail, then 2, 3, ...: put them on anew"
        )


def _way_length(apart: np.ndarray, order: list[int]) -> float:
    return float(sum(apart[a, b] for a, b in itertools.pairwise(order)))


def _shortest_way(apart: np.ndarray) -> list[int]:
    """Return the order of the shortest way through all tags: nearest first, then 2-opt."""
    n = len(apart)
    best: list[int] = []
    for first in range(n):
        way = [first]
        while len(way) < n:
            rest = [k for k in range(n) if k not in way]
            way.append(min(rest, key=lambda k: apart[way[-1], k]))
        way = _untangled(apart, way)
        if not best or _way_length(apart, way) < _way_length(apart, best):
            best = way
    return best


def _untangled(apart: np.ndarray, way: list[int]) -> list[int]:
    n, better = len(way), True
    while better:
        better = False
        for i in range(n - 1):
            for j in range(i + 1, n):
                tried = way[:i] + way[i : j + 1][::-1] + way[j + 1 :]
                if _way_length(apart, tried) < _way_length(apart, way) - 1e-12:
                    way, better = tried, True
    return way
