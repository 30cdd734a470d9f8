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
from serpenoid.servos.bench_test import BenchTest, servo_of_test

GROUND = sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
GAIT = sn.Gait(math.radians(70), math.radians(75), math.tau * 0.5)
SEEDS = range(200, 210)


def ratios(servo: sn.Servo) -> dict[str, float]:
    """Return what an unloaded joint can tell: all over the torque, and the speed."""
    line = servo.torque_limit_nm / servo.speed_limit_rad_s
    return {
        "free speed": servo.no_load_rad_s,
        "stiffness": servo.stiffness_nm_rad / servo.torque_limit_nm,
        "rotor": servo.armature_kg_m2 / line,
        "gear friction": servo.gear_friction_nm / servo.torque_limit_nm,
        "dead band": servo.dead_band_rad,
    }


def off(true: sn.Servo, found: tuple[sn.Servo, ...]) -> np.ndarray:
    """Return mean error and scatter of the logarithms, (2, ratios)."""
    rows = [list(ratios(one).values()) for one in (true, *found)]
    first, *others = np.log(np.maximum(rows, 1e-12))
    return np.array([np.mean(others - first, axis=0), np.std(others, axis=0)])


def one(true: sn.Servo, test: BenchTest, before: sn.ServoSteady) -> tuple[np.ndarray, bool, float]:
    """Return errors by field, whether the band holds the speed, and how much narrower it is."""
    found = servo_of_test(test, sn.servo()).kind
    crawls = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=true).speed_m_s
    known = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=found)
    narrow = (known.high_m_s - known.low_m_s) / (before.high_m_s - before.low_m_s)
    held = 0.99 * known.low_m_s <= crawls <= 1.01 * known.high_m_s
    return off(true, found.drawn), held, narrow


def main() -> None:
    """Run the study."""
    before = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=sn.servo())
    for name, camera in (("50 frames a second", shown_by), ("240 frames a second", filmed_by)):
        found = []
        for seed in SEEDS:
            true = sn.servo().draws(1, seed)[0]
            found.append(one(true, camera(true, seed), before))
        held, narrow = sum(f[1] for f in found), np.median([f[2] for f in found])
        print(
            f"{name}: speed in its band {held} of {len(SEEDS)}; band {narrow:.2f} of the one before"
        )
        error, scatter = np.moveaxis([f[0] for f in found], 1, 0)
        for field, e, sigma in zip(ratios(sn.Servo()), error.T, scatter.T, strict=True):
            print(
                f"  {field}: off by {100 * np.sqrt(np.mean(e**2)):.0f} % (rms), stated "
                f"{100 * np.median(sigma):.0f} %; {np.sqrt(np.mean((e / sigma) ** 2)):.2f} of it "
                f"(rms), {np.sum(abs(e) < 1.96 * sigma)} of {len(SEEDS)} within 1.96"
            )


if __name__ == "__main__":
    main()
