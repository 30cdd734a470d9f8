"""Rounding that readings share: told from the readings, its statistics, the fit, other worlds."""

import math

import numpy as np
import pytest
from calibration.plain_sessions import World, plain_session
from serpenoid import fit_friction
from serpenoid.calibration.fitting.posterior import Posterior, Unknown
from serpenoid.calibration.friction_result import narrowest

WORLDS = {
    "coarse": World(bends_deg=(7.5, 30.0)),
    "any incline": World(grade=0.0, bends_deg=(30.0,)),
    "a zero that drifts": World(zero_drift_deg=0.3, bends_deg=(7.5, 30.0)),
    "heavy, noisy": World(mass_kg=1.2, ct=0.3, cn=3.0, ft0=0.3, fn0=0.8, speed_sigma=0.03),
}


@pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS)
def test_intervals_hold_the_truth_of_other_worlds(world):
    rng = np.random.default_rng(6)
    held = []
    for _ in range(12):
        ends = np.array(list(fit_friction(plain_session(world, rng)).intervals.values()))
        held.append((ends[:, 0] <= world.truth) & (world.truth <= ends[:, 1]))
    # 12 of a parameter scatter by 6.3 %: they tell a gross error alone
    assert np.mean(held) > 0.85
    assert np.mean(held, axis=0).min() > 0.66


class Mean:
    """One friction that a reading shows but for a normal error and one of the pool."""

    numbers = np.zeros(1, dtype=int)
    unknowns = (Unknown("ct", friction=True), Unknown("rounding 0"))
    pool = ("rounding 0",), np.linspace(-1.0, 1.0, 2001)[:, None] * math.sqrt(3)

    def __init__(self, normal):
        self.normal = normal

    def residuals(self, values):
        return ((values["ct"] + values["rounding 0"] - 100.0) / self.normal)[:, None]

    def near(self, values):
        return self

    def nuisances(self, values):
        return {}


@pytest.mark.parametrize(("normal", "half"), [(0.01, 0.95 * math.sqrt(3)), (50.0, 1.96 * 50.01)])
def test_an_error_that_is_all_rounding_has_a_uniform_interval(normal, half):
    """Of a uniform error, 95 % lie within 0.95 sqrt(3) = 1.645 sigma, not within 1.96."""
    posterior = Posterior((Mean(normal),))
    mode = posterior.mode(np.array([90.0, 0.0]))
    drawn = posterior.draws(mode)
    low, high = narrowest(drawn.x[:, 0], drawn.boundless, float(mode.x[0]))
    assert (high - low) / 2 == pytest.approx(half, rel=0.03)
