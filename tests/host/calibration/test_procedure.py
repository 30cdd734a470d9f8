"""The procedure as a state machine, and whole sessions of it on the simulated treadmill."""

import math
from dataclasses import replace

import pytest
from serpenoid import Ground, fit_friction
from serpenoid.calibration.taking.expected import Series
from serpenoid.calibration.taking.new_session import default_setup
from serpenoid.calibration.taking.procedure import (
    doubts,
    next_incline_deg,
    next_step,
    progress,
    settle_s,
    skipped_keys,
)
from serpenoid.calibration.taking.simulated import SimulatedPerson, Truth
from serpenoid.calibration.taking.treadmill import take_all
from simulated_sessions import MemoryRecord

WHOLE_BODY_2005 = Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)


def no_gaits(setup):
    return replace(setup, procedure=replace(setup.procedure, gaits=()))


@pytest.fixture
def record():
    return MemoryRecord(no_gaits(default_setup("made up")))


def station(record, incline_deg, belt_m_s, lambda_deg=0.0):
    cells = {"lambda_deg": lambda_deg, "incline_deg": incline_deg, "belt_speed_m_s": belt_m_s}
    record.add("station", cells | {"drift_m_s": 0.0})


def test_the_steps_come_in_order(record):
    assert next_step(record.session).kind == "zero"
    record.add("zero", {"incline_deg": 0.1, "reversed_deg": 0.0})
    assert next_step(record.session).kind == "straight"
    step = next_step(record.session, posed_deg=0.0)
    assert (step.kind, step.incline_deg) == ("station", 2.4)
    asked = ["incline_deg", "belt_speed_m_s", "turned_deg", "drift_m_s"]
    assert [f.column for f in step.fields] == asked
    for incline, belt in ((2.0, 0.2), (2.3, 0.5), (2.6, 0.8)):
        station(record, incline, belt)
    bend = next_step(record.session, posed_deg=0.0)
    assert (bend.kind, bend.lambda_deg) == ("bend", 7.5)
    assert "-15, +7.5, 0, -7.5, +15 deg" in bend.say
    assert "shows 165 deg" in bend.say
    assert next_step(record.session, frozenset({"bend 7.5"}), 0.0).lambda_deg == 15.0


def test_a_bend_counts_as_the_protractor_shows_it(record):
    record.add("zero", {"incline_deg": 0.1, "reversed_deg": 0.0})
    skipped = frozenset({"straight", "bend 7.5"})
    record.add("bend", {"lambda_deg": 15.0, "between_links_deg": 148.0})
    step = next_step(record.session, skipped, 15.0)
    assert (step.kind, step.cells["lambda_deg"]) == ("station", 16.0)
    # So far off that it is another bend of the plan: bend again.
    record.add("bend", {"lambda_deg": 15.0, "between_links_deg": 163.0})
    assert next_step(record.session, skipped, 15.0).kind == "bend"


def test_the_zero_is_read_again_at_the_end(record):
    station(record, 2.0, 0.2)
    skipped = frozenset({"zero before", "straight", *(f"bend {b:g}" for b in (7.5, 15, 30))})
    assert next_step(record.session, skipped).key == "zero after"
    record.add("zero", {"incline_deg": 0.1, "reversed_deg": 0.0})
    assert next_step(record.session, skipped).kind == "belt"
    record.add("belt", {"belt_speed_m_s": 0.5, "distance_m": 28.0, "duration_s": 55.0})
    assert next_step(record.session, skipped).kind == "done"
    parts = dict(progress(record.session, skipped))
    assert parts["zero after"] == parts["belt check"] == "done"


def test_inclines_rise_faster_where_the_belt_hardly_does(record):
    for incline, belt in ((3.0, 0.05), (3.3, 0.10), (3.6, 0.15)):
        station(record, incline, belt, 30.0)
    # A sixth of 1 m/s is 1.0 deg on this line; the plan's step is 0.3.
    found = next_incline_deg(record.session, Series(math.radians(30.0)))
    assert found == pytest.approx(4.6, abs=0.02)
    assert next_incline_deg(record.session, Series(math.radians(15.0))) == 2.4
    station(record, 2.6, 0.2, 15.0)  # where this bend held, the next one begins
    assert next_incline_deg(
        replace(record.session, readings=record.session.readings[3:]), Series(math.radians(30.0))
    ) == pytest.approx(2.6)


def test_a_first_bend_is_asked_where_the_robot_of_2005_would_hold(record):
    """Straight stations tell ct and ft0; four of six links are bent."""
    weight_n = record.session.setup.weight_n
    for belt in (0.2, 0.5):
        station(record, math.degrees(math.asin((0.084 * belt + 0.14) / weight_n)), belt)
    q, c, s, v = 2 / 3, math.cos(math.radians(15)), math.sin(math.radians(15)), 1 / 6
    drag = (1 - q * s * s) * 0.084 + q * s * s * 1.2
    force_n = drag * v + (1 - q + q * c) * 0.14 + q * s * 0.27
    expected_deg = math.degrees(math.asin(force_n / weight_n))
    assert next_incline_deg(record.session, Series(math.radians(15))) == pytest.approx(
        expected_deg, abs=2e-3
    )
    # Whatever a line of slips says, an incline is asked at which a robot may hold.
    for belt, asked_deg in ((0.1, 12.0), (0.9, 2.4)):
        slips = [
            replace(record.session.readings[0], incline_rad=at, belt_speed_m_s=belt + at / 100)
            for at in (0.035, 0.4)
        ]
        found = next_incline_deg(
            replace(record.session, readings=tuple(slips)), Series(math.radians(15))
        )
        assert found == pytest.approx(asked_deg, abs=0.01)


