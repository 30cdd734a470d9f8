"""Rounding errors of an inclinometer that readings share.

An inclinometer with the resolution g rounds the same incline the same way every time. On a
treadmill whose incline has steps of h the error at set point k is a sawtooth, e_k = g saw(phi +
k p), with p = h / g and an unknown phase phi. So a set point that is read twice has the same error
twice, and the errors of neighbouring set points may rise together. Independent errors would give
ct and cn too small uncertainties.

The errors are sampled with phi uniform and h normal, since it is known to 1 % only. The fit takes
their correlation from the samples, and their bounds too, since a sawtooth has no tails.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .parameters import Floats, Integers

GOLDEN_RATIO = (5**0.5 - 1) / 2  # Its multiples modulo 1 are spread evenly.


@dataclass(frozen=True)
class Steps:
    """Tolerances by which the steps of treadmill and inclinometer are recognised.

    sigma: relative standard deviation of the treadmill's step. min_ratio: smallest ratio of the
    treadmill's step to the inclinometer's for which set points can be told apart. on_grid: largest
    distance of a reading from the inclinometer's grid, in its steps. slack: largest distance of a
    reading from a set point beyond the rounding, in the inclinometer's steps. trials: number of
    offsets tried for the treadmill's grid. samples: number of samples of the errors.
    """

    sigma: float = 0.01
    min_ratio: float = 1.5
    on_grid: float = 0.02
    slack: float = 0.1
    trials: int = 256
    samples: int = 1024


STEPS = Steps()


def shown_step_rad(shown_rad: Floats, sigma_rad: float) -> float | None:
    """Return the inclinometer's step, rad, if the readings are its multiples; else None.

    shown_rad: (readings,). sigma_rad: the stated standard deviation g / sqrt(12) of a step g. It
    may have been rounded to one digit, such as 0.03 for a step of 0.1 degrees.
    """
    exact = float(np.degrees(sigma_rad)) * np.sqrt(12.0)
    for step in (exact, float(f"{exact:.0e}")):
        steps = np.degrees(shown_rad) / step
        if np.abs(steps - np.round(steps)).max() < STEPS.on_grid:
            return float(np.radians(step))
    return None


def set_points(
    shown_rad: Floats, sigma_rad: float, grade_step: float
) -> tuple[float, Integers] | None:
    """Return the inclinometer's step, rad, and the treadmill's step number of each reading.

    grade_step: the treadmill's step, as a tangent of the incline. The step numbers count from an
    arbitrary incline. None if the readings are not multiples of the inclinometer's step, or if the
    treadmill's steps do not explain them.
    """
    step_rad = shown_step_rad(shown_rad, sigma_rad) if len(shown_rad) else None
    if step_rad is None or grade_step < STEPS.min_ratio * step_rad:
        return None
    grade = np.tan(shown_rad)[:, None] - grade_step * np.arange(STEPS.trials) / STEPS.trials
    nearest = np.round(grade / grade_step)
    distance = np.abs(grade - nearest * grade_step).max(axis=0)
    best = int(distance.argmin())
    if distance[best] > (0.5 + STEPS.slack) * step_rad + grade_step / STEPS.trials:
        return None
    return step_rad, nearest[:, best].astype(np.intp)


def _phases(set_point: Integers, step_rad: float, grade_step: float) -> tuple[Floats, Floats]:
    """Return samples of the true inclines at the first set point, and at all set points.

    Their shapes are (samples,) and (samples, points); their unit is the inclinometer's step.
    """
    from scipy.special import ndtri

    number = np.arange(STEPS.samples)
    first_phase = (number + 0.5) / STEPS.samples
    scale = 1.0 + STEPS.sigma * ndtri((number * GOLDEN_RATIO + 0.5) % 1.0)
    incline = scale[:, None] * np.arctan(grade_step * set_point) / step_rad
    return first_phase, first_phase[:, None] + incline - incline[:, :1]


def shared_rounding(
    shown_rad: Floats, sigma_rad: float, grade_step: float
) -> tuple[Integers, Floats]:
    """Return the index (readings,) of each reading's rounding error, and the errors' samples, rad.

    The samples are (samples, errors). Readings of one set point that show the same incline share an
    error. If a set point shows several inclines, the treadmill does not hold it exactly, and each
    gets an independent error. All indices are -1 if the readings are not multiples of the
    inclinometer's step, or not at the treadmill's set points.
    """
    grid = set_points(shown_rad, sigma_rad, grade_step)
    if grid is None:
        return np.full(len(shown_rad), -1, dtype=np.intp), np.empty((STEPS.samples, 0))
    step_rad, points = grid
    shown = np.round(shown_rad / step_rad).astype(np.intp)
    pairs = np.column_stack([points, shown])
    groups, index = np.unique(pairs, axis=0, return_inverse=True)
    first_phase, phase = _phases(groups[:, 0], step_rad, grade_step)
    repeats_point = np.diff(groups[:, 0]) == 0
    for group in np.flatnonzero(repeats_point) + 1:
        phase[:, group] = np.random.default_rng(group).permutation(first_phase)
    errors = step_rad * (np.round(phase) - phase)
    order = np.random.default_rng(0).permutation(STEPS.samples)
    return index.astype(np.intp).ravel(), errors[order]


def nearest_shown(
    wanted_rad: float, shown_rad: Floats, sigma_rad: float, grade_step: float
) -> float:
    """Return the incline, rad, that the inclinometer will show at the nearest set point.

    wanted_rad: the wanted incline. shown_rad: (readings,) so far, which determine the treadmill's
    set points. If they determine none, the result is wanted_rad itself.
    """
    grid = set_points(shown_rad, sigma_rad, grade_step)
    if grid is None:
        return wanted_rad
    step_rad, points = grid
    offsets = np.tan(shown_rad) - grade_step * points
    middle = float(offsets.max() + offsets.min()) / 2
    point = np.round((np.tan(wanted_rad) - middle) / grade_step)
    same = np.flatnonzero(points == point)
    if len(same):
        latest = same[-1]
        return float(shown_rad[latest])
    steps = np.round(np.arctan(grade_step * point + middle) / step_rad)
    return float(steps * step_rad)
