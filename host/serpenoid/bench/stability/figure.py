"""Draws the maps of stability: measured cells by colour, the theory's boundary as a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...show.plot import GREY, figure
from .map import Cell, limit_s

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# allowed and stable; refused and unstable; refused but stable as far as measured; allowed but not
COLOURS = ("#9ecae1", "#f4a582", "#fde0b8", "#b2182b")
WORDS = ("stable, runs", "unstable, refused", "refused, no growth seen", "unstable, yet runs")


def kind(cell: Cell) -> int:
    """Return which of WORDS a cell is; one without a measurement counts as the last, the worst."""
    if not np.isfinite(cell.growth) and cell.note:
        return 3
    if cell.refused:
        return 1 if cell.unstable else 2
    return 3 if cell.unstable else 0


def _edges(values: Sequence[float]) -> np.ndarray:
    logs = np.log10(values)
    step = logs[1] - logs[0]
    return 10 ** np.concatenate([[logs[0] - step / 2], logs + step / 2])


def _panel(ax: Axes, cells: Sequence[Cell]) -> None:
    from matplotlib.colors import ListedColormap

    stiffness = sorted({cell.stiffness_n_m for cell in cells})
    dts = sorted({cell.dt_s for cell in cells})
    kinds = np.full((len(dts), len(stiffness)), 3)
    for cell in cells:
        kinds[dts.index(cell.dt_s), stiffness.index(cell.stiffness_n_m)] = kind(cell)
    ax.pcolormesh(
        _edges(stiffness),
        _edges(dts),
        kinds,
        cmap=ListedColormap(COLOURS),
        vmin=-0.5,
        vmax=3.5,
        edgecolors="white",
        linewidth=0.4,
    )
    one = cells[0]
    fine = np.logspace(np.log10(stiffness[0]) - 0.2, np.log10(stiffness[-1]) + 0.2, 40)
    limits = [limit_s(one.method, one.links, one.damping_n_s_m, k) for k in fine]
    ax.plot(fine, np.where(np.array(limits) > 0, limits, np.nan), color="black", lw=1.4)
    ax.set(
        xscale="log",
        yscale="log",
        ylim=(_edges(dts)[0], _edges(dts)[-1]),
        xlim=(_edges(stiffness)[0], _edges(stiffness)[-1]),
    )
    ax.grid(visible=False)


def shown(cells: Sequence[Cell]) -> list[Cell]:
    """Return the cells of the overview: chains of 6 links and of the most, with c = 0 and 1000."""
    most = max(cell.links for cell in cells)
    return [c for c in cells if c.links in (6, most) and c.damping_n_s_m in (0.0, 1e3)]


def overview(cells: Sequence[Cell], path: Path) -> None:
    """Draw all methods downwards, some chains and dampings to the right."""
    cells = shown(cells)
    methods = list(dict.fromkeys(cell.method for cell in cells))
    columns = sorted({(cell.links, cell.damping_n_s_m) for cell in cells})
    rows = {
        m: [
            [x for x in cells if (x.method, x.links, x.damping_n_s_m) == (m, n, c)]
            for n, c in columns
        ]
        for m in methods
    }
    words = "Joints as springs k and dampers c: does a disturbance grow, at a step dt?"
    _draw(rows, [_chain(*c) for c in columns], words, path)


def stability_figure(cells: Sequence[Cell], method: str, path: Path) -> None:
    """Draw a method's map: links downwards, damping to the right, each over k and dt.

    Dampings under which every step is unstable and refused have no column; the title names them.
    """
    mine = [cell for cell in cells if cell.method == method]
    damping = sorted({cell.damping_n_s_m for cell in mine})
    told = [c for c in damping if {kind(x) for x in mine if x.damping_n_s_m == c} != {1}]
    links = sorted({cell.links for cell in mine})
    rows = {
        f"{n} links": [[x for x in mine if (x.links, x.damping_n_s_m) == (n, c)] for c in told]
        for n in links
    }
    dull = ", ".join(f"{c:g}" for c in damping if c not in told)
    words = f"Method {method}: does a disturbance of the joints grow?"
    if dull:
        words += f" With c = {dull} N s/m it does at every step here, and all are refused."
    _draw(rows, [f"c = {c:g} N s/m" for c in told], words, path)


def _chain(links: int, damping: float) -> str:
    return f"{links} links, c = {damping:g} N s/m"


def _draw(
    rows: Mapping[str, Sequence[Sequence[Cell]]], columns: Sequence[str], words: str, path: Path
) -> None:
    from matplotlib.patches import Patch

    with figure(2.9 * len(columns) + 0.8, 2.0 * len(rows) + 1.3) as (fig, _unused):
        fig.clear()
        axes = fig.subplots(len(rows), len(columns), squeeze=False, sharex=True, sharey=True)
        for row, (name, panels) in zip(axes, rows.items(), strict=True):
            for ax, cells in zip(row, panels, strict=True):
                _panel(ax, cells)
            row[0].set_ylabel(f"{name}\nstep dt (s)")
        for ax, title in zip(axes[0], columns, strict=True):
            ax.set_title(title, fontsize=9)
        for ax in axes[-1]:
            ax.set_xlabel("stiffness k (N/m)")
        present = sorted({kind(c) for panels in rows.values() for cells in panels for c in cells})
        handles = [Patch(color=COLOURS[i], label=WORDS[i]) for i in present]
        labels = [WORDS[i] for i in present] + ["limit by the modes of the chain"]
        fig.legend(
            [*handles, *axes[0, 0].lines[:1]],
            labels,
            loc="outside lower center",
            ncols=min(len(labels), 2 * len(columns)),
            fontsize=9,
        )
        fig.suptitle(words, fontsize=11, ha="left", x=0.01, color=GREY)
        fig.savefig(path, dpi=110)