def test_readings_all_alike_tell_no_line_and_the_next_is_asked_all_the_same(record):
    for bend in (0.0, 0.0, 15.0, 15.0):
        station(record, 2.5, 0.5, bend)
    assert next_incline_deg(record.session, Series(math.radians(30))) == 2.5


def test_a_slower_station_follows_a_fast_first_one(record):
    station(record, 2.4, 0.3)
    assert next_incline_deg(record.session, Series(0.0)) == 2.7  # it is slow enough
    quick = MemoryRecord(record.session.setup)
    station(quick, 2.4, 0.8)
    less_deg = math.degrees(0.8 * 0.084 * (0.8 - 0.2) / quick.session.setup.weight_n)
    found, missed = next_incline_deg(quick.session, Series(0.0)), frozenset()
    assert found == pytest.approx(2.4 - less_deg, abs=2e-3)
    # Where it cannot be held there, half as much slower; then steeper.
    for expected in (2.4 - less_deg / 2, 2.7):
        missed |= {f"station 0 {found:.2f}"}
        found = next_incline_deg(quick.session, Series(0.0), missed)
        assert found == pytest.approx(expected, abs=2e-3)


def test_a_skipped_station_is_passed_over(record):
    assert next_incline_deg(record.session, Series(0.0), frozenset({"station 0 2.40"})) == 2.7
    assert next_incline_deg(record.session, Series(0.0), frozenset({"station 0 11.90"})) is None


def test_what_is_out_of_line_is_doubted_at_the_incline_that_was_typed(record):
    for incline, belt in ((2.0, 0.2), (2.3, 0.5), (2.6, 0.8)):
        station(record, incline, belt)
    session = replace(record.session, readings=record.session.readings[:2])
    step = next_step(session, frozenset({"zero before"}), 0.0)
    good = {"incline_deg": 2.6, "belt_speed_m_s": 0.8, "drift_m_s": 0.0}
    assert doubts(session, step, good) == []
    assert [f.column for f, _ in doubts(session, step, good | {"belt_speed_m_s": 2.9})] == [
        "belt_speed_m_s"
    ]
    assert doubts(session, step, good | {"incline_deg": 4.6})[0][0].column == "incline_deg"


def test_the_settling_time_follows_the_readings(record):
    assert settle_s(record.session) == pytest.approx(3 * 0.4536 / 0.084)
    for incline, belt in ((2.0, 0.2), (2.6, 0.8)):
        station(record, incline, belt)
    # A is m g / (dv / d sin gamma), so m / A is that slope over g.
    slope = 0.6 / (math.sin(math.radians(2.6)) - math.sin(math.radians(2.0)))
    assert settle_s(record.session) == pytest.approx(3 * slope / 9.80665)


class Noted(SimulatedPerson):
    """Keeps what was typed wrong at first."""

    def __init__(self, *args, **more):
        super().__init__(*args, **more)
        self.wrong = []

    def _typed(self, step, read):
        typed = super()._typed(step, read)
        if typed != dict(read):
            self.wrong.append((typed["incline_deg"], typed["belt_speed_m_s"]))
        return typed


def test_misreadings_out_of_line_are_read_again():
    """All of twenty sessions: of what a person misreads, the dialogue catches most."""
    setup = no_gaits(default_setup("made up"))
    missed = typed_wrong = 0
    for seed in range(20):
        person = Noted(setup, Truth(WHOLE_BODY_2005, misreads=0.1), seed)
        session = take_all(MemoryRecord(setup), person)
        typed_wrong += person.misread
        missed += sum(
            (round(math.degrees(r.incline_rad), 4), r.belt_speed_m_s) in person.wrong
            for r in session.kept
        )
    assert typed_wrong > 10
    assert missed <= 0.3 * typed_wrong


def test_belts_that_cannot_go_slowly_lose_stations_not_sessions():
    setup = no_gaits(default_setup("made up"))
    setup = replace(setup, treadmill=replace(setup.treadmill, belt_least_m_s=0.25))
    record = MemoryRecord(setup)
    session = take_all(record, SimulatedPerson(setup, Truth(WHOLE_BODY_2005), 1))
    again = take_all(MemoryRecord(setup), SimulatedPerson(setup, Truth(WHOLE_BODY_2005), 1))
    assert again.readings == session.readings  # of the same seed
    least = min(r.belt_speed_m_s for r in session.kept)
    assert 0.25 <= least < 0.31  # belts are set in steps of 0.028 m/s
    assert skipped_keys(record.events)
    assert fit_friction(session).dof > 5
