"""Where each fixed step is stable: measured growth beside the rule that refuses it beforehand.

A cell (method, links, friction, c, k, dt) runs the paper's bent snake twice, past the check that
would refuse it, from starts that differ by a nanometre in the gaps. What the difference does from
the second quarter of the steps to the last is measured: no accuracy is asked, only whether an error
grows. A run that stays finite and bounded while it is metres off is unstable by this.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, product
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import Diverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.link_state import LinkState
from ..model.robot import Robot
from ..show.plot import figure, heading
from ..simulation.scene import METHODS, Scene
from ..simulation.simulate import run_core, start_state
from ..simulation.stability import largest_stable_step_s
from .child_process import Limited
from .problems import Array

UNSTABLE_GROWTH = 10.0  # Growth over the second half of the steps: 0.4 % a step of 1200.
KINDS = {
    "stable, runs": "#9ecae1",
    "unstable, refused": "#f4a582",
    "refused, no growth seen": "#fde0b8",
    "SILENTLY WRONG": "#b2182b",
}  # Kinds of cells, and their colours in the figure.
Line = tuple[str, int, float, float, float]


@dataclass(frozen=True, slots=True)
class Cell:
    """Hold one cell: growth of a difference over half the steps, and what the rule says.

    growth: inf where the run left the finite numbers or went far, nan where there is no answer;
    note says why. limit_s: the longest stable step by the rule.
    """

    method: str
    links: int
    friction_n_s_m: float
    damping_n_s_m: float
    stiffness_n_m: float
    dt_s: float
    growth: float
    limit_s: float
    note: str = ""

    @property
    def kind(self) -> str:
        """Return which of KINDS the cell is."""
        refused, grows = self.dt_s > self.limit_s, not self.growth <= UNSTABLE_GROWTH
        return list(KINDS)[(0, 3, 2, 1)[2 * refused + grows]]


def fixed_step_methods() -> list[str]:
    """Return the methods that take fixed steps in the implicit formulation."""
    return [
        name
        for name, kind in METHODS.items()
        if "implicit" in kind.formulations and "implicit" not in kind.adaptive
    ]


def scene_of(method: str, links: int, friction: float, damping: float, stiffness: float) -> Scene:
    """Return the paper's scene with other numbers, its gait all but stopped, at rest.

    A moving gait pumps soft springs without dampers: their growth is the model's, not the method's.
    """
    beta = min(math.radians(80), 4 * math.pi / links)
    return Scene(
        Robot(links, 1.0, 0.12),
        Ground(ct=0.1, cn=friction),
        Gait(math.radians(30), beta, 1e-3),
        formulation="implicit",
        joint_stiffness_n_m=stiffness,
        joint_damping_n_s_m=damping,
        method=method,
        record_every=1,
        gap="zero",
    )


def gap_m(robot: Robot, run: dict[str, Any]) -> Array:
    """Return Delta_i, how far each joint is open (Eqs. 53-56), m, (T, n-1, 2)."""
    centre, along = run["x_m"] + 1j * run["y_m"], np.exp(1j * run["theta_rad"])
    gap = np.diff(centre, axis=1) - robot.link_length_m / 2 * (along[:, 1:] + along[:, :-1])
    return np.stack([gap.real, gap.imag], axis=2)


def growth(scene: Scene, steps: int) -> float:
    """Return by what a difference of two runs grows from the second quarter to the last.

    inf when it or the gaps themselves came far at any sample: two runs that are both metres off may
    well agree in the end.
    """
    scene = replace(scene, duration_s=steps * scene.dt_s, record_every=steps // 20)
    start, rng = start_state(scene), np.random.default_rng(1)
    nudged = start.packed()
    nudged[: 2 * scene.robot.links] += 1e-9 * rng.normal(size=2 * scene.robot.links)
    starts = start, LinkState(*nudged.reshape(6, -1))
    try:  # past the check of the step, which simulate makes
        plain, moved = (gap_m(scene.robot, run_core(scene, state)) for state in starts)
    except Diverged:
        return math.inf
    apart, open_m = np.abs(moved - plain).max(axis=(1, 2)), np.abs(plain).max(axis=(1, 2))
    # A joint is torn if it opens by 0.1 link lengths and 30 times as far as at the start.
    torn = open_m.max() > max(0.1 * scene.robot.link_length_m, 30 * open_m[0])
    far_m = 1e-4  # A nudge that has become so large has grown, however it goes on.
    if torn or not apart.max() < far_m:
        return math.inf
    # Undamped modes beat: the largest of five samples; and positions are rounded to some 1e-14.
    early, last = apart[5:10].max(), apart[-5:].max()
    return float(last / max(early, 1e-13))


def line_of_growth(line: Line, steps_s: Sequence[float], count: int) -> list[float]:
    """Return the growth at each dt; line: what `scene_of` takes."""
    return [growth(replace(scene_of(*line), dt_s=dt), count) for dt in steps_s]


def measure(quick: bool, tell: Callable[[str], None]) -> Iterator[Cell]:
    """Yield every cell of a map for every method of fixed steps."""
    # The axes are links, cn in N s/m, c in N s/m, and k in N/m.
    axes = (2, 6), (10.0, 1e4), (0.0, 1.0, 1e3, 1e5), np.logspace(2, 9, 15).tolist()
    steps_s, count = np.logspace(-5, -1, 13).tolist(), 1200
    if quick:
        axes = (6,), (10.0, 1e4), (0.0, 1e3), np.logspace(2, 8, 7).tolist()
        steps_s, count = np.logspace(-5, -1, 9).tolist(), 600
    with Limited() as child:
        for method in fixed_step_methods():
            tell(f"map of stability: {method} ...")
            lines: Any = product((method,), *axes)
            for line in lines:
                limit_s = largest_stable_step_s(scene_of(*line))
                values, note = child(30.0, line_of_growth, line, steps_s, count)
                for dt_s, value in zip(steps_s, values or cycle([math.nan]), strict=False):
                    yield Cell(*line, dt_s=dt_s, growth=value, limit_s=limit_s, note=note)


def stability_figure(cells: Sequence[Cell], path: Path) -> None:
    """Draw all methods downwards, low and high friction and damping to the right, of 6 links."""
    panels: dict[tuple[str, float, float], list[Cell]] = {}
    links, damping_n_s_m = 6, (0.0, 1e3)
    for cell in cells:
        if cell.links == links and cell.damping_n_s_m in damping_n_s_m:
            panel = cell.method, cell.friction_n_s_m, cell.damping_n_s_m
            panels.setdefault(panel, []).append(cell)
    methods = list(dict.fromkeys(method for method, *_ in panels))
    columns = len(panels) // len(methods)
    size = 2.9 * columns + 0.8, 2.0 * len(methods) + 1.3
    grid = {"rows": len(methods), "squeeze": False, "sharex": True, "sharey": True}
    with figure(*size, columns, path=path, **grid) as (fig, axes):
        for ax, ((_, friction, damping), inside) in zip(axes.flat, panels.items(), strict=True):
            for kind, colour in KINDS.items():
                points = [(cell.stiffness_n_m, cell.dt_s) for cell in inside if cell.kind == kind]
                ax.scatter(*np.reshape(points, (-1, 2)).T, c=colour, marker="s", s=45, label=kind)
            stiffness = [cell.stiffness_n_m for cell in inside]
            limits = [cell.limit_s for cell in inside]
            ax.plot(stiffness, limits, color="black", lw=1.4, label="limit by the rule")
            ax.set(xscale="log", yscale="log", ylim=(5e-6, 0.2))
            ax.grid(visible=False)
            ax.set_title(f"$c_n$ = {friction:g}, c = {damping:g} N s/m", fontsize=9)
        for ax, method in zip(axes[:, 0], methods, strict=True):
            ax.set_ylabel(f"{method}\nstep dt (s)")
        for ax in axes[-1]:
            ax.set_xlabel("stiffness k (N/m)")
        handles, words = axes[0, 0].get_legend_handles_labels()
        fig.legend(handles, words, loc="outside lower center", ncols=columns, fontsize=9)
        heading(fig, "Joints as springs k and dampers c, 6 links: does a disturbance grow?", 11)
