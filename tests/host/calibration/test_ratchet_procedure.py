"""Ratchet wheels in the procedure: straight stations held again facing up, wherever it is asked."""

import math
from dataclasses import replace

import pytest
import serpenoid as sn
from robots import gait_in_deg
from serpenoid import advise
from serpenoid.calibration.taking.new_session import default_setup
from serpenoid.calibration.taking.procedure import progress
from serpenoid.calibration.taking.simulated import SimulatedPerson, Truth
from serpenoid.calibration.taking.treadmill import take_all
from simulated_sessions import MemoryRecord

TRUTH = sn.Ground((0.084, 0.2), 1.2, (0.14, 0.4), 0.27)


def ratchet_setup(ratchet=True):
    base = default_setup("made up")
    return replace(base, procedure=replace(base.procedure, ratchet=ratchet, gaits=()))


@pytest.fixture(scope="module")
def taken():
    setup = ratchet_setup()
    return take_all(MemoryRecord(setup), SimulatedPerson(setup, Truth(TRUTH), seed=2))


def test_the_simulated_treadmill_finds_both_ways(taken):
    fit = sn.fit_friction(taken)
    for name, true in (("ct", 0.084), ("ft0", 0.14), ("ct_back", 0.2), ("ft0_back", 0.4)):
        value, sigma = fit.parameters[name]
        assert abs(value - true) < 4 * sigma, name
    up = [r for r in taken.kept if r.facing == "up"]
    assert len(up) >= 4
    assert {r.lambda_rad for r in up} == {0.0}
    assert min(r.incline_rad for r in up) > math.radians(5.0)  # asin(0.4 / weight)
    assert dict(progress(taken))["straight, facing up"] == f"{len(up)} stations, done"


def test_a_plain_plan_never_turns_the_robot_round():
    plain = MemoryRecord(ratchet_setup(ratchet=False)).session
    assert not any("facing up" in part for part, _ in progress(plain))


def test_advice_knows_the_way_back(taken):
    gait = gait_in_deg(40, 75, 3.0)
    ways = {r.facing for r in advise(taken, [gait], samples=8, servo=None).readings}
    assert ways == {"down", "up"}
    down = replace(taken, readings=tuple(r for r in taken.readings if r.facing == "down"))
    found = advise(down, [gait], samples=8, servo=None)
    assert "Hold two straight stations facing up first" in found.note
    assert not advise(taken, [gait], samples=8, servo=None).note
