"""Tests of one joint with hidden servos: what they tell, and what the band of speeds becomes.

For each hidden hobby servo: how far the measured ones are off in the logarithm of each ratio (mean,
also over their own scatter), and the speed of the 2005 robot with it beside the bands before and
after.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
import serpenoid as sn
from lab.one_joint import ROBOT, filmed_by, shown_by
from serpenoid.servos.bench_test import BenchTest, servo_of_test, shown

GROUND = sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
GAIT = sn.Gait(math.radians(70), math.radians(75), math.tau * 0.5)
SEEDS = range(200, 210)


def one(
    true: sn.Servo, test: BenchTest, before: sn.ServoSteady
) -> tuple[np.ndarray, np.ndarray, bool, float]:
    """Return errors and scatter of the values' logarithms, whether the band holds the speed, and
    how much narrower it is."""
    found = servo_of_test(test, sn.servo()).kind
    first, *others = np.log([list(shown(servo).values()) for servo in (true, *found.drawn)])
    crawls = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=true).speed_m_s
    known = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=found)
    narrow = (known.high_m_s - known.low_m_s) / (before.high_m_s - before.low_m_s)
    held = 0.99 * known.low_m_s <= crawls <= 1.01 * known.high_m_s
    return np.mean(others - first, axis=0), np.std(others, axis=0), held, narrow


def main() -> None:
    """Run the study."""
    before = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=sn.servo())
    servos = [sn.servo().draws(1, seed)[0] for seed in SEEDS]
    for name, camera in (("50 frames a second", shown_by), ("240 frames a second", filmed_by)):
        rows = [one(*pair, before) for pair in zip(servos, map(camera, servos, SEEDS), strict=True)]
        error, scatter, held, narrow = map(np.array, zip(*rows, strict=True))
        print(
            f"{name}: speed in its band {held.sum()} of {len(SEEDS)}; band "
            f"{np.median(narrow):.2f} of the one before"
        )
        for field, e, sigma in zip(shown(servos[0]), error.T, scatter.T, strict=True):
            print(
                f"  {field}: off by {100 * np.sqrt(np.mean(e**2)):.0f} % (rms), stated "
                f"{100 * np.median(sigma):.0f} %; {np.sqrt(np.mean((e / sigma) ** 2)):.2f} of it "
                f"(rms), {np.sum(abs(e) < 1.96 * sigma)} of {len(SEEDS)} within 1.96"
            )


if __name__ == "__main__":
    main()
