"""The printed tags: their size by the robot's links, and their black and white cells."""

from __future__ import annotations

from ...base.checks import check_number
from ..arrays import Mask
from .detect import dictionary
from .edges import CELLS

MOST_LINKS = 13  # Links of the longest robot whose tags fit on a page.


def tag_side_m(link_m: float) -> float:
    """Return the side of the tags that are printed for links of a length, m."""
    # Sides are far apart: a link's length that is typed a little wrong leaves the printed side.
    sides_mm = 10, 12, 14, 17, 20, 24, 28, 34, 40, 48, 58
    return max([8, *(side for side in sides_mm if side <= 450 * link_m)]) / 1e3


def tag_cells(links: int) -> list[Mask]:
    """Return which cells of each link's tag are white, (6, 6) each, row by row from the top."""
    check_number("links", links, 2, MOST_LINKS)
    family = dictionary()
    return [family.generateImageMarker(k, CELLS).astype(bool) for k in range(links)]
