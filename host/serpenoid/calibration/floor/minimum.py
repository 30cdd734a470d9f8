"""The least sum of squares of a floor session, from several starts, and whether it is one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...model.errors import BadInput
from ..fitting.data import FitData, Floats, projections
from ..fitting.joint import Minimum
from ..friction_result import Estimate
from .data import FloorData
from .problem import Problem

# How much of a push's force is viscous, in the starts: all but the true one are far off.
SHARES = (0.3, 0.05, 0.8)
ROUNDS = 4  # of frozen spreads; a film's do not change at all
STEPS = 100
_FOLLOWING = 6  # steps of what follows given frictions
OPEN = 0.5  # of the whole force, in error: a friction is then not told


def least(floor: FloorData, stations: FitData | None) -> tuple[Problem, Minimum, bool]:
    """Return the best minimum of some starts, its problem with spreads frozen there.

    And whether it came to rest: in a valley that the readings leave open it does not.
    """
    if stations is not None and floor.ratchet:
        stations = replace(stations, ratchet=True)
    blank = Problem(floor, stations, np.empty(0))
    found: list[tuple[bool, float, Problem, Floats]] = []
    for share in SHARES:
        x = start(blank, share)
        problem, settled = blank.with_spreads(x), False
        for _ in range(ROUNDS):
            x, settled = _descend(problem, x)
            again = problem.with_spreads(x)
            same = np.allclose(again.spreads, problem.spreads, rtol=1e-4)
            problem = again
            if same:
                break
        r = problem.residuals(x)
        # frozen spreads must not be traded for chi2: their logarithms belong to it
        whole = float(r @ r + 2 * np.log(problem.spreads).sum())
        found.append((not settled, whole, problem, x))
    unsettled, _, problem, x = min(found, key=lambda one: one[:2])
    return problem, minimum_at(problem, x), not unsettled


def minimum_at(problem: Problem, x: Floats) -> Minimum:
    """Return residuals, Jacobian and information at some unknowns."""
    r, slopes = problem.residuals(x), problem.jacobian(x)
    return Minimum(x, r, slopes, float(r @ r), slopes.T @ slopes, problem.parameters)


def _descend(problem: Problem, x: Floats) -> tuple[Floats, bool]:
    """Return where Levenberg and Marquardt's steps end, and whether they came to rest.

    On the normal equations, since there are twenty times as many places as unknowns. Unknowns at
    their bound are held there while the slope points beyond it.
    """
    low = problem.lowest
    x = np.maximum(x, low)
    r, damping = problem.residuals(x), 1e-3
    for _ in range(STEPS):
        slopes = problem.jacobian(x)
        gradient, normal = slopes.T @ r, slopes.T @ slopes
        free = (x > low) | (gradient < 0.0)
        while damping < 1e12:
            damped = normal + damping * np.diag(np.diag(normal) + 1e-12)
            step = np.zeros_like(x)
            step[free] = -np.linalg.solve(damped[np.ix_(free, free)], gradient[free])
            tried = np.maximum(x + step, low)
            after = problem.residuals(tried)
            if np.isfinite(after).all() and after @ after <= r @ r:
                break
            damping *= 8.0
        else:
            return x, True  # no step is better
        gained, x, r = float(r @ r - after @ after), tried, after
        damping = max(damping / 10.0, 1e-12)
        if gained < 1e-9 * (1.0 + float(r @ r)):
            return x, True
    return x, False


def start(problem: Problem, share: float) -> Floats:
    """Return unknowns to start from: each push brakes evenly, a share of its force viscous."""
    floor, at = problem.floor, problem.layout
    x = np.zeros(at.count)
    v0, brake = first_speeds(floor)
    x[at.speeds] = v0
    poses = floor.poses
    lam, q = poses.lambda_rad, poses.bent_share
    dry, slope = (1 - share) * brake * floor.mass_kg, share * brake * floor.mass_kg / v0
    by_ct, by_cn, by_ft0, by_fn0 = projections(q, lam)
    ahead = ~poses.back if not poses.back.all() else poses.back
    for first, second, rows, values in (
        (0, 1, (by_ct, by_cn), slope),
        (2, 3, (by_ft0, by_fn0), dry),
    ):
        if floor.pushes:
            each = np.stack(rows, axis=1)[ahead]
            fitted = np.linalg.lstsq(each, values[ahead], rcond=None)[0]
            least_ = 0.1 * float(np.mean(values))
            x[first], x[second] = max(fitted[0], least_), max(fitted[1], least_)
        else:
            x[first], x[second] = (0.2, 1.0) if first == 0 else (0.15, 0.3)
    if at.parameters == 6:
        x[4], x[5] = x[0], x[2]
    return x


def first_speeds(floor: FloorData) -> tuple[Floats, Floats]:
    """Return each push's speed at the start, m/s, and its mean deceleration, m/s^2, roughly."""
    v0, brake = np.full(floor.pushes, 0.5), np.full(floor.pushes, 0.5)
    for k in range(floor.pushes):
        mine = floor.tracks.push == k
        if mine.any():
            t, x = floor.tracks.t_s[mine], floor.tracks.x_m[mine]
            far = x[0] + 0.98 * (x[-1] - x[0])
            moving = max(int(np.searchsorted(x, far)) + 1, 3)
            b, v, _ = np.polyfit(t[:moving], x[:moving], 2)
            v0[k], brake[k] = max(v, 0.05), max(-2 * b, 0.02)
        else:
            mine = floor.rests.push == k
            time, way = float(floor.rests.t_s[mine][0]), float(floor.rests.x_m[mine][0])
            v0[k], brake[k] = 2 * way / time, 2 * way / time**2
    return v0, brake


