"""Advice on the next reading: what it foretells comes true; it names what the session can do."""

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from calibration.floor_sessions import floor_session
from calibration.synthetic_session import WHOLE_BODY_2005, session, setup
from refusals import refused
from robots import gait_in_deg
from serpenoid import advise

GAIT = gait_in_deg(70, 75, 2 * math.pi * 0.5)


@pytest.fixture(scope="module")
def weak():
    return session(setup(7.5), WHOLE_BODY_2005)


def placed(session, best, **fields):
    """Return a station of the session, moved to where an advice names one."""
    where = {name: getattr(best, name) for name in ("lambda_rad", "incline_rad", "belt_speed_m_s")}
    return replace(session.readings[0], **where, **fields)


def test_a_small_bend_is_followed_by_a_larger_one(weak):
    found = advise(weak, [GAIT], servo=None)
    assert {reading.kind for reading in found.readings} == {"station"}
    assert found.best.lambda_rad >= math.radians(15)
    assert found.best.band < 0.95 * found.band  # the rest is the joints'
    assert "between the links at either end" in found.best.words
    assert found.in_words().startswith("Take next: a station")


def test_advise_promises_what_compare_then_shows(weak):
    """Once the best reading is taken, the band is what was foretold."""
    best = advise(weak, [GAIT], servo=None).best
    taken = [placed(weak, best, number=100)]
    more = replace(weak, readings=(*weak.readings, *taken))
    # of 64 samples a half scatters by 15 %
    then = sn.compare(more, gaits=[GAIT], servo=None, samples=512).gaits[-1]
    half = (then.high_m_s - then.low_m_s) / 2
    assert best.band == pytest.approx(half / then.exact_m_s, rel=0.25)


def test_no_bend_is_named_that_would_bias_and_no_place_beyond_the_treadmill(weak):
    rng = np.random.default_rng(1)
    coarse = session(setup(15.0), WHOLE_BODY_2005, rng, on_grades=True)  # 0.5 % of grade
    found = advise(coarse, [GAIT], servo=None)
    assert min(reading.belt_speed_m_s for reading in found.readings) > 0.12
    assert max(reading.incline_rad for reading in found.readings) < math.atan(0.15)
    unsure = replace(weak.setup.instruments, lambda_sigma_deg=1.2)
    rough = replace(weak, setup=replace(weak.setup, instruments=unsure))
    bends = {reading.lambda_rad for reading in advise(rough, [GAIT], servo=None).readings} - {0.0}
    assert min(bends) > math.radians(12)


def test_no_place_is_named_that_failed(weak):
    best = advise(weak, [GAIT], servo=None).best
    failed = placed(weak, best, number=99, voided=True)
    again = advise(replace(weak, readings=(*weak.readings, failed)), [GAIT], servo=None)
    places = {(reading.lambda_rad, reading.incline_rad) for reading in again.readings}
    assert (best.lambda_rad, best.incline_rad) not in places


def test_only_what_the_session_can_do_is_named(weak):
    """A treadmill has no pushes, a floor no stations; a film needs tags, a test a servo."""
    on_belt = advise(weak, [GAIT], samples=16)
    assert {reading.kind for reading in on_belt.readings} == {"station", "servo"}
    body = replace(weak.setup.robot_table, tag_mm=34.0)
    tagged = replace(weak, setup=replace(weak.setup, robot_table=body))
    assert "film" in {reading.kind for reading in advise(tagged, [GAIT], samples=16).readings}
    on_floor = advise(floor_session(), [GAIT], servo=None, samples=16)
    assert {reading.kind for reading in on_floor.readings} == {"push", "film"}


def test_where_nothing_gains_a_tenth_one_sentence_says_so():
    known = session(setup(15.0, 30.0), WHOLE_BODY_2005)
    sure = replace(known.setup.instruments, incline_sigma_deg=6e-5, incline_zero_sigma_deg=6e-5)
    known = replace(known, setup=replace(known.setup, instruments=sure))
    found = advise(known, [gait_in_deg(50, 80, 2.0)], servo=None)
    assert not found.worth
    assert found.in_words().startswith("No further reading is worth its time: ")
    assert found.in_words().count(".") <= 2
    assert found.table() == ([], [])


def test_no_gait_is_refused(weak):
    with refused("--gait"):
        advise(weak)
