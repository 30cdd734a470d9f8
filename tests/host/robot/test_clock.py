"""The board's clock from late frames: true drift within its s.d., wraps and gaps undone."""

from __future__ import annotations

import numpy as np
import pytest
from serpenoid.base.errors import ClockWrong
from serpenoid.robot.wire.clock import BoardClock


def followed(seed: int, ppm: float, duration_s: float):
    """Return the drift found from frames on time, and lines late by wire, USB and a busy host."""
    rng, clock = np.random.default_rng(seed), BoardClock()
    frames = np.arange(int(duration_s / 0.02))
    delay_s = 0.005 + rng.exponential(0.001, frames.size) + rng.uniform(0, 0.004, frames.size)
    delay_s += (rng.random(frames.size) < 0.05) * rng.exponential(0.05, frames.size)
    host_s = 1e5 + np.maximum.accumulate(frames * 0.02 / (1 + ppm * 1e-6) + delay_s)
    board_us = (frames * 20_000 + 4 * rng.integers(0, 3, frames.size)) % 2**32
    for row in zip(host_s.tolist(), frames.tolist(), board_us.tolist(), strict=True):
        clock.add(*row)
    return clock.drift()


@pytest.mark.parametrize("duration_s", [4.0, 60.0])
def test_true_drift_lies_within_its_stated_deviation(duration_s):
    ppms = np.random.default_rng(0).uniform(-5000, 5000, 60)
    found = [followed(seed, ppm, duration_s) for seed, ppm in enumerate(ppms)]
    pulls = np.array([(d.ppm - ppm) / d.sd_ppm for d, ppm in zip(found, ppms, strict=True)])
    # Of 60 normal pulls, 95 % lie within 2; fewer than 50 happen by chance once in 10^4.
    assert np.sum(np.abs(pulls) < 2) >= 50
    assert 0.5 < np.sqrt(np.mean(pulls**2)) < 1.6


@pytest.mark.parametrize("pace", [0.0, 617.3, 0.4, 1.03, 2.5, 1.004])
def test_a_clock_further_off_than_a_resonator_is_an_error(pace):
    """It stands, runs wild, at 0.4, 1.03 and 2.5 times its pace; 1.004 is that of a poor one."""
    clock = BoardClock()
    for frame in range(500):
        clock.add(frame * 0.02, frame, round(pace * 20_000 * frame) % 2**32)
    drift = clock.drift()
    if pace == 1.004:
        assert drift.true_rate(5.0)[0] == pytest.approx(5.0 * pace, rel=1e-6)
    else:
        assert not drift.believable
        with pytest.raises(ClockWrong, match="5000 ppm off"):
            drift.true_rate(5.0)


def test_wraps_and_gaps_longer_than_a_wrap_are_undone():
    clock, start_us = BoardClock(), 2**32 - 50_000
    for frame in [0, 1, 2, 3, 4, 400_000, 400_001, 2_000_000]:  # two hours, then nine
        board_us = frame * 20_000 + 8
        assert clock.unwrap(frame, (start_us + board_us) % 2**32) == start_us + board_us
