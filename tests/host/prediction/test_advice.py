"""Advice on the next reading: what it foretells comes true, and weak spots are named first."""

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from calibration.plain_sessions import World, plain_session
from calibration.synthetic_session import WHOLE_BODY_2005, session, setup
from refusals import refused
from robots import gait_in_deg
from serpenoid import advise
from serpenoid.prediction.speed_samples import speed_band
from serpenoid.session.gait_run import GaitRun
from serpenoid.session.station import Reading

pytestmark = pytest.mark.usefixtures("short_curve")
GAIT = gait_in_deg(70, 75, 2 * math.pi * 0.25)


@pytest.fixture(scope="module")
def weak():
    return session(setup(7.5), WHOLE_BODY_2005)


def test_a_small_bend_is_followed_by_a_larger_one(weak):
    found = advise(weak, [GAIT], servo=None)
    assert {r.kind for r in found.readings} == {"station"}  # no fit uses gait runs
    assert found.best.lambda_rad >= math.radians(15)
    assert found.best.band < 0.95 * found.band  # the rest is the joints'
    assert "between the links at either end" in found.best.in_words()
    bands = [r.band for r in found.readings]
    assert bands == sorted(bands)


def test_advise_promises_what_compare_then_shows(weak):
    """The band is that of `compare`, now, and once the best reading is taken, or another."""
    plan = replace(weak.setup.procedure, gaits=())
    weak = replace(weak, setup=replace(weak.setup, procedure=plan))
    told = advise(weak, [GAIT], servo=None)
    shown = sn.compare(weak, gaits=[GAIT], servo=None).gaits[-1]
    half = (shown.high_all_m_s - shown.low_all_m_s) / 2
    assert told.band == pytest.approx(half / shown.exact_m_s, rel=1e-6)
    other = next(r for r in told.readings[1:] if r.lambda_rad == pytest.approx(math.radians(30)))
    for one, band in ((told.best, told.band_after_best), (other, other.band)):
        where = one.lambda_rad, one.incline_rad, one.belt_speed_m_s
        first = len(weak.readings) + 1
        more = (Reading(first + k, *where, bend=one.bend or "zigzag") for k in range(one.times))
        fit = sn.fit_friction(replace(weak, readings=(*weak.readings, *more)))
        then = speed_band(fit, GAIT, count=512, servo=None)  # of 64 a half scatters by 15 %
        half = (then.high_m_s - then.low_m_s) / 2
        assert band == pytest.approx(half / then.speed_m_s, rel=0.25)


def test_no_bend_is_named_that_would_bias_and_no_speed_at_which_the_law_fails(weak):
    coarse = plain_session(World(bends_deg=(15.0,)), np.random.default_rng(1))  # 0.5 % of grade
    found = advise(coarse, [GAIT], servo=None)
    assert min(r.belt_speed_m_s for r in found.readings) > 0.12
    unsure = replace(weak.setup.uncertainty, lambda_sigma_rad=math.radians(1.2))
    rough = replace(weak, setup=replace(weak.setup, uncertainty=unsure))
    bends = {r.lambda_rad for r in advise(rough, [GAIT], servo=None).readings} - {0.0}
    assert min(bends) > math.radians(12)


def test_no_place_is_named_that_failed_or_that_is_beyond_the_treadmill(weak):
    best = advise(weak, [GAIT], servo=None).best
    failed = Reading(99, best.lambda_rad, best.incline_rad, best.belt_speed_m_s, voided=True)
    again = advise(replace(weak, readings=(*weak.readings, failed)), [GAIT], servo=None)
    same = [
        r
        for r in again.readings
        if (r.lambda_rad, r.incline_rad) == (best.lambda_rad, best.incline_rad)
    ]
    assert same == []
    assert max(r.incline_rad for r in again.readings) < math.atan(0.15)
    assert max(r.lambda_rad for r in again.readings) <= math.radians(30)


def test_a_gait_run_counts_once_for_what_runs_share(weak):
    before = advise(weak, [GAIT], runs=True, servo=None)
    assert before.best.kind == "gait"
    run = GaitRun(99, GAIT.alpha_rad, GAIT.beta_rad, GAIT.omega_rad_s, 0.05, 0.0005)
    after = advise(replace(weak, gait_runs=(run,)), [GAIT], runs=True, servo=None)
    assert after.band == pytest.approx(before.best.band, rel=0.1)
    again = [r for r in after.readings if r.kind == "gait"]
    assert again[0].band > 0.9 * after.band


def test_no_gait_is_refused(weak):
    with refused("--gait"):
        advise(weak)
