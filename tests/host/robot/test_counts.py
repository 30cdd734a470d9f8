"""What a run counts of its frames: those that were missed."""

from __future__ import annotations

import pytest
from serpenoid.robot.wire.inbox import Inbox


@pytest.mark.parametrize(
    ("every", "numbers", "missed"),
    [(1, (3, 4, 7), 2), (5, (5, 10, 15), 0), (5, (5, 20), 2), (5, (2**32 - 5, 0, 5), 0)],
)
def test_missed_frames_are_counted_at_the_boards_cadence(every, numbers, missed) -> None:
    inbox = Inbox()
    inbox.every = every
    for number in numbers:
        inbox._count_missed(number)
    assert inbox.losses.missed_frames == missed
