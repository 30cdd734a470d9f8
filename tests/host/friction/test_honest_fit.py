"""What a fit must not hide: bends set one by one, an undeclared zero, misreadings, gaps."""

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
    ("name", "times"), [("belt_speed_m_s", 3.6), ("belt_speed_m_s", 1 / 3.6), ("incline_rad", 5.0)]
)
def test_a_number_in_another_unit_is_named(name, times):
    made = session(setup(30.0), WHOLE_BODY_2005, np.random.default_rng(8))
    reading = next(r for r in made.readings if r.belt_speed_m_s > 0.3)
    k = made.readings.index(reading)
    slipped = changed(made, k, **{name: times * getattr(reading, name)})
    assert re.search(rf"reading.* {reading.number}\b", " ".join(fit_friction(slipped).alarms))


def test_influence_foretells_the_fit_without_a_reading():
    made = session(setup(15.0), WHOLE_BODY_2005, np.random.default_rng(26))
    fit = fit_friction(made)
    assert [i.reading for i in fit.influence] == [r.number for r in made.readings]
    for k, told in list(enumerate(fit.influence))[::4]:
        without = fit_friction(changed(made, k, voided=True))
        assert told.chi2_without == pytest.approx(without.chi2, rel=1e-3)
        for name, shift in told.shift_in_sigmas.items():
            moved = without.parameters[name].value - fit.parameters[name].value
            assert shift == pytest.approx(moved / fit.parameters[name].sigma, abs=1e-3)


def test_a_measured_zero_is_taken_off_and_known_better():
    exact = session(setup(7.5), WHOLE_BODY_2005)
    off = math.radians(0.3)
    shown = tuple(replace(r, incline_rad=r.incline_rad + off) for r in exact.readings)
    record = MemoryRecord(exact.setup, replace(exact, readings=shown))
    for _ in range(2):
        record.add("zero", {"incline_deg": 1.0 + 0.3, "reversed_deg": 0.3 - 1.0})
    fit = fit_friction(record.session)
    np.testing.assert_allclose(list(fit.whole_snake.values()), TRUTH, rtol=1e-6)
    assert fit.parameters["ft0"].sigma < 0.7 * fit_friction(exact).parameters["ft0"].sigma
