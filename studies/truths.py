"""Hold runs in time, and what they claim, to the references of tests/oracle: hard kinds.

`springs`: k from 1e2 to 1e9 N/m, every method. `free`: torques and servos on dry ground, the cases
of an event-driven solver's table.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
import serpenoid as sn
from serpenoid.simulation.core_run import start_state
from serpenoid.simulation.stability import largest_stable_step_s
from simulation import truth_cases as tc

METHODS = ("radau", "dop853", "rk4", "nonsmooth", "paper")
MOST_STEPS = 4e6
SMALL_ERROR = 1e-8  # relative: counted as exact


def size(run: sn.Run) -> float:
    """Return what a run claims to be off, in body lengths and radians."""
    return run.error_estimate.integration.size(run.scene.robot.body_length_m)


def stable(scene: sn.Scene) -> sn.Scene | None:
    """Return a scene with half its largest stable step, 1 ms at most; None for too many steps."""
    if scene.adaptive:
        return replace(scene, dt_s=0.01)
    longest = min(1e-3, 0.5 * largest_stable_step_s(scene))
    if longest * MOST_STEPS < scene.duration_s:
        return None
    return replace(scene, dt_s=scene.duration_s / math.ceil(scene.duration_s / longest))


def springs(rounds: int) -> None:
    """Print true error / claimed error / processor time for k x method, and the worst ratio."""
    worst, count = 0.0, 0
    print("| k (N/m) | the springs | " + " | ".join(METHODS) + " |")
    for links, incline in ((6, 0.0), (2, 0.0), (2, 0.1), (6, 0.1), (20, 0.0), (20, 0.1)):
        for k in 10.0 ** np.arange(2, 10):
            scene = tc.hard_scene(links, k, incline)
            truth, _ = tc.end_of(scene, start_state(scene))
            cells, soft = [], math.nan
            for method in METHODS:
                case = stable(replace(scene, method=method))
                if case is None:
                    cells.append("too many steps")
                    continue
                begin = time.process_time()
                for _ in range(rounds):
                    run = sn.simulate(case)
                took = (time.process_time() - begin) / rounds
                true, claim = tc.off(tc.places(run)[-1], truth, scene.robot), size(run)
                if method == "dop853":
                    soft = run.error_estimate.modelling.size(scene.robot.body_length_m)
                worst, count = max(worst, max(true, 1e-10) / max(claim, 1e-10)), count + 1
                cells.append(f"{true:.0e} / {claim:.0e} / {took * 1e3:.2g} ms")
            print(
                f"| {links} links, {incline:g} rad, {k:.0e} | {soft:.1e} | "
                + " | ".join(cells)
                + " |",
                flush=True,
            )
    print(f"{count} runs: the largest true error over the claimed one is {worst:.3f}")


def free() -> None:
    """Print how far runs with torques and servos are off at three tolerances."""
    cases = 10
    for kind in ("torque", "table", "servo", "full"):
        distance: dict[float, list[float]] = {1e-6: [], 1e-9: [], 1e-12: []}
        ratios = []
        for seed in range(cases):
            scene = tc.free_case(kind, seed, duration_s=0.2)
            runs = [sn.simulate(replace(scene, tolerance=t)) for t in distance]
            truth = np.array(tc.DRY_RUNS[f"{kind} {seed}"]["places"])
            for t, run in zip(distance, runs, strict=True):
                error = tc.off(tc.places(run)[10::10], truth, scene.robot)
                distance[t].append(error)
                if run.error_estimate.settled:
                    ratios.append(max(error, 1e-9) / max(size(run), 1e-9))
        line = "; ".join(
            f"{t:g}: median {np.median(e):.0e}, "
            f"within 1e-8 {np.mean(np.array(e) < SMALL_ERROR):.0%}"
            for t, e in distance.items()
        )
        print(
            f"{kind}: {cases} cases, {line}; largest true over claimed {max(ratios):.2f}",
            flush=True,
        )


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("springs", "free"))
    parser.add_argument("--rounds", type=int, default=1, help="runs that a time is the mean of")
    arguments = parser.parse_args()
    if arguments.what == "springs":
        springs(arguments.rounds)
    else:
        free()


if __name__ == "__main__":
    main()
