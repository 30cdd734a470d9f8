"""Friction parameters at their limit of 0, as of a robot with ball bearings."""

import math

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import setup, stations

SETUP = setup(15.0)


def exact_stations(ct, seed, cn=1.2):
    """Return stations whose inclines follow from the friction law at given speeds."""
    rng, rows = np.random.default_rng(seed), []
    for bend in (0.0, math.radians(15.0)):
        cos, sin = math.cos(bend), math.sin(bend)
        for speed_m_s in (0.2, 0.4, 0.6, 0.8):
            viscous_n = (ct * cos * cos + cn * sin * sin) * speed_m_s
            force_n = viscous_n + 0.14 * cos + 0.27 * sin
            incline = math.asin(force_n / SETUP.weight_n) + math.radians(rng.uniform(-0.05, 0.05))
            rows.append((bend, incline, speed_m_s + 0.02 * rng.normal()))
    return stations(SETUP, rows)


@pytest.fixture(scope="module")
def fits():
    return [sn.fit_friction(exact_stations(0.0, seed)) for seed in range(8)]


def test_a_friction_of_zero_is_found(fits):
    intervals = [fit.intervals["ct"] for fit in fits]
    assert all(low == 0.0 and high > 0.0 for low, high in intervals)  # exactly 0
    values = [fit.parameters["ct"].value for fit in fits]
    assert min(values) == 0.0 < max(values)
    at_limit = fits[values.index(0.0)]
    assert any("ct ends at its limit of 0" in note for note in at_limit.notes)


def test_sigma_interval_and_samples_agree_near_the_limit(fits):
    for fit in fits:
        (value, sigma), (_, high) = fit.parameters["ct"], fit.intervals["ct"]
        assert value + 1.96 * sigma == pytest.approx(high, rel=0.15)
        samples = fit.samples[:, 0]
        assert samples.min() >= 0.0
        # A normal distribution that is truncated at 0 has a little more than 2.5 % above.
        assert 0.015 < np.mean(samples > high) < 0.08
