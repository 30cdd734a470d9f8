"""All joints in one frame: no refresh mixes two, and a setpoint's age stays what it was."""

import numpy as np
import pytest
from avr.board import F_CPU_HZ
from avr.dialogue import JOINTS, Dialogue, telemetry
from avr.toolchain import ToolchainError
from avr.truth import FRAME_US, line_errors_us

pytestmark = pytest.mark.avr

HANDOVER_US = 3000.0  # PROTOCOL.md: from a frame's due time to the first servo's pulse
PULSE_US = 10.0  # the rare extreme of a pulse whose interrupt was delayed


def running(board, command: str) -> Dialogue:
    """Start a gait with silence off and let it settle."""
    talk = Dialogue(board).obey("hello", "set silence off", command)
    board.run(4.0)
    return talk


def check_frames(talk: Dialogue, seconds: float) -> None:
    """Run for a while, and hold each refresh against the line of the frame that it belongs to."""
    board, first = talk.board, len(talk.board.lines)
    board.run(seconds)
    seen = telemetry(board.lines[first:])
    assert not np.any(seen.clipped)
    due_us = seen.time_us - seen.late_us
    rise_us = board.pulses(0).rise_cycle * (1e6 / F_CPU_HZ) - board.clock_offset_us()
    rise_us = rise_us[(rise_us > due_us[1]) & (rise_us < due_us[-1])]
    row = np.searchsorted(due_us, rise_us, side="right") - 1
    age_us = rise_us - due_us[row]
    assert len(rise_us) >= (seconds - 0.1) / (FRAME_US * 1e-6)
    assert np.ptp(age_us) <= 100, "a setpoint's age wanders"
    assert np.median(age_us) == pytest.approx(HANDOVER_US, abs=50)
    assert np.all(np.diff(seen.frame) == 1)
    # Each pulse is the one that the line of its refresh's frame announced: none of another frame.
    errors = line_errors_us(board, seen)
    assert len(errors) >= JOINTS * 0.95 * len(seen.frame)
    assert np.max(np.abs(errors)) <= PULSE_US


@pytest.mark.parametrize("name", ["uno", pytest.param("mega", marks=pytest.mark.slow)])
def test_no_refresh_mixes_frames_and_age_is_constant(start, name):
    """At 10 rad/s neighbouring frames are 60 us apart at the steepest: a mixed one shows."""
    check_frames(running(start(name), "gait 45 80 10"), 6.0)


def test_more_joints_than_a_board_has_memory_for_are_not_built(firmware_elf):
    """With twelve the stack ran into the variables, and the board started again and again."""
    with pytest.raises(ToolchainError, match="8 joints at most: take a Mega"):
        firmware_elf("uno", 9)
