"""Remarks of a fit: misreadings, the influence of readings, a measured zero."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from calibration.synthetic_session import WHOLE_BODY_2005, changed, session, setup
from serpenoid import fit_friction
from simulated_sessions import MemoryRecord

FRICTIONS = ("ct", "cn", "ft0", "fn0")
TRUTH = [getattr(WHOLE_BODY_2005, name) for name in FRICTIONS]


@pytest.mark.parametrize(
    ("name", "factor"), [("belt_speed_m_s", 3.6), ("belt_speed_m_s", 1 / 3.6), ("incline_rad", 5.0)]
)
def test_a_number_in_another_unit_raises_an_alarm(name, factor):
    simulated = session(setup(30.0), WHOLE_BODY_2005, np.random.default_rng(8))
    reading = next(r for r in simulated.readings if r.belt_speed_m_s > 0.3)
    k = simulated.readings.index(reading)
    misread = changed(simulated, k, **{name: factor * getattr(reading, name)})
    assert re.search(rf"reading.* {reading.number}\b", " ".join(fit_friction(misread).alarms))


def test_influence_predicts_the_fit_without_a_reading():
    simulated = session(setup(15.0), WHOLE_BODY_2005, np.random.default_rng(26))
    fit = fit_friction(simulated)
    assert [i.reading for i in fit.influence] == [r.number for r in simulated.readings]
    for k, influence in list(enumerate(fit.influence))[::4]:
        without = fit_friction(changed(simulated, k, voided=True))
        assert influence.chi2_without == pytest.approx(without.chi2, rel=1e-3)
        for name, shift in influence.shift_in_sigmas.items():
            change = without.parameters[name].value - fit.parameters[name].value
            assert shift == pytest.approx(change / fit.parameters[name].sigma, abs=1e-3)


def test_a_measured_zero_is_subtracted_and_reduces_the_uncertainty():
    exact = session(setup(7.5), WHOLE_BODY_2005)
    zero_rad = math.radians(0.3)
    readings = tuple(replace(r, incline_rad=r.incline_rad + zero_rad) for r in exact.readings)
    record = MemoryRecord(exact.setup, replace(exact, readings=readings))
    for _ in range(2):
        record.add("zero", {"incline_deg": 1.0 + 0.3, "reversed_deg": 0.3 - 1.0})
    fit = fit_friction(record.session)
    np.testing.assert_allclose(list(fit.whole_snake.values()), TRUTH, rtol=1e-6)
    assert fit.parameters["ft0"].sigma < 0.7 * fit_friction(exact).parameters["ft0"].sigma
