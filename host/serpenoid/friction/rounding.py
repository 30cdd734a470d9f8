"""What an inclinometer's rounding has in common between readings.

An inclinometer that shows steps of g rounds the same incline the same way every time, and inclines
that are a treadmill's step h apart round in a pattern: with p = h / g the error runs through a
sawtooth, e_k = g saw(phi + k p), and only phi is anybody's guess. So a set point that is read again
has the same error again, and a series' errors may rise and fall together: taken for independent
they would make ct and cn look better known than they are.

So phi is drawn evenly, and h, known to a hundredth alone, as a normal distribution. What the errors
then have in common is their correlation; how far they may reach together is told by the samples
themselves, for sawteeth have no tails.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .parameters import Floats, Integers

GOLDEN_RATIO = (5**0.5 - 1) / 2  # whose multiples are spread evenly


@dataclass(frozen=True)
class Steps:
    """How steps of treadmill and inclinometer are recognised.

    sigma: of a treadmill's step, relative. min_ratio: of it to the inclinometer's; below, set
    points cannot be told apart. on_grid, slack: in the inclinometer's steps, that a reading may be
    off one, and off a set point. trials: phases of the treadmill's steps. samples: of the errors.
    """

    sigma: float = 0.01
    min_ratio: float = 1.5
    on_grid: float = 0.02
    slack: float = 0.1
    trials: int = 256
    samples: int = 1024


STEPS = Steps()


def shown_step_rad(shown_rad: Floats, sigma_rad: float) -> float | None:
    """Return the inclinometer's step, if its readings lie on such steps; else None.

    A step of g has the standard deviation g / sqrt(12); one that was rounded when it was written
    down, say 0.03 for 0.1 degrees, is recognised.
    """
    exact = float(np.degrees(sigma_rad)) * np.sqrt(12.0)
    for step in (exact, float(f"{exact:.0e}")):
        steps = np.degrees(shown_rad) / step
        if np.abs(steps - np.round(steps)).max() < STEPS.on_grid:
            return float(np.radians(step))
    return None


def set_points(shown_rad: Floats, step_rad: float, grade_step: float) -> Integers | None:
    """Return which of its steps the treadmill stood at, from any one; None where it had none."""
    if grade_step < STEPS.min_ratio * step_rad:
        return None
    grade = np.tan(shown_rad)[:, None] - grade_step * np.arange(STEPS.trials) / STEPS.trials
    nearest = np.round(grade / grade_step)
    distance = np.abs(grade - nearest * grade_step).max(axis=0)
    best = int(distance.argmin())
    if distance[best] > (0.5 + STEPS.slack) * step_rad + grade_step / STEPS.trials:
        return None
    return nearest[:, best].astype(np.intp)


def _phases(set_point: Integers, step_rad: float, grade_step: float) -> tuple[Floats, Floats]:
    """Return the first point's phases (samples,), and those of all, (samples, points), in steps."""
    from scipy.special import ndtri

    even = (np.arange(STEPS.samples) + 0.5) / STEPS.samples
    scale = 1.0 + STEPS.sigma * ndtri((np.arange(STEPS.samples) * GOLDEN_RATIO + 0.5) % 1.0)
    true = scale[:, None] * np.arctan(grade_step * set_point) / step_rad
    return even, even[:, None] + true - true[:, :1]


def shared_rounding(
    shown_rad: Floats, sigma_rad: float, grade_step: float
) -> tuple[Integers, Floats]:
    """Return which shared rounding error each reading has (-1: none), and samples of them, rad.

    The samples are (samples, errors). Readings of one set point that showed the same share an
    error; where one showed now this, now that, it is not held exactly, and goes with no other. None
    is shared where the readings do not lie on the inclinometer's steps, or not on the treadmill's:
    then nothing tells that their errors go together.
    """
    none_shared = np.full(len(shown_rad), -1, dtype=np.intp), np.empty((STEPS.samples, 0))
    step_rad = shown_step_rad(shown_rad, sigma_rad) if len(shown_rad) else None
    points = None if step_rad is None else set_points(shown_rad, step_rad, grade_step)
    if step_rad is None or points is None:
        return none_shared
    shown = np.round(shown_rad / step_rad).astype(np.intp)
    groups, index = np.unique(np.column_stack([points, shown]), axis=0, return_inverse=True)
    even, phase = _phases(groups[:, 0], step_rad, grade_step)
    for k in np.flatnonzero(np.diff(groups[:, 0]) == 0) + 1:
        phase[:, k] = np.random.default_rng(k).permutation(even)
    errors = step_rad * (np.round(phase) - phase)
    return index.astype(np.intp).ravel(), errors[
        np.random.default_rng(0).permutation(STEPS.samples)
    ]


def nearest_shown(
    wanted_rad: float, shown_rad: Floats, sigma_rad: float, grade_step: float
) -> float:
    """Return what the inclinometer is likely to show at the treadmill's step nearest to an incline.

    shown_rad: so far, which tell how the treadmill's steps lie. The incline itself where nothing is
    known of steps.
    """
    step_rad = shown_step_rad(shown_rad, sigma_rad) if len(shown_rad) else None
    points = None if step_rad is None else set_points(shown_rad, step_rad, grade_step)
    if step_rad is None or points is None:
        return wanted_rad
    offsets = np.tan(shown_rad) - grade_step * points
    middle = float(offsets.max() + offsets.min()) / 2
    grade = grade_step * np.round((np.tan(wanted_rad) - middle) / grade_step)
    same = np.flatnonzero(points == np.round(grade / grade_step))
    if len(same):
        return float(shown_rad[same[-1]])
    return float(np.round(np.arctan(grade + middle) / step_rad) * step_rad)
