"""Hold what a speed's derivatives foretell to what is solved for: rankings of advice, and margins.

python studies/slopes.py advise 60     some five minutes of a core
python studies/slopes.py margins 60    some seconds

advise: sessions in the virtual lab, two readings straight and two bent or as few more as can be
fitted, and a gait drawn at random. Stations are ranked by a regression of sampled speeds, as
`advise` does, and by derivatives. The truth is the band of 256 draws after each station. margins:
robots of 3 to 9 links on ground like that of the 2005 robot.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from advised import PLANS_DEG, opening, planned
from scipy.stats import rankdata
from serpenoid.calibration import advice
from serpenoid.calibration.advising.speed_slopes import SpeedSlopes, speed_slopes
from serpenoid.calibration.advising.stations import places
from serpenoid.calibration.friction_fit import fit_friction
from serpenoid.calibration.friction_result import FrictionFit
from serpenoid.calibration.session import Session
from serpenoid.calibration.speed_samples import sample_speeds
from serpenoid.gaits.margins import gait_margins
from serpenoid.model.gait import Gait
from serpenoid.model.ground import Ground
from serpenoid.model.robot import Robot
from serpenoid.periodic.sensitivities import differentiate
from serpenoid.periodic.servo_steady import band


def random_gait(rng: np.random.Generator) -> Gait:
    """Return a gait that a hobbyist may ask for."""
    alpha, beta, hz = rng.uniform((30.0, 40.0, 0.2), (85.0, 90.0, 1.1)).tolist()
    return Gait(math.radians(alpha), math.radians(beta), math.tau * hz)


def by_derivatives(fit: FrictionFit, gait: Gait) -> SpeedSlopes:
    """Return the slopes of a speed at the fitted friction."""
    found = differentiate(fit.robot, fit.ground, gait)
    elasticity = dict(zip(found.names, found.elasticities().tolist(), strict=True))
    slope = [
        elasticity.get(name, 0.0) * float(found.at[0]) / value if value else 0.0
        for name, value in fit.whole_snake.items()
    ]
    return SpeedSlopes((gait,), found.at[:1], np.array([slope]))


def rank(session: Session, gait: Gait) -> list[float]:
    """Return, of regression and derivatives: rank correlation, loss by the first, seconds."""
    fit = fit_friction(session)
    whole = np.array(list(fit.whole_snake.values()))
    bends = [math.radians(bend) for bend in advice.LAMBDAS_DEG]
    every = places(session, whole, bends)
    ways: list[Callable[[], SpeedSlopes]] = [
        lambda: speed_slopes(fit, [gait], 48),
        lambda: by_derivatives(fit, gait),
    ]
    told, seconds = [], []
    for way in ways:
        begun = time.process_time()
        slopes = way()
        seconds.append(time.process_time() - begun)
        told.append([advice._station(session, whole, (slopes, [[]]), at) for at in every])
    true = []
    for reading in told[0]:
        after = advice._after(session, fit, replace(reading, times=1))
        assert after is not None  # it is a station
        low, high = band(sample_speeds(after, [gait], count=256).friction_m_s[:, 0])
        true.append(high - low)
    bands = [np.array([reading.band for reading in readings]) for readings in told]
    alike = [float(np.corrcoef(rankdata(own), rankdata(true))[0, 1]) for own in bands]
    lost = [true[int(own.argmin())] / min(true) - 1.0 for own in bands]
    return [*alike, *lost, *seconds, float(bands[0].argmin() == bands[1].argmin())]


def rankings(count: int) -> None:
    """Print how good both rankings are."""
    rows = []
    for number in range(count):
        rng = np.random.default_rng([7, number])
        session = opening(planned(list(PLANS_DEG)[number % len(PLANS_DEG)], number)[0])
        rows.append(rank(session, random_gait(rng)))
    told = np.array(rows)
    print(f"{count} sessions; the same first station in {told[:, 6].sum():.0f}")
    for k, name in enumerate(("regression", "derivatives")):
        alike, lost, seconds = told[:, k], told[:, 2 + k], told[:, 4 + k]
        print(
            f"{name}: rank correlation {np.median(alike):.2f}; the band after the first is wider "
            f"than after the best by {lost.mean():.1%} in the mean, {lost.max():.0%} at most; "
            f"{1e3 * np.median(seconds):.0f} ms"
        )


def margins(count: int) -> None:
    """Print how far margins are from those that derivatives foretell, and what both cost."""
    rng, rows, seconds = np.random.default_rng(4), [], []
    while len(rows) < count:
        robot = Robot(int(rng.integers(3, 10)), 0.0756, 0.076)
        values = (np.array([0.014, 0.2, 0.0233, 0.045]) * np.exp(0.4 * rng.normal(size=4))).tolist()
        ground, gait = Ground(*values), random_gait(rng)
        begun = time.process_time()
        true = gait_margins(robot, ground, gait)
        middle = time.process_time()
        found = differentiate(robot, ground, gait)
        seconds.append((middle - begun, time.process_time() - middle))
        elasticity = dict(zip(found.names, found.elasticities().tolist(), strict=True))
        told = [0.1 / max(elasticity[name], 1e-9) for name in ("alpha_rad", "fn0")]
        rows.append((true.amplitude, told[0], true.grip, told[1]))
    each = np.array(rows)
    for k, name in ((0, "amplitude"), (2, "fn0")):
        has = np.isfinite(each[:, k])
        true, told = each[has, k], each[has, k + 1]
        print(
            f"{name}: {has.sum()} of {count} have a margin below 60 %; derivatives tell it to a "
            f"fifth in {(abs(told / true - 1) < 0.2).sum()}, none in {(told > 0.6).sum()}"
        )
    print("ms: margins {:.0f}, all derivatives {:.0f}".format(*1e3 * np.median(seconds, axis=0)))


if __name__ == "__main__":
    (rankings if sys.argv[1] == "advise" else margins)(int(sys.argv[2]))
