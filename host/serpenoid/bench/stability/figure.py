"""What the stability benchmark writes and says: CSV files, the map, a summary in words.

In the map measured cells have colours, and the theory's boundary is a line.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from ...show.plot import figure, heading
from ..rows import write_rows
from . import extremes
from . import map as stability_map
from .extremes import DEFECTS, Outcome
from .map import FULL, QUICK, WORDS, Cell

COLOURS = ("#9ecae1", "#f4a582", "#fde0b8", "#b2182b")  # of WORDS
TITLE = "Joints as springs k and dampers c: does a disturbance grow, at a step dt?"


def _edges(values: Sequence[float]) -> np.ndarray:
    logs = np.log10(values)
    step = logs[1] - logs[0]
    return 10 ** np.concatenate([[logs[0] - step / 2], logs + step / 2])


def shown(cells: Sequence[Cell]) -> list[Cell]:
    """Return the cells of the figure: chains of 6 links and of the most, with c = 0 and 1000."""
    most = max(cell.links for cell in cells)
    return [c for c in cells if c.links in (6, most) and c.damping_n_s_m in (0.0, 1e3)]


def stability_figure(cells: Sequence[Cell], path: Path) -> None:
    """Draw all methods downwards, some chains and dampings to the right."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    panels: dict[tuple[str, int, float], list[Cell]] = {}
    for cell in cells:
        panels.setdefault((cell.method, int(cell.links), cell.damping_n_s_m), []).append(cell)
    methods = list(dict.fromkeys(method for method, *_ in panels))
    columns = len(panels) // len(methods)
    size = 2.9 * columns + 0.8, 2.0 * len(methods) + 1.3
    grid = {"rows": len(methods), "squeeze": False, "sharex": True, "sharey": True}
    with figure(*size, columns, path=path, **grid) as (fig, axes):
        for ax, ((_, links, damping), inside) in zip(axes.flat, panels.items(), strict=True):
            limits = {cell.stiffness_n_m: cell.limit_s or np.nan for cell in inside}
            kinds = np.reshape([cell.kind for cell in inside], (len(limits), -1))
            k, dt = _edges([*limits]), _edges([cell.dt_s for cell in inside[: kinds.shape[1]]])
            look = {"vmin": -0.5, "vmax": 3.5, "edgecolors": "white", "linewidth": 0.4}
            ax.pcolormesh(k, dt, kinds.T, cmap=ListedColormap(COLOURS), **look)
            line = {"color": "black", "lw": 1.4, "label": "limit by the modes"}
            ax.plot(*zip(*limits.items(), strict=True), **line)
            ax.set(xscale="log", yscale="log", xlim=k[[0, -1]], ylim=dt[[0, -1]])
            ax.grid(visible=False)
            ax.set_title(f"{links} links, c = {damping:g} N s/m", fontsize=9)
        for ax, method in zip(axes[:, 0], methods, strict=True):
            ax.set_ylabel(f"{method}\nstep dt (s)")
        for ax in axes[-1]:
            ax.set_xlabel("stiffness k (N/m)")
        present = sorted({cell.kind for cell in cells})
        handles = [Patch(color=COLOURS[i], label=WORDS[i]) for i in present]
        handles += axes[0, 0].lines
        fig.legend(handles=handles, loc="outside lower center", ncols=columns, fontsize=9)
        heading(fig, TITLE, 11)


def measure_and_write(
    out: Path, quick: bool, tell: Callable[[str], None]
) -> tuple[list[Cell], list[Outcome]]:
    """Measure the map and the extremes, write their files into out, and return both."""
    out.mkdir(parents=True, exist_ok=True)
    cells = list(stability_map.measure(QUICK if quick else FULL, tell))
    write_rows(out / "stability_map.csv", cells)
    write_rows(out / "stability.csv", shown(cells))
    stability_figure(shown(cells), out / "stability.png")
    outcomes = list(extremes.run(quick, tell))
    write_rows(out / "stability_extremes.csv", outcomes)
    return cells, outcomes


def defects(cells: Sequence[Cell], outcomes: Sequence[Outcome]) -> list[str]:
    """Return what must not be: cells that run and grow or give no answer, and broken outcomes."""
    return [
        *(f"{WORDS[3]}: {cell}" for cell in cells if cell.kind == 3),
        *(str(one) for one in outcomes if one.outcome in DEFECTS),
    ]


def summary(cells: Sequence[Cell], outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield the lines that a person reads: counts of the maps, and the extremes."""
    for method in dict.fromkeys(cell.method for cell in cells):
        counts = Counter(WORDS[cell.kind] for cell in cells if cell.method == method)
        yield f"{method}: " + ", ".join(f"{n} {word}" for word, n in counts.items())
    yield f"\n{'extreme scene':32} {'method':20} {'outcome':13} {'stated':>8} {'error':>8} seconds"
    for o in outcomes:
        numbers = f"{o.stated:8.1e} {o.error:8.1e} {o.time_s:.2g}" if o.time_s >= 0 else ""
        yield f"{o.scene:32} {o.method:20} {o.outcome:13} {numbers or o.said}"
