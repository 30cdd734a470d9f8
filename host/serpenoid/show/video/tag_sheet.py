"""Draw the sheet of tags to print in true size, with cut lines, numbers, arrows and a ruler."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from ...base.errors import BadInput
from ...base.files import whole_file
from ...video.seeing.edges import CELLS

PAPERS_MM = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}  # Widths and heights of pages.
MARGIN_MM = 12.0  # Width of the rim that no printer reaches.


def tag_sheet(
    cells: Sequence[NDArray[np.bool_]], side_m: float, link_m: float, paper: str, path: Path
) -> None:
    """Write the sheet, one page, as PDF, PNG or SVG.

    cells: for each link from the tail the tag's white cells, (cells, cells). side_m: side of the
    black square. link_m: length of a link. paper: a key of PAPERS_MM. Raises BadInput if the tags
    do not fit on the page.
    """
    width, height = PAPERS_MM[paper]
    side_mm, top = 1e3 * side_m, height - MARGIN_MM
    corners = _corners(len(cells), side_mm, paper)
    fig = Figure(figsize=(width / 25.4, height / 25.4))
    ax = fig.add_axes((0, 0, 1, 1))
    ax.set(xlim=(0, width), ylim=(0, height), aspect="equal")
    ax.axis("off")
    title = f"Tags for a robot of {len(cells)} links of {1e3 * link_m:g} mm"
    ax.text(MARGIN_MM, top, title, fontsize=13, va="top", weight="bold")
    words = (
        '1. Print at 100 % ("actual size") on matt paper. The ruler below must be 100 mm long, a '
        f"black square {side_mm:g} mm.\n"
        "2. Cut along the dashed lines: the white rim belongs to the tag.\n"
        "3. Put number 1 on the TAIL link, then 2, 3, ... to the head; in the middle of each link, "
        "flat, all at one height.\n"
        "4. The arrow points to the HEAD. Lay it along the link as well as you can: within 1° for "
        "the tail's and the head's tag."
    )
    ax.text(MARGIN_MM, top - 8, words, fontsize=8.2, va="top", linespacing=1.45)
    for number, (tag, corner) in enumerate(zip(cells, corners, strict=True), 1):
        _tag(ax, tag, number, side_mm, *corner)
    x, y = MARGIN_MM + 4, MARGIN_MM + 6
    ticks_mm = np.arange(0, 101, 10)
    ax.hlines(y, x, x + 100, color="black", lw=0.8)
    ax.vlines(x + ticks_mm, y, y + 5, color="black", lw=0.5)
    for mm in ticks_mm:
        ax.text(x + mm, y - 1, str(mm), fontsize=7, ha="center", va="top")
    words = "100 mm: check with a ruler before you cut"
    ax.text(x + 105, y, words, fontsize=8, va="bottom")
    with whole_file(path) as part:
        fig.savefig(part, dpi=300)


def _corners(count: int, side_mm: float, paper: str) -> list[tuple[float, float]]:
    """Return x and y of the lower left corner of each tag's label, mm."""
    width, height = PAPERS_MM[paper]
    step = side_mm * (CELLS + 2) / CELLS + 4.0
    columns = int((width - 2 * MARGIN_MM + 4.0) // step)
    # The text above takes 40 mm, the ruler below 26 mm.
    rows = int((height - 2 * MARGIN_MM - 66.0) // step)
    if columns * rows < count:
        raise BadInput(
            f"{count} tags of {side_mm:g} mm do not fit on {paper}; give a smaller --tag-mm"
        )
    top = height - MARGIN_MM - 36.0
    return [(MARGIN_MM + k % columns * step, top - (k // columns + 1) * step) for k in range(count)]


def _tag(ax: Axes, white: NDArray[np.bool_], number: int, side: float, x: float, y: float) -> None:
    """Draw one label: cut line, tag, and in the white rim its number and an arrow to the head.

    white: (cells, cells), whether a cell is white. side, x, y: in mm.
    """
    cell = side / CELLS
    label = side + 2 * cell
    ax.add_patch(Rectangle((x, y), label, label, fill=False, ls=(0, (4, 3)), lw=0.5, ec="#777777"))
    ax.add_patch(Rectangle((x + cell, y + cell), side, side, fc="black", lw=0))
    rows, columns = np.nonzero(white)
    left_mm, bottom_mm = x + cell * (1 + columns), y + cell * (CELLS - rows)
    ax.bar(left_mm, cell, cell, bottom_mm, align="edge", color="white", lw=0)
    # The text is small and pale, so that it does not disturb the edges of the black square.
    look: dict[str, Any] = {"color": "#777777", "ha": "center", "va": "center"}
    look["fontsize"] = max(3.0, 0.45 * cell / 25.4 * 72)
    ax.text(x + 0.5 * cell, y + 0.5 * cell, str(number), **look)
    ax.text(x + label - 0.5 * cell, y + 0.5 * label, "→", **look)
