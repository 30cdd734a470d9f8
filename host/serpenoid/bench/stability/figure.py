"""Draws the maps of stability: measured cells by colour, the theory's boundary as a line."""

from __future__ import annotations

from collections.abc import Sequence
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
    ax.pcolormesh(_edges(stiffness), _edges(dts), kinds, cmap=ListedColormap(COLOURS),
                  vmin=-0.5, vmax=3.5, edgecolors="white", linewidth=0.4)  # fmt: skip
    one = cells[0]
    fine = np.logspace(np.log10(stiffness[0]) - 0.2, np.log10(stiffness[-1]) + 0.2, 40)
    limits = [limit_s(one.method, one.links, one.damping_n_s_m, k) for k in fine]
    ax.plot(fine, np.where(np.array(limits) > 0, limits, np.nan), color="black", lw=1.4)
    ax.set(xscale="log", yscale="log", ylim=(_edges(dts)[0], _edges(dts)[-1]),
           xlim=(_edges(stiffness)[0], _edges(stiffness)[-1]))  # fmt: skip
    ax.set_title(f"n = {one.links}, c = {one.damping_n_s_m:g} N s/m", fontsize=9)
    ax.grid(visible=False)


def stability_figure(cells: Sequence[Cell], method: str, path: Path) -> None:
    """Draw a method's map: links downwards, damping to the right, each over k and dt."""
    from matplotlib.patches import Patch

    mine = [cell for cell in cells if cell.method == method]
    links = sorted({cell.links for cell in mine})
    damping = sorted({cell.damping_n_s_m for cell in mine})
    with figure(2.9 * len(damping) + 0.6, 2.3 * len(links) + 1.3) as (fig, _unused):
        fig.clear()
        axes = fig.subplots(len(links), len(damping), squeeze=False, sharex=True, sharey=True)
        for row, n in zip(axes, links, strict=True):
            for ax, c in zip(row, damping, strict=True):
                _panel(ax, [x for x in mine if (x.links, x.damping_n_s_m) == (n, c)])
            row[0].set_ylabel("step dt (s)")
        for ax in axes[-1]:
            ax.set_xlabel("stiffness k (N/m)")
        present = sorted({kind(cell) for cell in mine})
        handles = [Patch(color=COLOURS[i], label=WORDS[i]) for i in present]
        handles += axes[0, 0].lines[:1]
        labels = [WORDS[i] for i in present] + ["limit by the modes of the chain"]
        fig.legend(
            handles,
            labels,
            loc="outside lower center",
            ncols=min(len(handles), len(damping)),
            fontsize=9,
        )
        fig.suptitle(f"Method {method}: does a disturbance of the joints grow?", fontsize=11,
                     ha="left", x=0.01, color=GREY)  # fmt: skip
        fig.savefig(path)
