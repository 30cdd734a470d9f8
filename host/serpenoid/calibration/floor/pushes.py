"""What every push and slide does to a floor fit: block by block, by one linear step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..fitting.data import Floats
from ..fitting.joint import Minimum
from ..fitting.rolling_law import way_m
from .problem import Problem


@dataclass(frozen=True)
class PushFigures:
    """Per reading, the pushes first, then slides, then stations; and chi2 of their agreement.

    A push that is followed tells a c and f of its own (`law`); how its places scatter about that
    path is its own affair. Judged is how far the common frictions move it from there: two degrees
    of freedom a push, one where only its rest is known, or a slide. chi2, dof: of all that, priors
    in it. residuals: of each, in standard deviations, + where it rolled farther than the law.
    studentised, shift (of the frictions), chi2_without, leverage: with the reading left out.
    """

    numbers: tuple[int, ...]
    chi2: float
    dof: int
    residuals: Floats
    studentised: Floats
    shift: Floats
    chi2_without: Floats
    leverage: Floats


@dataclass(frozen=True)
class _Block:
    """The rows of one reading, how many numbers it tells, and the unknowns that are its alone."""

    rows: NDArray[np.intp]
    tells: int
    alone: tuple[int, ...]
    free: Floats | None = None  # (rows, 4): by v0, x0, c and f of its own


def figures_of(problem: Problem, found: Minimum, covariance: Floats) -> PushFigures:
    """Return the figures at a minimum."""
    blocks, of = _blocks(problem, found), problem.parameters
    off = [found.residuals[b.rows] for b in blocks]
    told = [_told(b, r) for b, r in zip(blocks, off, strict=True)]
    own = np.array([float(r @ r) - t for r, t in zip(off, told, strict=True)])
    chi2 = found.chi2 - float(own.sum())
    tells = np.array([b.tells for b in blocks])
    left = [_without(found, covariance, b, of) for b in blocks]
    without = np.array([one[0] for one in left]) - (own.sum() - own)
    signs = np.array([_sign(b, r) for b, r in zip(blocks, off, strict=True)])
    stations = 0 if problem.stations is None else len(problem.stations)
    return PushFigures(
        numbers=problem.floor.numbers,
        chi2=chi2,
        dof=int(tells.sum()) + stations - of,
        residuals=signs * np.sqrt(np.array(told) / tells),
        studentised=signs * _normal(np.maximum(chi2 - without, 0.0), tells),
        shift=np.array([one[1] for one in left]).reshape(len(blocks), of),
        chi2_without=without,
        leverage=np.array([one[2] for one in left]),
    )


def _blocks(problem: Problem, found: Minimum) -> list[_Block]:
    """Return the blocks in the order of the readings' numbers."""
    floor, at = problem.floor, problem.layout
    ways, resting, stopping, sliding = problem.rows
    c, f, _, _ = problem.motion(found.x)
    v0 = found.x[at.speeds]
    blocks = []
    for k in range(floor.pushes):
        alone = (at.speeds.start + k, at.starts.start + k)
        mine = np.flatnonzero(floor.tracks.push == k)
        if len(mine):
            one = np.ones(len(mine))
            slopes = way_m(floor.tracks.t_s[mine], v0[k] * one, c[k] * one, f[k] * one)[1]
            free = np.stack([slopes[0], one, slopes[1], slopes[2]], axis=1)
            rows = ways.start + mine
            blocks.append(_Block(rows, 2, alone, free / problem.spreads[rows, None]))
        else:
            rest = int(np.flatnonzero(floor.rests.push == k)[0])
            rows = np.array([resting.start + rest, stopping.start + rest])
            blocks.append(_Block(rows, 1, alone))
    return blocks + [_Block(np.array([row]), 1, ()) for row in range(sliding.start, sliding.stop)]


def _told(block: _Block, off: Floats) -> float:
    """Return how much of a block's chi2 a path of its own would take away."""
    if block.free is None:
        return float(off @ off)
    fitted = block.free @ np.linalg.lstsq(block.free, off, rcond=None)[0]
    return float(fitted @ fitted)


def _sign(block: _Block, off: Floats) -> float:
    """Return + where the robot went farther, or took less time, than the law says."""
    by_force = off[0] if block.free is None else block.free[:, 3] @ off
    return float(np.copysign(1.0, -by_force if len(off) == 2 and block.free is None else by_force))


def _without(
    found: Minimum, covariance: Floats, block: _Block, of: int
) -> tuple[float, Floats, float]:
    """Return chi2, the frictions' shift and this reading's leverage, with it left out."""
    slopes, off = found.jacobian[block.rows], found.residuals[block.rows]
    information = found.information - slopes.T @ slopes
    alone = list(block.alone)
    information[alone, :] = information[:, alone] = 0.0
    information[alone, alone] = 1.0
    pull = slopes.T @ off
    pull[alone] = 0.0
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    try:
        rest = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    except np.linalg.LinAlgError:
        return found.chi2, np.zeros(of), 1.0
    kept = np.diag(covariance)[:of] / np.maximum(np.diag(rest)[:of], 1e-300)
    if not np.isfinite(rest).all() or np.diag(rest).min() <= 0.0 or kept.min() < 1e-9:
        return found.chi2, np.zeros(of), 1.0
    chi2 = found.chi2 - float(off @ off) - float(pull @ rest @ pull)
    return chi2, (rest @ pull)[:of], float(np.clip(1.0 - kept.min(), 0.0, 1.0))


def _normal(chi2: Floats, dof: NDArray[np.intp]) -> Floats:
    """Return the normal deviate that is as rare as a chi2."""
    from scipy.special import chdtrc, ndtri

    return -ndtri(np.maximum(chdtrc(dof, chi2), 1e-300) / 2)
