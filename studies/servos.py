"""Hold speeds with servos to the full simulation: random robots, grounds, gaits and servos.

The full simulation of a case takes seconds, so its speed is kept in FILE, a CSV; a second call
goes on there. It goes from event to event, and shares the law of the servo alone with the quick
state. A case counts where the full simulation has a speed: it settles, also to 0.5 % of the speed
over eight cycles, or over 64 cycles where eight do not.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
import serpenoid as sn
from periodic.servo_cases import drawn_case, full_speeds

CYCLES, MORE_CYCLES, DRIFT = 8, 64, 0.005
FIRST_SEED = 4000  # cases that nobody looked at while the solver was written


@dataclass(frozen=True)
class Quick:
    """One case by the quick state: its speed, m/s, the claimed relative error, and its cost."""

    speed_m_s: float
    error: float
    seconds: float


def full_speed(seed: int) -> float:
    """Return the speed of the full simulation, m/s; NaN where it has none."""
    robot, ground, gait, servo = drawn_case(seed)
    try:
        ideal = sn.steady_gait(robot, ground, gait, rtol=1e-4)
        for keep in (CYCLES, MORE_CYCLES):
            speeds, drift = full_speeds(ideal, servo, keep=keep)
            if abs(drift) <= DRIFT * speeds.mean():
                return float(speeds.mean())
    except (sn.NotConverged, sn.Diverged):
        pass
    return float("nan")


def quick(seed: int) -> Quick | None:
    """Return the quick state of a case; None where it says that it does not settle."""
    robot, ground, gait, servo = drawn_case(seed)
    try:
        sn.steady_gait(robot, ground, gait, rtol=1e-3, powers=False)
        begin = time.process_time()
        found = sn.steady_gait(robot, ground, gait, rtol=1e-3, servo=servo)
    except sn.NotConverged:
        return None
    return Quick(found.speed_m_s, found.error_estimate, time.process_time() - begin)


def known(path: Path) -> dict[int, float]:
    """Return the full simulations' speeds that a file holds, by seed."""
    if not path.exists():
        return {}
    with path.open(newline="") as file:
        return {int(seed): float(speed) for seed, speed in csv.reader(file)}


def show(found: dict[int, tuple[float, Quick | None]]) -> None:
    """Print how far the quick states are off, and what they cost."""
    kept = {s: (full, q) for s, (full, q) in found.items() if q is not None and not np.isnan(full)}
    off = np.array([q.speed_m_s / full - 1 for full, q in kept.values()])
    claimed = np.array([q.error for _, q in kept.values()])
    spent = 1e3 * np.array([q.seconds for _, q in kept.values()])
    refused = sum(q is None for _, q in found.values())
    print(
        f"{len(found)} cases; {len(kept)} compared; the quick state refuses {refused}, "
        f"{np.isnan([full for full, _ in found.values()]).sum()} full simulations do not settle"
    )
    far = np.abs(off)
    for limit in (0.01, 0.02):
        print(f"within {100 * limit:g} %: {100 * np.mean(far < limit):.1f} %")
    print(
        f"95 % are within {100 * np.quantile(far, 0.95):.2f} %, median {100 * np.median(far):.2f} %"
    )
    print(
        f"claimed error holds in {100 * np.mean(far <= claimed):.1f} %; claimed: median "
        f"{100 * np.median(claimed):.2f} %, 95 % {100 * np.quantile(claimed, 0.95):.1f} %"
    )
    print(
        f"processor time (ms): median {np.median(spent):.0f}, 95 % {np.quantile(spent, 0.95):.0f}, "
        f"over 50 ms {100 * np.mean(spent > 50):.1f} %"
    )


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, help="CSV of the full simulations' speeds, by seed")
    parser.add_argument("--cases", type=int, default=300)
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    given = parser.parse_args()
    speeds, found = known(given.file), {}
    for seed in range(given.first_seed, given.first_seed + given.cases):
        if seed not in speeds:
            speeds[seed] = full_speed(seed)
            with given.file.open("a", newline="") as file:
                csv.writer(file).writerow([seed, speeds[seed]])
        found[seed] = (speeds[seed], quick(seed))
    show(found)


if __name__ == "__main__":
    main()
