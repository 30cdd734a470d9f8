"""Time what a link costs in chains of 20 to 1000 links: every model is linear in their number."""

from __future__ import annotations

import math
import platform
import time
from dataclasses import replace

import numpy as np
import serpenoid as sn
from serpenoid import _core
from serpenoid.simulation.core_run import core_request
from serpenoid.simulation.starts import start_state

LINKS = (20, 50, 100, 300, 1000)
GAIT, GROUND = sn.Gait(math.radians(20), math.radians(25), 5.0), sn.Ground(0.1, 10.0)
LINK_STEPS = 200_000  # of one run, whatever the number of links


def scene(links: int, formulation: str, case: str) -> sn.Scene:
    """Return a run of as many link steps as any other: a small step, no records but the end."""
    steps = LINK_STEPS // links
    drive: dict = {}
    if case == "torque":
        drive = {"drive": "torque", "torque": np.zeros(links - 1)}
    if case == "mixed":
        drive = {
            "limp": tuple(range(2, links, 3)),
            "locked": dict.fromkeys(range(3, links, 3), 0.1),
        }
    return sn.Scene(
        sn.Robot(links, 1.0, 0.12),
        GROUND,
        GAIT,
        formulation=formulation,
        **drive,
        dt_s=1e-5,
        duration_s=steps * 1e-5,
        record_every=steps,
        gap="zero",
    )


def per_link_step_ns(formulation: str, case: str, repeats: int = 9) -> list[float]:
    """Return median processor times by link of an RK4 step, ns, for all LINKS, taken in turns.

    What a run costs besides its steps is taken off by a run of one step.
    """
    runs = []
    for links in LINKS:
        whole = scene(links, formulation, case)
        one = replace(whole, duration_s=whole.dt_s, record_every=1)
        start = start_state(whole).packed()
        runs += [(core_request(each), start) for each in (whole, one)]
    times = np.empty((repeats, len(runs)))
    for k in range(repeats):
        for i, (request, start) in enumerate(runs):
            began = time.process_time()
            _core.run(request, start, None)
            times[k, i] = time.process_time() - began
    whole_s, one_s = np.median(times, axis=0).reshape(-1, 2).T
    return list((whole_s - one_s) / LINK_STEPS * 1e9)


def main() -> None:
    """Print a table: ns by link and RK4 step, and the longest chain's over the shortest's."""
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")
    print(f"{'ns a link and RK4 step':28}" + "".join(f"{n:>8}" for n in LINKS) + "   ratio")
    for formulation in ("explicit", "implicit"):
        for case in ("angle", "torque", "mixed"):
            cost = per_link_step_ns(formulation, case)
            row = "".join(f"{c:8.0f}" for c in cost)
            print(f"{formulation + ', ' + case:28}{row}{cost[-1] / cost[0]:8.2f}")


if __name__ == "__main__":
    main()
