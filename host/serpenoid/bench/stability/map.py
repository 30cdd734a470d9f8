"""Where each fixed step is stable: measured growth beside the theory that refuses it beforehand.

A cell (method, n, c, k, dt) runs the paper's bent snake twice, past the check that would refuse it,
from starts that differ by a nanometre in the gaps. What the difference does from the second quarter
of the steps to the last is measured: no accuracy is asked, only whether an error grows. A run
that stays finite and bounded while it is metres off is unstable by this, as it should be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from ... import _core
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.link_state import LinkState
from ...model.robot import Robot
from ...simulation.core_run import core_request
from ...simulation.methods import METHODS
from ...simulation.scene import Scene
from ...simulation.stability import largest_stable_step_s
from ...simulation.starts import start_state
from ..child_process import Crashed, Failed, Limited, Overran
from ..problems import Array

NUDGE_M = 1e-9
GROWN = 10.0  # over the second half of the steps: 0.4 % a step of 1200
LOOKS = 20
TORN = 0.1  # of a link: a joint that opens so far, and 30 times as far as at the start
FAR_M = 1e-4  # a difference that has come this far from NUDGE_M has grown, however it goes on
WORDS = ("stable, runs", "unstable, refused", "refused, no growth seen", "unstable, yet runs")
LIMIT_S = 30.0  # of processor time, for a line of cells over dt


@dataclass(frozen=True, slots=True)
class Grid:
    """Hold the points of a map: n links, c N s/m, k N/m, dt s, and the steps of each run."""

    links: tuple[int, ...]
    damping: tuple[float, ...]
    stiffness: tuple[float, ...]
    dt_s: tuple[float, ...]
    steps: int


def _digits(x: float, digits: int) -> float:
    return float(f"{x:.{digits}g}")


def _decades(low: int, high: int, per_decade: int) -> tuple[float, ...]:
    """Return points evenly apart, of four digits each as their file has them."""
    points = np.logspace(low, high, (high - low) * per_decade + 1)
    return tuple(_digits(x, 4) for x in points)


FULL = Grid((2, 6, 50, 200), (0.0, 1.0, 1e3, 1e5), _decades(2, 9, 2), _decades(-5, -1, 3), 1200)
QUICK = Grid((2, 6), (0.0, 1e3), _decades(2, 8, 1), _decades(-5, -1, 2), 600)


@dataclass(frozen=True, slots=True)
class Cell:
    """Hold one cell: growth of a difference over half the steps, and what the theory says.

    growth: inf where the run left the finite numbers or went far. limit_s: the longest stable step
    by the theory (0: none). refused: 1 where dt is longer. note: why there is no measurement.
    """

    method: str
    links: int
    damping_n_s_m: float
    stiffness_n_m: float
    dt_s: float
    growth: float
    limit_s: float
    refused: int
    note: str = ""

    @property
    def kind(self) -> int:
        """Return which of WORDS the cell is; without a measurement it is the last, the worst."""
        if self.note:
            return 3
        return (0, 3, 2, 1)[2 * int(self.refused) + (self.growth > GROWN)]


def fixed_step_methods() -> list[str]:
    """Return the methods that take fixed steps in the implicit formulation."""
    return [
        name
        for name, kind in METHODS.items()
        if "implicit" in kind.formulations and "implicit" not in kind.adaptive
    ]


def scene_of(method: str, links: int, damping: float, stiffness: float) -> Scene:
    """Return the paper's scene with other numbers, its gait all but stopped, at rest.

    A moving gait pumps soft springs without dampers: their growth is the model's, not the method's.
    """
    beta = min(math.radians(80), 4 * math.pi / links)
    return Scene(
        Robot(links, 1.0, 0.12),
        Ground(ct=0.1, cn=10.0),
        Gait(math.radians(30), beta, 1e-3),
        formulation="implicit",
        joint_stiffness_n_m=stiffness,
        joint_damping_n_s_m=damping,
        method=method,
        dt_s=1e-3,
        record_every=1,
        gap="zero",
    )


def _gaps(scene: Scene, start: LinkState, steps: int) -> Array | None:
    """Run the core past the check of the step; return gaps (T, n-1, 2), None if it diverged."""
    request = core_request(scene)
    request.duration_s, request.steps = steps * scene.dt_s, steps
    request.every = steps // LOOKS
    run, half = _core.run(request, start.packed(), None), scene.robot.link_length_m / 2
    if run["failed_at"] >= 0:
        return None
    turned = (("x_m", np.cos(run["theta_rad"])), ("y_m", np.sin(run["theta_rad"])))
    gaps = [np.diff(run[name], axis=1) - half * (t[:, 1:] + t[:, :-1]) for name, t in turned]
    return np.stack(gaps, axis=2)


def growth(scene: Scene, steps: int) -> float:
    """Return by what a difference of two runs grows from the second quarter to the last.

    inf when it or the gaps themselves came far at any look: two runs that are both metres off may
    well agree in the end.
    """
    start, rng = start_state(scene), np.random.default_rng(1)
    nudged = start.packed()
    nudged[: 2 * scene.robot.links] += NUDGE_M * rng.normal(size=2 * scene.robot.links)
    one = _gaps(scene, start, steps)
    other = _gaps(scene, LinkState(*nudged.reshape(6, -1)), steps)
    if one is None or other is None:
        return math.inf
    apart, open_m = np.abs(other - one).max(axis=(1, 2)), np.abs(one).max(axis=(1, 2))
    torn = open_m.max() > max(TORN * scene.robot.link_length_m, 30 * open_m[0])
    if torn or not apart.max() < FAR_M:
        return math.inf
    # undamped modes beat: the largest of several looks; and positions are rounded to some 1e-14
    early, late = apart[LOOKS // 4 : LOOKS // 2].max(), apart[-LOOKS // 4 :].max()
    return float(late / max(early, 1e-13))


def line_of_growth(line: tuple[Any, ...], dts: Sequence[float], steps: int) -> list[float]:
    """Return the growth at each dt; line: what `scene_of` takes."""
    scene = scene_of(*line)
    return [growth(replace(scene, dt_s=dt, duration_s=dt), steps) for dt in dts]


def measure(grid: Grid, tell: Callable[[str], None]) -> Iterator[Cell]:
    """Yield every cell of a grid for every method of fixed steps."""
    axes = (fixed_step_methods(), grid.links, grid.damping, grid.stiffness)
    with Limited() as child:
        for method, links, damping, stiffness in product(*axes):
            case = (method, links, damping, stiffness)
            if stiffness == grid.stiffness[0]:
                tell(f"map of {method}, {links} links, c = {damping:g} N s/m ...")
            limit, note = min(1.0, largest_stable_step_s(scene_of(*case))), ""
            try:
                values = child(LIMIT_S, line_of_growth, case, grid.dt_s, grid.steps)
            except (Overran, Crashed, Failed) as failure:
                values, note = [math.nan] * len(grid.dt_s), str(failure)
            for dt, value in zip(grid.dt_s, values, strict=True):
                yield Cell(*case, dt, _digits(value, 3), _digits(limit, 3), int(dt > limit), note)
