"""Comparison of measured with predicted speeds: the p-value, the factors, what is not judged."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import WHOLE_BODY_2005, session, setup
from refusals import refused
from robots import BINGHAM
from serpenoid.prediction import comparison
from serpenoid.prediction.band import speed_band
from serpenoid.prediction.verdict import Predicted
from serpenoid.session.gait_run import GaitRun

RATES = [2 * math.pi * hz for hz in (0.25, 0.5, 1.0)]


def gait(rate, amplitude=1.0):
    return sn.Gait(math.radians(70) * amplitude, math.radians(75), rate)


@pytest.fixture(scope="module")
def fitted():
    """Return a session whose runs are on level ground, and its fit."""
    level = setup(30.0)
    tools = replace(level.instruments, floor_slope_sigma_deg=math.degrees(1e-5))
    level = replace(level, instruments=tools)
    made = session(level, WHOLE_BODY_2005, np.random.default_rng(31))
    return made, sn.fit_friction(made)


def measured(made, amplitude=1.0, factor=1.0):
    """Return the session with one run of each gait, as joints of this amplitude would run it."""
    runs = list(made.readings)
    for k, rate in enumerate(RATES):
        v = sn.steady_gait(made.setup.robot, BINGHAM, gait(rate, amplitude), rtol=1e-3).speed_m_s
        g = gait(rate)
        runs.append(GaitRun(g.alpha_rad, g.beta_rad, rate, factor * v, 0.01 * v, number=100 + k))
    return replace(made, readings=tuple(runs))


def test_speeds_as_predicted_agree(fitted):
    made, fit = fitted
    found = comparison.compare(measured(made), fit, samples=24, servo=None)
    assert found.verdict == "agrees"
    assert found.verdict_text.startswith("Agrees: the speeds of 3 gaits are likely enough ")
    assert (found.friction, found.amplitude) == (None, None)
    assert [p.runs for p in found.gaits] == [(100,), (101,), (102,)]
    for shown in found.gaits:  # the paper's own comparison
        assert 0.0 < shown.implicit_error_m_s < 0.01 * shown.implicit_m_s
    json.dumps(found.to_dict(), allow_nan=False)


def test_a_chance_of_one_in_fifty_is_a_difference(fitted):
    made, fit = fitted
    found = comparison.compare(measured(made, factor=1.08), fit, samples=24, servo=None)
    assert 1e-3 < found.p_value < 0.05
    assert found.verdict == "differs"


def test_the_factor_on_amplitude_that_explains_the_speeds_is_told(fitted):
    made, fit = fitted
    found = comparison.compare(measured(made, 0.85), fit, samples=24, servo=None)
    assert found.verdict == "differs"
    assert found.p_value < 0.05 < found.amplitude.p_value
    assert found.amplitude.factor == pytest.approx(0.86, abs=0.03)
    assert found.friction.p_value < 0.05
    assert found.verdict_text.startswith("Differs: the largest difference from the prediction ")
    assert "explained by joints that reach 8" in found.verdict_text
    assert "friction times" not in found.verdict_text


def test_what_no_factor_explains_is_said_to_be_something_else(fitted):
    made, fit = fitted
    found = comparison.compare(measured(made, factor=1.6), fit, samples=24, servo=None)
    assert max(found.friction.p_value, found.amplitude.p_value) < 0.05
    assert "No one factor on friction or on amplitude explains it" in found.verdict_text


def test_a_floor_whose_slope_nobody_measured_is_no_fault_of_the_robot(fitted):
    """At 0.25 Hz a slope of 0.3 degrees takes a third of the speed."""
    made, fit = fitted
    slow = measured(made)
    runs = slow.readings_of("gait")
    slow = made.with_reading(replace(runs[0], speed_m_s=0.036))
    level = comparison.compare(slow, fit, samples=24, servo=None)
    tools = replace(slow.setup.instruments, floor_slope_sigma_deg=0.3)
    sloped = replace(slow, setup=replace(slow.setup, instruments=tools))
    anyhow = comparison.compare(sloped, fit, samples=24, servo=None)
    assert level.p_value < 0.05 < anyhow.p_value


def test_p_values_of_what_was_drawn_are_even():
    """Frictions that skew, servos that differ, three gaits: each p is as frequent as another."""
    rng, found = np.random.default_rng(7), []

    def joints(count):
        skewed = np.exp(0.1 * rng.normal(size=(count, 2)))
        return skewed @ np.array([[0.05, 0.1, 0.1], [0.05, 0.05, 0.1]])

    def servos(count):
        return np.exp(0.1 * rng.normal(size=(count, 3)))

    for seed in range(200):
        true, samples = joints(1)[0] * servos(1)[0], joints(64)
        sigma = np.array([0.001, 0.002, 0.003])
        drawn = true + np.hypot(sigma, 0.01 * true) * rng.normal(size=3)
        level = np.ones((1024, 3))
        found.append(Predicted(samples, servos(64), level, drawn, sigma).p_value(seed))
    even = (np.arange(200) + 0.5) / 200
    assert np.abs(np.sort(found) - even).max() < 1.63 / math.sqrt(200)  # Kolmogorov, 1 %


def test_repeated_runs_are_one_mean(fitted):
    made, fit = fitted
    runs = measured(made).readings_of("gait")
    rate = runs[0].omega_rad_s * (1 + 2e-5)  # the board's clock, warmer
    twice = (
        *runs,
        replace(runs[0], number=200, speed_m_s=runs[0].speed_m_s * 1.02, omega_rad_s=rate),
        replace(runs[1], number=201, speed_m_s=9.0, voided=True),
    )
    found = comparison.compare(
        replace(made, readings=(*made.readings, *twice)), fit, samples=16, servo=None
    )
    assert found.gaits[0].runs == (100, 200)
    assert found.gaits[0].measured_m_s == pytest.approx(1.01 * runs[0].speed_m_s)
    assert found.gaits[0].sigma_m_s == pytest.approx(runs[0].speed_sigma_m_s / math.sqrt(2))
    assert found.gaits[1].runs == (101,)


def test_a_gait_that_servos_cannot_follow_is_listed_and_not_judged(fitted):
    """70 deg at 2 Hz asks 15 rad/s of some 6; half a hertz they follow."""
    made, fit = fitted
    found = comparison.compare(made, fit, gaits=[gait(12.6), gait(3.0)], samples=16)
    assert found.verdict == "not measured"
    assert found.p_value is None
    slow, quick = found.gaits
    assert slow.low_m_s < slow.high_m_s
    assert math.isnan(quick.low_m_s)
    words = "70°/75°, 2.01 Hz is too fast for a typical hobby servo: the joints must turn at 15 "
    assert words in found.verdict_text
    assert found.table(verbose=False)[1][1][1] == "too fast"
    told = speed_band(fit, gait(12.6), count=16)
    assert told.in_words().startswith("Too fast for a typical hobby servo: ")
    assert told.to_dict()["low_m_s"] is None
    run = GaitRun(gait(1).alpha_rad, gait(1).beta_rad, 12.6, 0.01, 0.001)
    alone = comparison.compare(made.with_reading(run), fit, samples=16)
    assert (alone.verdict, alone.p_value) == ("not judged", None)
    with refused("no gait was run and none is planned"):
        comparison.compare(made, fit)
