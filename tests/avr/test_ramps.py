"""Changes of gait, steering and pose on the real ELF: no clipping, gentle, announced."""

import numpy as np
import pytest
from avr.dialogue import Dialogue, telemetry
from avr.test_pulses import EXTREME_US, P99_US
from avr.truth import FRAME_US, line_errors_us

pytestmark = pytest.mark.avr

FRAME_S = FRAME_US * 1e-6
# (command, how long it then runs in s, its strength A w^2 in degrees/s^2)
STORY = [
    ("gait 50 -80 9.9", 4.0, 4900),
    ("gait 50 80 9.9", 4.0, 4900),
    ("gait 20 60 20", 4.0, 8000),
    ("gait 12 -40 8", 0.5, 768),  # changed again before the change is over
    ("gait 45 100 6 10", 4.0, 1620),
    ("pose 10 -20 30 -40 5", 3.0, 0),
    ("gait 25 75 5", 2.5, 625),
]
# Three setpoints of 0.01 degree each, in a second difference.
ROUNDING_DEG_S2 = 4 * 0.005 / FRAME_S**2


def tell(talk: Dialogue, story) -> list[np.ndarray]:
    """Send the commands one by one; return the angles of each stretch in degrees, (N, joints)."""
    found = []
    for command, seconds, _ in story:
        first = len(talk.board.lines)
        assert talk.ask(command).startswith("ok:"), command
        talk.keep_alive(seconds)
        found.append(np.degrees(telemetry(talk.board.lines[first:]).angle_rad))
    return found


def test_changes_never_clip_are_gentle_and_the_pulses_are_those_announced(start):
    talk = Dialogue(start())
    talk.hello()
    first = len(talk.board.lines)
    stretches = tell(talk, STORY)
    seen = telemetry(talk.board.lines[first:])
    assert not np.any(seen.clipped)
    assert talk.counters()["clipped"] == 0
    whole = np.concatenate(stretches)
    speed = np.abs(np.diff(whole, axis=0)) / FRAME_S
    assert np.max(speed) <= 500 + 0.01 / FRAME_S
    before = 0
    for angle, (command, _, strength) in zip(stretches, STORY, strict=True):
        most = 2 * max(before, strength) + ROUNDING_DEG_S2
        bend = np.abs(np.diff(angle, 2, axis=0)) / FRAME_S**2
        assert np.max(bend) <= most, command
        before = max(before, strength) if command.startswith("gait 12") else strength
    moving = telemetry(talk.board.lines[first:][40:])  # when all servos are attached
    errors = line_errors_us(talk.board, moving)
    assert len(errors) > 5 * 45 * sum(seconds for _, seconds, _ in STORY[1:])
    assert np.percentile(np.abs(errors), 99) <= P99_US
    assert np.max(np.abs(errors)) <= EXTREME_US


def test_what_is_clipped_is_told(start):
    """A servo speed that is cut under a running gait holds its joints back."""
    talk = Dialogue(start())
    talk.hello()
    tell(talk, STORY[:1])
    assert talk.ask("set servo_speed 300").startswith("ok:")
    first = len(talk.board.lines)
    talk.keep_alive(1.0)
    seen = telemetry(talk.board.lines[first:])
    assert np.max(seen.clipped) >= 3
    assert talk.counters()["clipped"] >= 25
    speed = np.abs(np.diff(np.degrees(seen.angle_rad), axis=0)) / FRAME_S
    assert np.max(speed[1:]) <= 300 + 0.03 / FRAME_S
