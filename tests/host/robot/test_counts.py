"""What a run counts of its frames: missed ones, the latest, clipped ones."""

from __future__ import annotations

import pytest
from serpenoid.model.gait import Gait
from serpenoid.robot.tools.driven_run import DrivenRun
from serpenoid.robot.wire import protocol
from serpenoid.robot.wire.inbox import Inbox


def frame(number: int, late_us: int = 0, clipped: int = 0) -> protocol.Telemetry:
    joints = (0.0,) * 5
    us = 20_000 * number
    return protocol.Telemetry(number, joints, us, 0.0, (1500,) * 5, 400, late_us, clipped, "idle")


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


def test_a_run_keeps_its_latest_frame_and_counts_clipped_ones() -> None:
    run = DrivenRun(Gait(0.5, 1.2, 3.0), "virtual", None)
    for one in (frame(1, 8), frame(2, 900, 1), frame(3, 12, 4)):
        run._count(one)
    assert (run.frames, run.latest_us, run.clipped_frames) == (3, 900, 2)
    assert (run.first.frame, run.last.frame) == (1, 3)
