"""The procedure as a state machine, and whole sessions of it on the simulated treadmill."""

import math
from dataclasses import replace

import pytest
from serpenoid import Ground
from serpenoid.taking.expected import Series
from serpenoid.taking.new_session import default_setup
from serpenoid.taking.procedure import (
    next_incline_deg,
)
from simulated_sessions import MemoryRecord

WHOLE_BODY_2005 = Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)


def no_gaits(setup):
    return replace(setup, plan=replace(setup.plan, gaits=()))


@pytest.fixture
def record():
    return MemoryRecord(no_gaits(default_setup("made up")))


def station(record, incline_deg, belt_m_s, lambda_deg=0.0):
    cells = {"lambda_deg": lambda_deg, "incline_deg": incline_deg, "belt_speed_m_s": belt_m_s}
    record.add("station", cells | {"drift_m_s": 0.0})


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
