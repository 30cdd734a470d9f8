"""Comparison of measured with predicted speeds: p-values, factors, gaits that are not compared."""

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
from serpenoid.prediction.speeds import speed_band
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
    simulated = session(level, WHOLE_BODY_2005, np.random.default_rng(31))
    return simulated, sn.fit_friction(simulated)


def measured_session(simulated, amplitude=1.0, factor=1.0):
    """Return the session with one run of each gait, with scaled joint amplitudes and speeds."""
    runs = list(simulated.readings)
    for k, rate in enumerate(RATES):
        steady = sn.steady_gait(simulated.setup.robot, BINGHAM, gait(rate, amplitude), rtol=1e-3)
        speed, sigma = factor * steady.speed_m_s, 0.01 * steady.speed_m_s
        command = gait(rate)
        runs.append(
            GaitRun(command.alpha_rad, command.beta_rad, rate, speed, sigma, number=100 + k)
        )
    return replace(simulated, readings=tuple(runs))


def test_speeds_as_predicted_agree(fitted):
    simulated, fit = fitted
    result = comparison.compare(measured_session(simulated), fit, samples=24, servo=None)
    assert result.verdict == "agrees"
    assert result.verdict_text.startswith("Agrees: the speeds of 3 gaits are likely enough ")
    assert (result.friction, result.amplitude) == (None, None)
    assert [p.runs for p in result.gaits] == [(100,), (101,), (102,)]
    for shown in result.gaits:  # the paper's own comparison
        assert 0.0 < shown.implicit_error_m_s < 0.01 * shown.implicit_m_s
    json.dumps(result.to_dict(), allow_nan=False)


def test_a_small_p_value_is_a_difference(fitted):
    simulated, fit = fitted
    result = comparison.compare(
        measured_session(simulated, factor=1.08), fit, samples=24, servo=None
    )
    assert 1e-3 < result.p_value < 0.05
    assert result.verdict == "differs"


def test_the_factor_on_amplitude_that_explains_the_speeds_is_reported(fitted):
    simulated, fit = fitted
    result = comparison.compare(measured_session(simulated, 0.85), fit, samples=24, servo=None)
    assert result.verdict == "differs"
    assert result.p_value < 0.05 < result.amplitude.p_value
    assert result.amplitude.factor == pytest.approx(0.86, abs=0.03)
    assert result.friction.p_value < 0.05
    assert result.verdict_text.startswith("Differs: the largest difference from the prediction ")
    assert "explained by joints that reach 8" in result.verdict_text
    assert "friction times" not in result.verdict_text


def test_speeds_that_no_factor_explains(fitted):
    simulated, fit = fitted
    result = comparison.compare(
        measured_session(simulated, factor=1.6), fit, samples=24, servo=None
    )
    assert max(result.friction.p_value, result.amplitude.p_value) < 0.05
    assert "No one factor on friction or on amplitude explains it" in result.verdict_text


def test_an_unknown_slope_of_the_floor_reduces_the_difference(fitted):
    """At 0.25 Hz a slope of 0.3 degrees takes a third of the speed."""
    simulated, fit = fitted
    slow = measured_session(simulated)
    runs = slow.readings_of("gait")
    slow = simulated.with_reading(replace(runs[0], speed_m_s=0.036))
    level = comparison.compare(slow, fit, samples=24, servo=None)
    tools = replace(slow.setup.instruments, floor_slope_sigma_deg=0.3)
    sloped = replace(slow, setup=replace(slow.setup, instruments=tools))
    uncertain = comparison.compare(sloped, fit, samples=24, servo=None)
    assert level.p_value < 0.05 < uncertain.p_value


def test_p_values_of_random_speeds_are_uniform():
    """The distribution is uniform with skewed frictions, different servos and three gaits."""
    rng, p_values = np.random.default_rng(7), []

    def joints(count):
        skewed = np.exp(0.1 * rng.normal(size=(count, 2)))
        return skewed @ np.array([[0.05, 0.1, 0.1], [0.05, 0.05, 0.1]])

    def servos(count):
        return np.exp(0.1 * rng.normal(size=(count, 3)))

    for seed in range(200):
        true, samples = joints(1)[0] * servos(1)[0], joints(64)
        sigma = np.array([0.001, 0.002, 0.003])
        speeds = true + np.hypot(sigma, 0.01 * true) * rng.normal(size=3)
        level = np.ones((1024, 3))
        p_values.append(Predicted(samples, servos(64), level, speeds, sigma).p_value(seed))
    uniform = (np.arange(200) + 0.5) / 200
    assert np.abs(np.sort(p_values) - uniform).max() < 1.63 / math.sqrt(200)  # Kolmogorov, 1 %


def test_repeated_runs_are_averaged(fitted):
    simulated, fit = fitted
    runs = measured_session(simulated).readings_of("gait")
    rate = runs[0].omega_rad_s * (1 + 2e-5)  # another frequency of the board's clock
    repeated = (
        *runs,
        replace(runs[0], number=200, speed_m_s=runs[0].speed_m_s * 1.02, omega_rad_s=rate),
        replace(runs[1], number=201, speed_m_s=9.0, voided=True),
    )
    result = comparison.compare(
        replace(simulated, readings=(*simulated.readings, *repeated)), fit, samples=16, servo=None
    )
    assert result.gaits[0].runs == (100, 200)
    assert result.gaits[0].measured_m_s == pytest.approx(1.01 * runs[0].speed_m_s)
    assert result.gaits[0].sigma_m_s == pytest.approx(runs[0].speed_sigma_m_s / math.sqrt(2))
    assert result.gaits[1].runs == (101,)


def test_a_gait_that_servos_cannot_follow_is_listed_without_a_verdict(fitted):
    """A gait of 70 deg at 2 Hz needs 15 rad/s of servos with 6 rad/s; at 0.5 Hz they can follow."""
    simulated, fit = fitted
    result = comparison.compare(simulated, fit, gaits=[gait(12.6), gait(3.0)], samples=16)
    assert result.verdict == "not measured"
    assert result.p_value is None
    slow, quick = result.gaits
    assert slow.low_m_s < slow.high_m_s
    assert math.isnan(quick.low_m_s)
    words = "70°/75°, 2.01 Hz is too fast for a typical hobby servo: the joints must turn at 15 "
    assert words in result.verdict_text
    assert result.table(verbose=False)[1][1][1] == "too fast"
    band = speed_band(fit, gait(12.6))
    assert band.in_words().startswith("Too fast for a typical hobby servo: ")
    assert band.to_dict()["low_m_s"] is None
    run = GaitRun(gait(1).alpha_rad, gait(1).beta_rad, 12.6, 0.01, 0.001)
    alone = comparison.compare(simulated.with_reading(run), fit, samples=16)
    assert (alone.verdict, alone.p_value) == ("not judged", None)
    with refused("no gait was run and none is planned"):
        comparison.compare(simulated, fit)
