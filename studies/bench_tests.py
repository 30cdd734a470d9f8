"""Bench tests of hidden servos: how often intervals hold, how wide they are, false alarms.

The hidden servos have offsets, late logs, delays that differ from step to step, D terms and hanging
loads; a code that shares no step with the fit moves them.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
import serpenoid as sn
from lab.one_joint import drawn, tables_of
from scipy.stats import beta
from serpenoid.servos.bench_fit import servo_of_test


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--servos", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    hidden = drawn(given.servos, given.seed)
    rows: dict[str, list[tuple[bool, float, float]]] = {}
    alarms, seconds = 0, []
    for one, test in zip(hidden, tables_of(hidden, given.seed), strict=True):
        begin = time.process_time()
        fit = servo_of_test(test, sn.servo())
        seconds.append(time.process_time() - begin)
        alarms += not fit.verdict.describes
        for name, true in one.truth.items():
            shown = fit.shown[name]
            if shown.told:
                held = shown.low <= true <= shown.high
                off = np.log(shown.value / true) if shown.low > 0 < true else shown.value - true
                rows.setdefault(name, []).append((held, float(off), shown.after))
    for name, values in rows.items():
        held, off, sigma = np.array(values, dtype=float).T
        print(
            f"{name}: inside {held.sum():.0f} of {held.size}; off {np.sqrt(np.mean(off**2)):.2g} "
            f"(rms), stated {np.sqrt(np.mean(sigma**2)):.2g}"
        )
    inside = np.array([value[0] for values in rows.values() for value in values])
    held, missed = inside.sum(), (~inside).sum()
    low, high = beta.ppf([0.025, 0.975], [held, held + 1], [missed + 1, missed])
    print(
        f"all: {100 * inside.mean():.1f} % of {inside.size} (95 % of it if they were independent: "
        f"{100 * low:.1f} to {100 * high:.1f} %); false alarms {alarms} of {given.servos}; "
        f"processor time {np.mean(seconds):.1f} s a test, at most {max(seconds):.1f} s"
    )


if __name__ == "__main__":
    main()
