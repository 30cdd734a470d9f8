"""Rounding that readings share: told from the readings, its statistics, the fit, other worlds."""

import math

import numpy as np
import pytest
from calibration.plain_sessions import World, plain_session
from odrpack import odr_fit
from serpenoid.calibration.fitting.posterior import Posterior, Unknown
from serpenoid.calibration.fitting.stations import Stations
from serpenoid.calibration.friction_fit import fit_friction
from serpenoid.calibration.friction_result import NAMES, narrowest


@pytest.mark.parametrize("seed", [1, 2])
def test_the_fit_with_shared_rounding_is_odrpacks(seed):
    world = World(bends_deg=(30.0,))
    made = plain_session(world, np.random.default_rng(seed))
    data, fit = Stations.of(made), fit_friction(made)
    assert (data.rounding >= 0).all()
    count, extra = len(data), len(data.unknowns) - 4
    whiten = np.linalg.inv(data.rounding_root)

    def residuals(x, beta):  # 0 where all is well: speeds are x, nuisances in sigmas
        ct, cn, ft0, fn0, bend, *rounding, zero = beta
        angle = data.lambda_rad + (data.lambda_rad > 0) * data.bends.sigma_rad[0] * bend
        c, s = np.cos(angle), np.sin(angle)
        errors = data.rounding_sigma_rad * np.array(rounding)
        pull = data.weight_n * np.sin(
            data.incline_rad - errors[data.rounding] - data.zero_sigma_rad * zero
        )
        speed = (pull - ft0 * c - fn0 * s) / (ct * c**2 + cn * s**2)
        return np.concatenate([speed, [bend], whiten @ rounding, [zero]])

    found = odr_fit(
        residuals,
        np.zeros(count + extra),
        np.concatenate([data.slip_m_s, np.zeros(extra)]),
        np.concatenate([world.truth, np.zeros(extra)]),
        weight_y=np.concatenate([data.speed_sigma_m_s**-2.0, np.ones(extra)]),
        task="OLS",
        diff_scheme="central",
        sstol=1e-14,
        partol=1e-12,
        maxit=500,
    )
    sigmas = np.sqrt(np.diag(fit.covariance))
    values = np.array([fit.parameters[name].value for name in NAMES])
    # the least chi2 is flat: ODRPACK stops some thousandths of a sigma short
    np.testing.assert_array_less(np.abs(values - found.beta[:4]), 1e-2 * sigmas)
    assert fit.chi2 == pytest.approx(found.sum_square, rel=1e-3)
    cov = found.cov_beta[:4, :4]
    np.testing.assert_allclose(np.sqrt(np.diag(cov)), sigmas, rtol=0.03)


WORLDS = {
    "coarse": World(bends_deg=(7.5, 30.0)),
    "any incline": World(grade=0.0, bends_deg=(30.0,)),
    "light": World(mass_kg=0.25, ct=0.05, cn=0.6, ft0=0.08, fn0=0.2, bends_deg=(30.0,)),
    "a zero that drifts": World(zero_drift_deg=0.3, bends_deg=(7.5, 30.0)),
    "a zero that creeps": World(zero_drift_deg=0.1, bends_deg=(7.5, 30.0)),
    "heavy, noisy": World(mass_kg=1.2, ct=0.3, cn=3.0, ft0=0.3, fn0=0.8, speed_sigma=0.03),
}


@pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS)
@pytest.mark.parametrize(
    ("count", "of_all", "least"),
    [(12, 0.85, 0.66), pytest.param(60, 0.92, 0.86, marks=pytest.mark.slow)],
)
def test_intervals_hold_the_truth_of_other_worlds(world, count, of_all, least):
    rng = np.random.default_rng(6)
    held = []
    for _ in range(count):
        ends = np.array(list(fit_friction(plain_session(world, rng)).intervals.values()))
        held.append((ends[:, 0] <= world.truth) & (world.truth <= ends[:, 1]))
    # 60 of a parameter scatter by 2.8 %, 12 by 6.3 %: those of 12 tell a gross error alone
    assert np.mean(held) > of_all
    assert np.mean(held, axis=0).min() > least


class Mean:
    """One friction that a reading shows but for a normal error and one of the pool."""

    eliminated = 0
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
