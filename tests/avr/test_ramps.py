"""Changes of gait, steering and pose: pulses against formula, and no jump anywhere."""

import numpy as np
import pytest
from avr.dialogue import JOINTS, Dialogue, telemetry
from avr.ramps import RampedGait, Table
from avr.test_pulses import EXTREME_US, P99_US
from avr.truth import pulse_errors_us

pytestmark = pytest.mark.avr

# (command, how long it then runs in s)
STORY = [
    ("gait 30 80 5", 2.0),
    ("gait 30 80 9", 1.5),
    ("gait 12 -40 2.5", 1.0),  # changed again before its ramps are over
    ("gait 45 100 4 10", 4.0),
    ("gait 20.5 60.25 6.125 -20", 2.5),
    ("pose 10 -20 30 -40 5", 3.0),
    ("gait 25 75 5", 2.5),
    ("pose straight", 3.0),
]


def tell(talk: Dialogue, story) -> Table:
    """Send the commands in mid-frame; return the truth from the first command's frame on."""
    truth, widths = RampedGait(), []
    start = next_frame = None
    for command, seconds in story:
        # After a frame's telemetry has begun, the next frame is some 15 ms off: there is no doubt
        # in which frame a command sent now takes effect.
        seen = talk.board.run_until("t:", 0.1)
        frame = int(telemetry([seen]).frame[0]) + 1
        start = start if start is not None else frame
        while next_frame is not None and next_frame < frame:
            widths.append(truth.frame())
            next_frame += 1
        next_frame = frame
        assert talk.ask(command).startswith("ok:"), command
        word, *numbers = command.replace("straight", "0 0 0 0 0").split()
        getattr(truth, word)(*map(float, numbers))
        talk.keep_alive(seconds)
    end = int(telemetry(talk.board.lines[-30:]).frame[-1])
    widths += [truth.frame() for _ in range(next_frame, end + 2)]
    return Table(start, np.array(widths))


def test_pulses_follow_the_formula_through_every_change(start):
    board = start()
    talk = Dialogue(board)
    talk.hello()
    first = len(board.lines)
    table = tell(talk, STORY)
    lines = telemetry(board.lines[first:])
    moving = np.flatnonzero(lines.frame >= table.first_frame + 1)[0]
    seen = telemetry(board.lines[first:][moving:])
    errors = pulse_errors_us(board, seen, table)
    assert len(errors) >= JOINTS * 45 * sum(seconds for _, seconds in STORY)
    assert np.percentile(np.abs(errors), 99) <= P99_US
    assert np.max(np.abs(errors)) <= EXTREME_US


def test_no_setpoint_jumps(start):
    """Between two pulses no joint moves more than servo_speed allows in 20 ms."""
    board = start()
    talk = Dialogue(board)
    talk.hello()
    assert talk.ask("set servo_speed 300").startswith("ok:")
    tell(talk, STORY[:2] + STORY[5:7])
    most_us = 300 * np.pi / 180 * 0.02 * 573 + EXTREME_US
    for joint in range(JOINTS):
        assert np.max(np.abs(np.diff(board.pulses(joint).width_us))) <= most_us


@pytest.mark.parametrize(
    ("command", "error"),
    [
        ("gait 95 80 5", "range"),
        ("gait 60 80 5 40", "range"),
        ("gait 60 80 20", "speed"),
        ("gait 30 80 nan", "number"),
        ("gait 30 80", "arguments"),
        ("pose 0 0 0 0 95", "range"),
        ("wriggle", "command"),
    ],
)
def test_a_refused_command_changes_nothing(start, command, error):
    board = start()
    talk = Dialogue(board)
    talk.hello()
    verdict = talk.ask(command)
    assert verdict.startswith("err:")
    assert verdict.split()[2] == error
    board.run(0.2)
    assert len(board.edges) == 0
