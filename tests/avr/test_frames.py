"""All joints in one frame: no refresh mixes two, and a setpoint's age stays what it was."""

import numpy as np
import pytest
from avr.board import F_CPU_HZ
from avr.dialogue import Dialogue, fields, telemetry
from avr.toolchain import ToolchainError
from avr.truth import line_errors_us

pytestmark = pytest.mark.avr

HANDOVER_US = 3000.0  # PROTOCOL.md: from a frame's due time to the first servo's pulse
PULSE_US = 10.0  # the rare extreme of a pulse whose interrupt was delayed


def running(board, command: str) -> Dialogue:
    """Start a gait with silence off and let it settle."""
    talk = Dialogue(board).obey("hello", "set silence off", command)
    board.run(4.0)
    return talk


def check_frames(talk: Dialogue, seconds: float, joints: int, frame_us: int = 20_000) -> None:
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
    assert len(rise_us) >= (seconds - 0.1) / (frame_us * 1e-6)
    assert np.ptp(age_us) <= 100, "a setpoint's age wanders"
    assert np.median(age_us) == pytest.approx(HANDOVER_US, abs=50)
    assert np.all(np.diff(seen.frame) == 1)
    # Each pulse is the one that the line of its refresh's frame announced: none of another frame.
    errors = line_errors_us(board, seen, frame_us)
    assert len(errors) >= joints * 0.95 * len(seen.frame)
    assert np.max(np.abs(errors)) <= PULSE_US


@pytest.mark.parametrize("name", ["uno", pytest.param("mega", marks=pytest.mark.slow)])
def test_no_refresh_mixes_frames_and_age_is_constant(start, name):
    """At 10 rad/s neighbouring frames are 60 us apart at the steepest: a mixed one shows."""
    check_frames(running(start(name), "gait 45 80 10"), 6.0, 5)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "joints", "frame_us"), [("uno", 6, 20_000), ("mega", 8, 22_500)])
def test_other_numbers_of_joints(start, name, joints, frame_us):
    talk = Dialogue(start(name, joints=joints))
    said = fields(talk.greeting)
    assert (int(said["joints"]), int(said["frame_us"])) == (joints, frame_us)
    pose = " ".join(f"{(-1) ** j * (10 + j)}.123456" for j in range(joints))
    talk.obey("hello", f"trim {joints} centre 1510", "set silence off", f"pose {pose}")
    talk.board.run(2.5)
    seen = telemetry(talk.board.lines[-5:])
    assert np.degrees(seen.angle_rad[-1, -1]) == pytest.approx(float(pose.split()[-1]), abs=0.01)
    talk.obey("save unattended", "gait 45 80 8")
    talk.board.run(4.0)
    check_frames(talk, 4.0, joints, frame_us)
    after = Dialogue(start(name, talk.board.eeprom, joints=joints))
    assert fields(after.greeting)["settings"] == "ok"


def test_more_joints_than_a_board_has_memory_for_are_not_built(firmware_elf):
    """With twelve the stack ran into the variables, and the board started again and again."""
    with pytest.raises(ToolchainError, match="8 joints at most: take a Mega"):
        firmware_elf("uno", 9)


@pytest.mark.slow
def test_pulses_as_long_as_they_can_be_leave_their_gap(start):
    """Eight joints at 2.4 ms each are 19.2 ms of pulses: the refresh is stretched for them."""
    talk = running(start("mega", joints=8), "gait 88 0 5")
    check_frames(talk, 4.0, 8, 22_500)
