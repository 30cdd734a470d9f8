"""Dry gaits whose speed or power was further off than it said, and a part of the paper's grid."""

from __future__ import annotations

import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005, gait_in_deg

# Robot, ground, gait, rtol; speed and net power at 1e-9. The first's speed was 15 times its claim
# off, the second's power 11 times: a resting wheel's force passes from bound to bound within a
# piece. The third's speed 2 times: an event cuts a piece short.
HARD = [
    (
        (9, 0.5131544978002305, 0.14833315797880398),
        (0.0, 0.0, 0.10175649059713314, 1.08602129209057),
        (0.11408283476101277, 0.4420847102336956, 0.20062763649845713, -0.19205090942071296),
        1e-5,
        0.0083599961502,
        0.04500996748,
    ),
    (
        (3, 0.012683949873244265, 0.020712632786311823),
        (0.0, 0.0, 0.0003866968469080135, 0.011228044412786947),
        (1.00581568648254, 1.6767844232529399, 0.626151295056427, -0.15953074141795032),
        1e-4,
        0.0043761480065,
        6.0873748974e-06,
    ),
    (
        (11, 0.11919548880674491, 0.030644144275688175),
        (
            (3.9558354778772464e-05, 0.0005088073858031246),
            0.0021145871008656043,
            (0.005412601585982025, 0.0055409230148363575),
            0.5053272376992466,
        ),
        (1.142589672077694, 1.3130368745409557, 0.3824556935740943),
        1e-5,
        0.0054992466308,
        0.00064860141911,
    ),
]


@pytest.mark.parametrize("case", HARD, ids=lambda c: str(c[0][0]))
def test_what_was_further_off_than_it_said(case: tuple) -> None:
    robot, ground, gait, rtol, speed, power = case
    s = sn.steady_gait(sn.Robot(*robot), sn.Ground(*ground), sn.Gait(*gait), rtol=rtol)
    assert abs(s.speed_m_s - speed) <= 0.5 * s.error_estimate * speed
    assert abs(s.power_w - power) <= 0.5 * s.power_error_w
    assert abs(s.speed_m_s - speed) <= 3e-3 * rtol * speed


def test_a_short_rest_near_the_bound_is_seen() -> None:
    """A wheel rests for 1e-3 rad: it slid on, and the speed was up to 7 times its claim off.

    Other code (event functions, Dormand-Prince) finds 0.00205337376766 m/s.
    """
    s = sn.steady_gait(OF_2005, BINGHAM, gait_in_deg(40, 85, 8.0), rtol=1e-4)
    assert abs(s.speed_m_s - 0.00205337376766) <= 0.9 * s.error_estimate * s.speed_m_s
