"""Frictions of 0: a robot on ball bearings is a truth, and an answer."""

import math

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import setup, stations

SETUP = setup(15.0)


def held(ct, seed, cn=1.2):
    """Return stations at given speeds, whose inclines the law gives, by plain formulas."""
    rng, rows = np.random.default_rng(seed), []
    for bend in (0.0, math.radians(15.0)):
        c, s = math.cos(bend), math.sin(bend)
        for v in (0.2, 0.4, 0.6, 0.8):
            pull = (ct * c * c + cn * s * s) * v + 0.14 * c + 0.27 * s
            incline = math.asin(pull / SETUP.weight_n) + math.radians(rng.uniform(-0.05, 0.05))
            rows.append((bend, incline, v + 0.02 * rng.normal()))
    return stations(SETUP, rows)


@pytest.fixture(scope="module")
def fits():
    return [sn.fit_friction(held(0.0, seed)) for seed in range(8)]


def test_ball_bearings_are_an_answer(fits):
    held = [fit.intervals["ct"] for fit in fits]
    assert all(low == 0.0 and high > 0.0 for low, high in held)  # 0 itself, no 1e-9
    values = [fit.parameters["ct"].value for fit in fits]
    assert min(values) == 0.0 < max(values)
    at_limit = fits[values.index(0.0)]
    assert any("ct ends at its limit of 0" in note for note in at_limit.notes)


def test_sigma_interval_and_draws_tell_the_same_beside_the_limit(fits):
    for fit in fits:
        (value, sigma), (_, high) = fit.parameters["ct"], fit.intervals["ct"]
        assert value + 1.96 * sigma == pytest.approx(high, rel=0.15)
        drawn = fit.samples[:, 0]
        assert drawn.min() >= 0.0
        # a normal distribution that is cut at 0 has a little more above
        assert 0.015 < np.mean(drawn > high) < 0.08
