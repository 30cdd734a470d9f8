"""Bench tests of hidden servos: how often intervals hold, how wide they are, false alarms.

The hidden servos have offsets, late logs, delays that differ from step to step, D terms and hanging
loads; a code that shares no step with the fit moves them.
"""

from __future__ import annotations

import argparse
import sys
import time
from itertools import chain
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
import serpenoid as sn
from lab.one_joint import drawn, tables_of
from scipy.stats import beta
from serpenoid.servos.bench_fit import MIN_P_VALUE, servo_of_test


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--servos", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="of the servos; for a study in pieces")
    parser.add_argument("--count", type=int, default=None, help="of the servos that are tested")
    arguments = parser.parse_args()
    last = None if arguments.count is None else arguments.first + arguments.count
    hidden = drawn(arguments.servos, arguments.seed)[arguments.first : last]
    errors: dict[str, list[tuple[bool, float, float]]] = {}
    p_values, seconds = [], []
    for servo, test in zip(
        hidden, tables_of(hidden, arguments.seed + arguments.first), strict=True
    ):
        begin = time.process_time()
        fit = servo_of_test(test, sn.servo())
        seconds.append(time.process_time() - begin)
        p_values.append(fit.verdict.p_value)
        for name, true in servo.truth.items():
            stated = fit.determined.get(name)
            if stated is not None:
                is_inside = stated.low <= true <= stated.high
                positive = stated.low > 0 < true
                error = np.log(stated.value / true) if positive else stated.value - true
                errors.setdefault(name, []).append((is_inside, float(error), stated.sigma))
    for name, values in errors.items():
        flags, error, sigma = np.array(values, dtype=float).T
        print(
            f"{name}: inside {flags.sum():.0f} of {flags.size}; "
            f"error {np.sqrt(np.mean(error**2)):.2g} (rms), stated {np.sqrt(np.mean(sigma**2)):.2g}"
        )
    inside = np.array([is_inside for is_inside, _, _ in chain.from_iterable(errors.values())])
    hits, misses = inside.sum(), (~inside).sum()
    low, high = beta.ppf([0.025, 0.975], [hits, hits + 1], [misses + 1, misses])
    low_p, middle_p = np.quantile(p_values, (0.1, 0.5))
    print(
        f"all: {100 * inside.mean():.1f} % of {inside.size} (95 % of it if they were independent: "
        f"{100 * low:.1f} to {100 * high:.1f} %); p-values: a tenth below {low_p:.2g}, half below "
        f"{middle_p:.2g}, {sum(p < MIN_P_VALUE for p in p_values)} false alarms of {len(hidden)}; "
        f"processor time {np.mean(seconds):.1f} s a test, at most {max(seconds):.1f} s"
    )


if __name__ == "__main__":
    main()
