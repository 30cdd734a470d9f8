"""Instruments as a laboratory has them: each with a zero, a scale, a step and a scatter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Instrument:
    """Show scale * true + zero, off by a scatter of its own, in steps. In the quantity's unit.

    step: 0 for one that is read as fine as it is. scatter: standard deviation of one reading.
    """

    zero: float = 0.0
    scale: float = 1.0
    step: float = 0.0
    scatter: float = 0.0

    def shows(self, true: float, rng: np.random.Generator) -> float:
        """Return what is read off."""
        shown = self.scale * true + self.zero + self.scatter * float(rng.normal())
        return round(shown / self.step) * self.step if self.step > 0.0 else shown


RULER_M = Instrument(step=0.005, scatter=0.002)  # Ruler beside the belt, read by eye.
CLOCK_S = Instrument(step=0.01, scatter=0.1)  # Stopwatch in a hand.
EYE_RAD = Instrument(scatter=0.017)  # Eye that sees how far the robot has turned, to a degree.
EYE_M = Instrument(scatter=0.005)  # Eye that sees how far the robot is off the middle.
