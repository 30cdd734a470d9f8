"""Trims and limits of each servo, from the command to the pulse."""

import math

import numpy as np
import pytest
from avr.board import F_CPU_HZ
from avr.dialogue import JOINTS, Dialogue

pytestmark = pytest.mark.avr

JITTER_US = 3.0  # of the mean of 40 pulses: 0.5 us of rounding, and whatever interrupts add


def mean_widths(board, seconds: float = 0.8) -> np.ndarray:
    """Return the mean pulse width of each joint over the next stretch of time."""
    begin = board.time_s
    board.run(seconds)
    found = []
    for joint in range(JOINTS):
        pulses = board.pulses(joint)
        found.append(np.mean(pulses.width_us[pulses.rise_cycle / F_CPU_HZ > begin + 0.03]))
    return np.array(found)


def opened(board) -> Dialogue:
    talk = Dialogue(board)
    talk.hello()
    return talk


def obeyed(talk: Dialogue, *commands: str) -> None:
    for command in commands:
        verdict = talk.ask(command)
        assert verdict.startswith("ok:"), verdict


def test_pulse_is_centre_plus_direction_times_scale_times_angle(start):
    talk = opened(start())
    trims = [(1500, 573, 1), (1430, 573, 1), (1500, 620, 1), (1500, 573, -1), (1560, 500, -1)]
    for joint, (centre, scale, direction) in enumerate(trims, 1):
        obeyed(talk, f"trim {joint} centre {centre}", f"trim {joint} scale {scale}")
        obeyed(talk, f"trim {joint} dir {direction}")
    angles_deg = [20, -35, 40, 25, -15]
    obeyed(talk, "set silence 0", "pose " + " ".join(map(str, angles_deg)))
    talk.board.run(2.0)
    exact = [c + d * s * math.radians(a) for (c, s, d), a in zip(trims, angles_deg, strict=True)]
    np.testing.assert_allclose(mean_widths(talk.board), exact, atol=JITTER_US)


def test_a_new_centre_is_approached_slowly(start):
    talk = opened(start())
    obeyed(talk, "set silence 0", "pose straight")
    talk.board.run(1.0)
    obeyed(talk, "trim 2 centre 1600")
    talk.board.run(1.0)
    width = talk.board.pulses(1).width_us
    # the middle of the last ten: one alone may be late by an interrupt
    assert np.median(width[-10:]) == pytest.approx(1600, abs=JITTER_US)
    assert np.max(np.abs(np.diff(width))) <= 4 + 10  # 4 us a frame, and the rare late interrupt


def test_limits_of_a_joint_hold_in_every_command(start):
    talk = opened(start())
    obeyed(talk, "trim 3 low -20", "trim 3 high 25")
    for command in ("gait 30 80 5", "gait 15 80 5 11", "pose straight 26", "pose 0 0 -21 0 0"):
        verdict = talk.ask(command)
        assert verdict.split()[2] == "range", verdict
    obeyed(talk, "gait 20 80 5")
    talk.keep_alive(2.0)
    width = talk.board.pulses(2).width_us
    assert np.max(np.abs(width - 1500)) <= math.radians(20) * 573 + 10
