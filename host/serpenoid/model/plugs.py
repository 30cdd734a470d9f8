"""Which servo moves which joint, and which way: told from the phases of the joints' sines."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from ..base.vectors import Array

EXPLAINED_RAD = math.radians(12.0)  # phases this near to even steps are a gait's


def even_steps(phase: Array, step: float | None) -> tuple[float, float]:
    """Return the step that explains phases best, and what is left (rms), rad."""
    order = np.arange(len(phase))
    tried = np.radians(np.arange(-180.0, 180.0, 0.5)) if step is None else np.array([step])
    left = np.exp(1j * (phase[None] - tried[:, None] * order))
    middle = np.angle(left.mean(axis=1))[:, None]
    rms = np.sqrt(np.mean(np.angle(left * np.exp(-1j * middle)) ** 2, axis=1))
    best = int(rms.argmin())
    return float(tried[best]), float(rms[best])


def plugs(phase: Array, step: float | None) -> tuple[list[int], list[int], float]:
    """Return the order of plugs, the reversed joints, and the rest, that explain the phases.

    The fewest faults count: none, one or two reversed joints, one pair of swapped plugs, one of
    both. step: of the commanded gait, None if it is not known.
    """
    n = len(phase)
    straight = list(range(n))
    pairs = list(combinations(range(n), 2))
    swaps = [straight, *([{a: b, b: a}.get(k, k) for k in straight] for a, b in pairs)]
    turns = [(), *combinations(range(n), 1), *pairs]
    tried = [(len(t) + 2 * (s != straight), s, t) for s in swaps for t in turns]
    for cost, swap, turn in sorted(tried, key=lambda fault: fault[0]):
        if cost > max(1, n // 2):
            break
        seen = phase.copy()
        seen[list(turn)] += math.pi
        rest = even_steps(seen[swap], step)[1]
        if rest < EXPLAINED_RAD:
            return swap, list(turn), rest
    return straight, [], even_steps(phase, step)[1]
