"""Comparison of measured with predicted speeds: bands that skew, and verdicts that can be told."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import WHOLE_BODY_2005, session, setup
from refusals import refused
from robots import BINGHAM
from serpenoid.calibration.crawls.data import CrawlData
from serpenoid.prediction import comparison, verdict
from serpenoid.prediction.speed_samples import speed_band
from serpenoid.session.gait_run import GaitRun

pytestmark = pytest.mark.usefixtures("short_curve")
RATES = [2 * math.pi * hz for hz in (0.25, 0.5, 1.0)]


def gait(rate, amplitude=1.0):
    return sn.Gait(math.radians(70) * amplitude, math.radians(75), rate)


@pytest.fixture(scope="module")
def fitted():
    made = session(setup(30.0), WHOLE_BODY_2005, np.random.default_rng(31))
    return made, sn.fit_friction(made)


def measured(made, amplitude=1.0, factor=1.0):
    """Return the session with one run of each gait, as joints of this amplitude would run it."""
    runs = []
    for k, rate in enumerate(RATES):
        v = sn.steady_gait(made.setup.robot, BINGHAM, gait(rate, amplitude), rtol=1e-3).speed_m_s
        g = gait(rate)
        runs.append(GaitRun(100 + k, g.alpha_rad, g.beta_rad, rate, factor * v, 0.01 * v))
    return replace(made, gait_runs=tuple(runs))


@pytest.mark.parametrize(
    ("amplitude", "factor", "verdict"),
    [(1.0, 1.0, "agrees"), (0.85, 1.0, "amplitude"), (1.0, 1.6, "neither")],
)
def test_the_verdict_names_the_cause(fitted, amplitude, factor, verdict):
    made, fit = fitted
    found = comparison.compare(measured(made, amplitude, factor), fit, samples=24, servo=None)
    assert found.verdict == verdict
    assert {"agrees": "Agrees", "amplitude": "it is amplitude", "neither": "Neither"}[
        verdict
    ] in found.verdict_text
    assert factor == 1.0 or "off: check tape" in found.verdict_text
    assert [p.runs for p in found.gaits] == [(100,), (101,), (102,)]
    json.dumps(found.to_dict(), allow_nan=False)


def test_what_chance_makes_once_in_a_hundred_is_no_agreement(fitted):
    made, fit = fitted
    found = comparison.compare(measured(made, 0.885), fit, samples=24, servo=None)
    assert 1e-3 < found.p_value < 0.02
    assert "amplitude" in found.verdict


def test_another_surface_is_told_as_friction(fitted):
    made, fit = fitted
    # the robot crawled where friction along its links is 30 % more, five of the fit's sigmas
    slow = sn.Ground.whole_body(6, ct=0.084, cn=1.2, ft0=0.14 * 1.3, fn0=0.27)
    runs = tuple(
        replace(r, speed_m_s=sn.steady_gait(made.setup.robot, slow, r.gait, rtol=1e-3).speed_m_s)
        for r in measured(made).gait_runs
    )
    tight = tuple(replace(r, speed_sigma_m_s=0.004 * r.speed_m_s) for r in runs)
    found = comparison.compare(
        replace(made, gait_runs=tight), fit, samples=24, amplitude_sigma=0.002, servo=None
    )
    assert found.verdict == "friction"
    assert "uphill would pull as much" in found.verdict_text


def test_repeated_runs_are_one_mean(fitted):
    made, fit = fitted
    runs = measured(made).gait_runs
    rate = runs[0].omega_rad_s * (1 + 2e-5)  # the board's clock, warmer
    twice = (
        *runs,
        replace(runs[0], number=200, speed_m_s=runs[0].speed_m_s * 1.02, omega_rad_s=rate),
        replace(runs[1], number=201, speed_m_s=9.0, voided=True),
    )
    found = comparison.compare(replace(made, gait_runs=twice), fit, samples=16, servo=None)
    assert found.gaits[0].runs == (100, 200)
    assert found.gaits[0].measured_m_s == pytest.approx(1.01 * runs[0].speed_m_s)
    assert found.gaits[0].sigma_m_s == pytest.approx(runs[0].speed_sigma_m_s / math.sqrt(2))
    assert found.gaits[1].runs == (101,)


def test_without_runs_it_predicts_and_says_what_is_too_fast(fitted):
    """70 deg at 2 Hz asks 15 rad/s of some 6, which no film showed; half a hertz they follow."""
    made, fit = fitted
    found = comparison.compare(made, fit, gaits=[gait(3.0), gait(12.6)], samples=16)
    assert found.verdict == "not measured"
    assert found.p_value is None
    slow, quick = found.gaits
    assert slow.low_all_m_s < slow.high_all_m_s
    assert (quick.low_all_m_s, quick.high_all_m_s) == (None, None)
    words = (
        "70°/75°, 2.01 Hz is too fast for a typical hobby servo: the joints must turn at 15 rad/s; "
    )
    assert found.verdict_text.startswith(words)
    assert found.table(verbose=False)[1][1][1] == "too fast"
    assert slow.frequency_hz < found.highest_hz < quick.frequency_hz
    told = speed_band(fit, gait(12.6), count=16)
    assert told.in_words().startswith("Too fast for a typical hobby servo: ")
    assert told.to_dict()["low_m_s"] is None
    with refused("no gait run and no gait planned"):
        comparison.compare(made, fit)


def test_springs_that_never_settle_do_not_withhold_the_rest(fitted, monkeypatch):
    """Heavy links ring for ever on the paper's springs, and the report ended there."""

    def rings(*_, **__):
        raise sn.NotConverged("rings")

    monkeypatch.setattr(comparison, "steady_springs", rings)
    found = comparison.compare(*fitted, gaits=[gait(5.0)], samples=16, servo=None)
    assert found.gaits[-1].implicit_m_s is None
    assert found.gaits[-1].exact_m_s > 0.1


def chance(drawn, speeds, sigma):
    return verdict._chance(drawn, CrawlData(drawn.gaits, speeds, sigma), np.random.default_rng(5))
