"""How fast the board's clock runs against the host's, from frames that arrive late by chance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..._core import firmware
from ...base.errors import ClockWrong

FRAME_US = round(firmware.FRAME_S * 1e6)


@dataclass(frozen=True)
class ClockBounds:
    """Bounds within which a board's clock is followed and believed.

    tolerance_ppm: error of a Uno's ceramic resonator, before anything is measured. max_sd_ppm: a
    host may be busy, but arrivals more scattered follow no clock. busy_s: time by which even the
    least delay may change over a run. min_blocks, max_blocks: of time, for a drift and in memory.
    step_us: resolution of the board's micros(). max_hop_us: of its time against its frames.
    """

    tolerance_ppm: float = 5000.0
    max_sd_ppm: float = 200_000.0
    busy_s: float = 0.05
    min_blocks: int = 6
    max_blocks: int = 64
    step_us: float = 4.0
    max_hop_us: int = 60_000_000


BOUNDS = ClockBounds()


@dataclass(frozen=True)
class Drift:
    """How much faster than the host's the board's clock runs, in parts per million, and its s.d.

    span_s: host seconds from which it was found. Until there are enough, it is 0 and the drift
    what the data sheet says of the resonator: 0 +- 5000 ppm. The host's own clock is good to some
    50 ppm alone and to a few when it follows a time server; that is not in sd_ppm.
    """

    ppm: float
    sd_ppm: float
    span_s: float

    def true_rate(self, rate: float) -> tuple[float, float]:
        """Return what a rate per second of the board is per second of the host, and its s.d.

        Raises ClockWrong as check() does.
        """
        self.check()
        return rate * (1 + self.ppm * 1e-6), abs(rate) * self.sd_ppm * 1e-6

    @property
    def believable(self) -> bool:
        """Tell whether the drift is possible for a resonator, or for a host that got busier."""
        busy_ppm = BOUNDS.busy_s / self.span_s * 1e6 if self.span_s else 0.0
        is_steady = self.sd_ppm <= BOUNDS.max_sd_ppm
        return is_steady and abs(self.ppm) <= BOUNDS.tolerance_ppm + busy_ppm + 3 * self.sd_ppm

    def check(self) -> None:
        """Raise ClockWrong if no resonator can be so far off."""
        if not self.believable:
            raise ClockWrong(
                f"the board's clock runs {self.ppm:+.0f} ± {self.sd_ppm:.0f} ppm against this "
                f"computer's; its resonator may be {BOUNDS.tolerance_ppm:.0f} ppm off: is the "
                "firmware built for this board, is this computer too busy to hear it in time?"
            )


class _Arrival(NamedTuple):
    board_s: float
    host_s: float


class BoardClock:
    """Follow the board's clock through its frames, in bounded memory.

    A frame arrives at host = t0 + board / rate + delay, where the delay (wire, USB, a busy host)
    has a sharp lower edge and a long tail. So of each block of time only the frame with the
    least delay counts, and a straight line through those gives the rate; the scatter about it
    gives the s.d. When there are 64 blocks, neighbours are merged and blocks become twice as
    long. Which frame of a block is picked rests on the rate found so far; a wrong rate costs
    some precision only, as every frame obeys the equation above.
    """

    def __init__(self, frame_us: int = FRAME_US) -> None:
        self.frame_us = frame_us
        self._blocks: list[_Arrival] = []
        self._block_s = 0.25
        self._best: _Arrival | None = None
        self._rate = 1.0  # board seconds in one of the host's, as far as known
        self._block_end_s = -math.inf
        self._frame = 0
        self._us = 0
        self._board_us: int | None = None

    def unwrap(self, frame: int, board_us: int) -> int:
        """Return the board's time in us since 0, however often its 32 bits wrapped.

        frame counts 20 ms (or what the greeting says) each on the same clock, so any gap is
        bridged; a frame's lateness is far below half the 71.6 minutes of a wrap. Raises ClockWrong
        if the time hops against the frames, and goes on from there by the frames.
        """
        last_frame, passed_us = self._frame, board_us - self._us
        self._frame, self._us = frame, board_us
        if self._board_us is None:
            self._board_us = board_us
            return board_us
        expected = (frame - last_frame) * self.frame_us
        hop_us = (passed_us - expected + 2**31) % 2**32 - 2**31
        if abs(hop_us) > BOUNDS.max_hop_us:
            self._board_us += expected
            raise ClockWrong(
                f"the board's clock hops by {hop_us / 1e6:.0f} s from frame {last_frame} to "
                f"{frame}; is the firmware built for this board?"
            )
        self._board_us += expected + hop_us
        return self._board_us

    def add(self, host_s: float, frame: int, board_us: int) -> None:
        """Take in a frame that arrived at host_s on the host's clock."""
        arrival = _Arrival(self.unwrap(frame, board_us) * 1e-6, host_s)
        if host_s >= self._block_end_s:
            self._close_block()
            self._block_end_s = host_s + self._block_s
        if self._best is None or self._delay(arrival) < self._delay(self._best):
            self._best = arrival

    def drift(self) -> Drift:
        """Return the drift found so far."""
        blocks = self._blocks
        if len(blocks) < BOUNDS.min_blocks:
            return Drift(0.0, BOUNDS.tolerance_ppm, 0.0)
        slope, sd = _line(blocks)
        span_s = blocks[-1].host_s - blocks[0].host_s
        if not 0 < slope < math.inf:  # it runs backwards, or stands
            return Drift(-1e6, 0.0, span_s)
        return Drift((1 / slope - 1) * 1e6, sd / slope**2 * 1e6, span_s)

    def _delay(self, a: _Arrival) -> float:
        return a.host_s - a.board_s / self._rate

    def _close_block(self) -> None:
        if self._best is not None:
            self._blocks.append(self._best)
        self._best = None
        drift = self.drift()
        self._rate = 1 + drift.ppm * 1e-6 if drift.believable else 1.0
        if len(self._blocks) == BOUNDS.max_blocks:
            pairs = zip(self._blocks[::2], self._blocks[1::2], strict=True)
            self._blocks = [min(pair, key=self._delay) for pair in pairs]
            self._block_s *= 2


def _line(arrivals: list[_Arrival]) -> tuple[float, float]:
    """Fit host against board by least squares: slope, and its s.d. from the scatter.

    The scatter is taken as no smaller than a step of micros(), evenly spread. The slope of a
    board whose clock stands is infinite.
    """
    board_s, host_s = np.transpose(arrivals)
    offset_s = board_s - board_s.mean()
    spread = offset_s @ offset_s
    if not spread:
        return math.inf, math.inf
    slope = offset_s @ host_s / spread
    miss_s = host_s - host_s.mean() - slope * offset_s
    scatter = miss_s @ miss_s / (len(arrivals) - 2)
    return float(slope), math.sqrt(max(scatter, (BOUNDS.step_us * 1e-6) ** 2 / 12) / spread)
