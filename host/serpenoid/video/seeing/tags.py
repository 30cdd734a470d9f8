"""The printed tags: their size by the robot's links, and their black and white cells."""

from __future__ import annotations

from ...base.checks import check_number
from ..arrays import Mask
from .detect import dictionary
from .edges import CELLS

MOST_LINKS = 13
# Sides of tags, far apart: a link's length that is typed a little wrong leaves the printed side.
SIDES_MM = (8, 10, 12, 14, 17, 20, 24, 28, 34, 40, 48, 58)


def tag_side_m(link_m: float) -> float:
    """Return the side of the tags that are printed for links of a length, m."""
    fitting = [side for side in SIDES_MM if side <= 450 * link_m]
    return max(fitting, default=SIDES_MM[0]) / 1e3


def tag_cells(links: int) -> list[Mask]:
    """Return which cells of each link's tag are white, (6, 6) each, row by row from the top."""
    check_number("links", links, 2, MOST_LINKS)
    family = dictionary()
    return [family.generateImageMarker(k, CELLS).astype(bool) for k in range(links)]
