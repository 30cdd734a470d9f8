"""micros(), the frame counter and the sequence number run over without a twitch of the robot."""

from dataclasses import replace

import numpy as np
import pytest
from avr.dialogue import Dialogue, telemetry
from avr.test_pulses import P99_US, observe, settled_gait, wave_of
from avr.truth import FRAME_US, pulse_errors_us

pytestmark = pytest.mark.avr

TCCR0B = 0x45  # data address of timer 0's clock select, both chips
OVERFLOW_US = 1024  # timer 0 counts 256 steps of 4 us; the core counts its overflows in 32 bits
WRAP = 2**32 // OVERFLOW_US


def test_micros_runs_over_in_mid_motion(start):
    board = start()
    while board.ram[TCCR0B] == 0:  # the Arduino core starts its clock just before setup()
        board.run(4e-6)
    before_wrap_s = 8.0
    overflows = WRAP - int(before_wrap_s * 1e6 / OVERFLOW_US)
    board.write_ram("timer0_overflow_count", overflows.to_bytes(4, "little"))
    talk = settled_gait(board)
    seen = observe(talk, 6.0)
    assert seen.time_us[0] > 2**31
    assert seen.time_us[-1] < 2**31, "the clock did not run over"
    assert np.percentile(np.abs(pulse_errors_us(board, seen, wave_of(seen))), 99) <= P99_US
    counters = talk.counters()
    assert counters["overruns"] == 0
    assert counters["late_us"] < FRAME_US / 4


def frame_counters(talk: Dialogue) -> set[tuple[int, int]]:
    """Find the variables that count frames: address, and how far ahead of the line they are."""
    ram = talk.board.ram
    candidates = {(i, ahead) for i in range(len(ram) - 3) for ahead in (0, 1)}
    for _ in range(4):
        frame = int(telemetry([talk.board.run_until("t:", 0.1)]).frame[0])
        ram = talk.board.ram
        candidates = {
            (i, ahead)
            for i, ahead in candidates
            if int.from_bytes(ram[i : i + 4], "little") == frame + ahead
        }
        talk.board.run(0.11)
    return candidates


def test_the_frame_counter_runs_over_in_mid_motion(start):
    talk = settled_gait(start())
    board = talk.board
    counters = frame_counters(talk)
    assert counters, "no variable counts the frames"
    board.run_until("t:", 0.1)
    for address, ahead in counters:
        board.write_at(address, (2**32 - 100 + ahead).to_bytes(4, "little"))
    seen = observe(talk, 4.0)
    assert np.any(seen.frame > 2**31)
    assert (seen.frame[-1] - seen.frame[0]) % 2**32 == len(seen.frame) - 1
    straight = np.where(seen.frame < 2**31, seen.frame + 2**32, seen.frame)
    seen = replace(seen, frame=straight)
    assert np.percentile(np.abs(pulse_errors_us(board, seen, wave_of(seen))), 99) <= P99_US
    assert set(seen.state) == {"gait"}
