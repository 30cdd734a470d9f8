"""The robot stays safe on a simulated board: boot, idle, reset, hang."""

import numpy as np
import pytest
from avr.board import F_CPU_HZ
from avr.dialogue import JOINTS, Dialogue, fields, telemetry

pytestmark = pytest.mark.avr

FRAME_S = 0.02
CENTRE_US = 1500.0
JITTER_US = 10.0  # the rare extreme of a pulse whose interrupt was delayed


def widths(board, since_s):
    """Return the widths of all pulses that rose from a time on, one array a joint."""
    found = []
    for joint in range(JOINTS):
        pulses = board.pulses(joint)
        rise_s = pulses.rise_cycle / F_CPU_HZ
        found.append(pulses.width_us[rise_s >= since_s])
    return found


def crawling(board) -> Dialogue:
    talk = Dialogue(board).obey("hello", "gait 30 80 5")
    talk.keep_alive(3.0)
    return talk


def test_no_pulse_before_the_first_motion_command(start):
    board = start()
    talk = Dialogue(board)
    talk.obey("hello", "ping", "status", "help", "set", "trim", "set silence 5", "stop", "idle")
    talk.keep_alive(1.0)
    assert len(board.edges) == 0
    assert talk.ask("pose straight").startswith("ok:")
    board.run(0.6)  # one servo every 0.1 s
    for joint, width in enumerate(widths(board, 0.0)):
        assert len(width) == pytest.approx(28 - 5 * joint, abs=2)
        np.testing.assert_allclose(width, CENTRE_US, atol=JITTER_US)


def test_idle_ends_the_pulses(start):
    board = start()
    talk = crawling(board)
    assert talk.ask("idle").startswith("ok:")
    limp_s = board.time_s
    board.run(0.5)
    assert all(len(width) == 0 for width in widths(board, limp_s + 2 * FRAME_S))


@pytest.mark.parametrize(("cause", "word"), [("external", "external"), ("brown-out", "brownout")])
def test_reset_in_mid_motion_is_told_and_leaves_the_servos_limp(start, cause, word):
    board = start()
    talk = crawling(board)
    before = fields(talk.greeting)
    board.reset(cause)
    reset_s = board.time_s
    again = Dialogue(board)
    after = fields(again.greeting)
    assert after["reset"] == word
    assert int(after["boot"]) == int(before["boot"]) + 1
    again.obey("hello")
    again.keep_alive(1.0)
    assert all(len(width) == 0 for width in widths(board, reset_s + 0.001))
    assert telemetry(board.lines[-20:]).state[-1] == "idle"


def test_watchdog_ends_a_hang(start):
    """250 ms of watchdog; the servo interrupts run on meanwhile and hold the last setpoints."""
    board = start()
    talk = crawling(board)
    boot = int(fields(talk.greeting)["boot"])
    board.hang()
    hung_s = board.time_s
    after = Dialogue(board)
    assert fields(after.greeting)["reset"] == "watchdog"
    assert int(fields(after.greeting)["boot"]) == boot + 1
    assert board.time_s - hung_s < 0.4
    assert board.counts.resets == 1
    back_s = board.time_s
    board.run(1.0)
    assert all(len(width) == 0 for width in widths(board, back_s))