def covariance_of(problem: Problem, found: Minimum, where: str) -> Floats:
    """Return all unknowns' covariance; raises BadInput where a friction is left open."""
    scale = np.sqrt(np.maximum(np.diag(found.information), 1e-9))
    scaled = found.information / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(scaled)
    covariance = (vectors / np.maximum(values, 1e-14)) @ vectors.T / np.outer(scale, scale)
    _check_told(problem, found.x, np.sqrt(np.diag(covariance)), where)
    return np.asarray(covariance, dtype=np.float64)


def _check_told(problem: Problem, x: Floats, sigma: Floats, where: str) -> None:
    """Raise BadInput if a friction's error is as large as all the force there is."""
    floor = problem.floor
    fast = float(np.max(x[problem.layout.speeds], initial=0.0)) or 0.5
    bent = any(np.any(p.bent_share > 0.0) for p in (floor.poses, floor.slides.poses))
    bent = bent or problem.stations is not None
    pairs = [
        ("ct and ft0", 0, 2, "pushes of the straight robot at 0.9 m/s, both ways, filmed"),
        ("cn and fn0", 1, 3, "pushes in the balanced bend of 42 degrees, both ways, filmed"),
    ]
    if problem.parameters == 6:
        pairs.append(
            ("ct_back and ft0_back", 4, 5, "pushes tail first, straight, both ways, filmed")
        )
    # without any bent reading fn0 is boundless, and ft0 with it where links stand off a little
    for names, cn, fn0, cure in pairs if bent else reversed(pairs):
        force = x[cn] * fast + x[fn0]
        off = max(sigma[cn] * fast, sigma[fn0]) / max(force, 1e-9)
        if not np.isfinite(off) or off > OPEN:
            by = f"are open by {off:.0%} of the force" if off < 1.0 else "stay wholly open"
            raise BadInput(
                f"{where}: {names} cannot be told from {floor.pushes} push(es) and "
                f"{len(floor.slides.time_s)} slide(s): they {by}; take {cure}; or crawls, and "
                "`serpenoid fit --crawls`"
            )


def linear_at(problem: Problem, x: Floats, whole: Floats) -> tuple[Floats, Floats, Estimate]:
    """Return R (5, 4) and r (5,): the readings' chi2 near some frictions, all else let follow.

    It is |R f + r|^2 over frictions f, also where they leave some open. The third is the slope of
    the first place, rad, for these frictions.
    """
    of, x = problem.parameters, x.copy()
    x[:of] = whole
    problem = problem.with_spreads(x)
    for _ in range(_FOLLOWING):
        r, slopes = problem.residuals(x), problem.jacobian(x)
        x[of:] -= np.linalg.lstsq(slopes[:, of:], r, rcond=None)[0]
        x = np.maximum(x, problem.lowest)
    r, slopes = problem.residuals(x), problem.jacobian(x)
    theirs, own = slopes[:, of:], np.column_stack([slopes[:, :of], r - slopes[:, :of] @ whole])
    own -= theirs @ np.linalg.lstsq(theirs, own, rcond=None)[0]
    upper = np.asarray(np.linalg.qr(own, mode="r"), dtype=np.float64)
    k, unit = problem.layout.slopes.start, problem.floor.slope_sigma_rad
    slope = Estimate(0.0, unit)
    if problem.layout.places:
        sigma = float(np.linalg.pinv(theirs.T @ theirs)[k - of, k - of]) ** 0.5
        slope = Estimate(unit * float(x[k]), unit * sigma)
    return upper[:, :of], upper[:, of], slope
