"""An inclinometer's zero that nobody measured, and joints that a hand sets: what is assumed."""

import math
from dataclasses import replace

import pytest
from serpenoid import Ground, fit_friction
from serpenoid.taking.new_session import default_setup
from serpenoid.taking.simulated import SimulatedPerson, Truth, take_all
from simulated_sessions import MemoryRecord

FT0_N = 0.14


def without_zero(seed, zero_deg):
    """A session in the virtual lab whose inclinometer stands off, and nobody reads it both ways."""
    base = default_setup("no zero")
    setup = replace(base, plan=replace(base.plan, gaits=()))
    truth = Truth(Ground(0.084, 1.2, FT0_N, 0.27), incline_zero_rad=math.radians(zero_deg))
    record = MemoryRecord(setup)
    for step in ("zero before", "zero after"):
        record.event("skip", detail=step)
    return take_all(record, SimulatedPerson(setup, truth, seed))


@pytest.mark.parametrize(("seed", "zero_deg"), [(0, -0.5), (1, 0.4), (2, 0.5)])
def test_the_interval_of_ft0_holds_where_nobody_measured_the_zero(seed, zero_deg):
    """0.5 deg is one sigma or less."""
    fit = fit_friction(without_zero(seed, zero_deg))
    low, high = fit.intervals["ft0"]
    assert low < FT0_N < high
    assert any("was not measured: 0 ± 0.5 degrees are assumed" in note for note in fit.notes)
