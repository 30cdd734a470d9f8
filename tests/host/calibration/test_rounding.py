"""Rounding that readings share: told from the readings, its statistics, the fit, other worlds."""

import math

import numpy as np
import pytest
from calibration.plain_sessions import World, plain_session
from serpenoid import fit_friction
from serpenoid.friction.parameters import FRICTION_PARAMETERS, Parameter
from serpenoid.friction.posterior import Posterior, RoundingErrors
from serpenoid.friction.result import narrowest

WORLDS = {
    "coarse": World(bends_deg=(7.5, 30.0)),
    "any incline": World(grade=0.0, bends_deg=(30.0,)),
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


class Frictions:
    """Frictions that readings show but for a normal error, and ct but for a rounding, too."""

    numbers = np.arange(4)
    parameters = (*FRICTION_PARAMETERS, Parameter("rounding 0", sigma=1.0))

    def __init__(self, normal):
        self.normal = normal

    def residuals(self, values):
        shown = [values[name] - 100.0 for name in ("ct", "cn", "ft0", "fn0")]
        shown[0] = shown[0] + values["rounding 0"]
        return np.stack(shown, axis=1) / self.normal

    def linear_about(self, values):
        return self


@pytest.mark.parametrize(("normal", "half"), [(0.01, 0.95 * math.sqrt(3)), (50.0, 1.96 * 50.01)])
def test_an_error_that_is_all_rounding_has_a_uniform_interval(normal, half):
    """Of a uniform error, 95 % lie within 0.95 sqrt(3) = 1.645 sigma, not within 1.96."""
    evenly = np.linspace(-1.0, 1.0, 2001)[:, None] * math.sqrt(3)
    posterior = Posterior((Frictions(normal),), RoundingErrors(("rounding 0",), evenly))
    estimate = posterior.estimate(posterior.start([90.0] * 4))
    samples = posterior.samples(estimate, 1)
    low, high = narrowest(samples.x[:, 0], samples.unlimited, float(estimate.x[0]))
    assert (high - low) / 2 == pytest.approx(half, rel=0.03)
