"""Tests of one joint with hidden servos: what they tell, and what the band of speeds becomes.

For each hidden hobby servo: how far the measured ones are off in the logarithm of each field (mean,
over their own scatter), and the speed of the 2005 robot with it beside the bands before and after.
"""

from __future__ import annotations

import argparse
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
FIRST_SEED = 200


def ratios(servo: sn.Servo) -> dict[str, float]:
    """Return what an unloaded joint can tell: all over the torque, and the speed."""
    line = servo.torque_limit_nm / servo.speed_limit_rad_s
    return {
        "torque": servo.torque_limit_nm,
        "free speed": servo.no_load_rad_s,
        "stiffness": servo.stiffness_nm_rad / servo.torque_limit_nm,
        "damping": servo.damping_nms_rad / line,
        "rotor": servo.armature_kg_m2 / line,
        "gear friction": servo.gear_friction_nm / servo.torque_limit_nm,
        "gear damping": servo.gear_damping_nms_rad / line,
        "dead band": servo.dead_band_rad,
    }


def off(true: sn.Servo, found: tuple[sn.Servo, ...]) -> dict[str, tuple[float, float]]:
    """Return mean error and scatter of the logarithms, by name."""
    rows = [ratios(one) for one in found]
    logs = {n: np.log([max(r[n], 1e-12) for r in rows]) for n in rows[0]}
    want = ratios(true)
    return {n: (v.mean() - math.log(max(want[n], 1e-12)), v.std()) for n, v in logs.items()}


def one(true: sn.Servo, test: BenchTest, before: sn.ServoSteady) -> tuple[dict, bool, float]:
    """Return errors by field, whether the band holds the speed, and how much narrower it is."""
    found = servo_of_test(test, sn.servo()).kind
    crawls = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=true).speed_m_s
    known = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=found)
    narrow = (known.high_m_s - known.low_m_s) / (before.high_m_s - before.low_m_s)
    held = 0.99 * known.low_m_s <= crawls <= 1.01 * known.high_m_s
    return off(true, found.drawn), held, narrow


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--servos", type=int, default=10)
    count = parser.parse_args().servos
    before = sn.steady_gait(ROBOT, GROUND, GAIT, rtol=1e-3, servo=sn.servo())
    for name, camera in (("50 frames a second", shown_by), ("240 frames a second", filmed_by)):
        found = []
        for seed in range(FIRST_SEED, FIRST_SEED + count):
            true = sn.servo().draws(1, seed)[0]
            found.append(one(true, camera(true, seed), before))
        held, narrow = sum(f[1] for f in found), np.median([f[2] for f in found])
        print(f"{name}: speed in its band {held} of {count}; band {narrow:.2f} of the one before")
        for field in found[0][0]:
            error = np.sqrt(np.mean([f[0][field][0] ** 2 for f in found]))
            scatter = np.median([f[0][field][1] for f in found])
            print(f"  {field}: off by {100 * error:.0f} % (rms), stated {100 * scatter:.0f} %")


if __name__ == "__main__":
    main()
