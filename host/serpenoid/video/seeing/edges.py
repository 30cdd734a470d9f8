"""A tag's corners from its edges: where grey passes the middle between black border and white rim.

The detector's corners stand on whole pixels of the contour; they give the place to look at. Along
each edge grey profiles across it are read, a line is fitted to their crossings, and neighbouring
lines intersect in the corners. A second pass starts from these corners, because the contour of a
blurred tag is so far off that the first profiles may end before white: the tag would be too small.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array, Complex, Grey

ALONG = np.linspace(0.1, 0.9, 13)  # Positions of the profiles along an edge, over its length.
CELLS = 6  # Cells along a side of a tag, its black border included.
ACROSS = np.linspace(
    -1.0, 1.0, 25
)  # Positions across an edge where grey is read, over the half width of the window.


@np.errstate(invalid="ignore", divide="ignore")  # edges that cannot be read give NaN
def refine(picture: Grey, quads: Array) -> tuple[Array, Array]:
    """Return corners (tags, 4, 2) and each tag's edge width, px.

    quads: the detector's corners, clockwise. The width is the distance over which grey rises from
    a quarter to three quarters. A tag whose edges cannot be read keeps its corners; width NaN.
    """
    corners, first = _refined(picture, quads)
    corners, second = _refined(picture, corners)
    return corners, np.where(np.isfinite(second), second, first)


def _refined(picture: Grey, quads: Array) -> tuple[Array, Array]:
    """Return corners and widths as `refine` does, from one pass; points are complex, x + i y."""
    import cv2

    start: Any = quads @ [1, 1j]
    end = np.roll(start, -1, axis=1)
    edge = end - start
    # In a picture whose y points down, the outside is to the left of clockwise edges.
    outward = -1j * edge / np.abs(edge)
    # A tag seen aslant is narrower in one direction, so the tag's area gives the width of a cell
    # across an edge. Half a cell of border and rim is read; at most 8 px, so that points are less
    # than a pixel apart.
    area = 0.5 * np.abs(_cross(start, end).sum(axis=1, keepdims=True))
    half_window = np.minimum(0.5 / CELLS * area / np.maximum(np.abs(edge), 1e-6), 8.0)[..., None]
    base = start[..., None] + ALONG * edge[..., None]
    places = base[..., None] + (half_window * ACROSS)[:, :, None] * outward[..., None, None]
    flat = np.stack([places.real, places.imag], axis=-1).reshape(len(quads) * 4, -1, 2)
    x, y = np.moveaxis(flat.astype(np.float32), -1, 0)
    grey = cv2.remap(picture, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    offset, width = _crossings(grey.reshape(places.shape).astype(float))
    corners = _intersections(start, edge, outward, _lines(offset * half_window))
    rows = len(quads), -1
    widths = _median((width * half_window).reshape(rows))
    is_read = np.isfinite(corners).all(axis=(1, 2))
    is_read &= np.abs(corners - quads).max(axis=(1, 2)) < 2 * half_window.max(axis=(1, 2))
    # Edges whose rim is cut off by the picture cannot be read.
    in_picture = (flat >= 0) & (flat <= np.array(picture.shape[::-1]) - 1)
    is_read &= in_picture.reshape(rows).all(axis=1)
    return np.where(is_read[:, None, None], corners, quads), np.where(is_read, widths, np.nan)


def _cross(a: Complex, b: Complex) -> Array:
    """Return the cross product of plane vectors."""
    return (a.conj() * b).imag


def _crossings(profile: Array) -> tuple[Array, Array]:
    """Return the positions where profiles (..., points) pass their middle, and the rises' widths.

    Both are in units of the window's half width, and NaN where there is no edge.
    """
    dark, bright = profile[..., :3].mean(axis=-1), profile[..., -3:].mean(axis=-1)
    rise = bright - dark
    # A lamp's reflection brightens the black, while white is at its brightest already. There the
    # middle is taken from the usual rise, the median of the profiles without reflection. Blur
    # brightens the black too, but darkens the white.
    top = np.quantile(bright, 0.95)
    washed = (bright > top - 5.0) & (dark > np.quantile(dark, 0.2) + 15.0)  # grey levels
    if not washed.all():
        rise = np.where(washed, np.median(rise[~washed]), rise)
    share = (profile - dark[..., None]) / rise[..., None]
    start, middle, end = (_passes(share, level) for level in (0.25, 0.5, 0.75))
    contrast = np.quantile(rise, 0.5, axis=(-2, -1), keepdims=True)
    # An edge rises by at least half of its tag's median rise, and by at least 12 grey levels.
    is_edge = rise > np.maximum(0.5 * contrast, 12.0)
    offset, width = np.where(is_edge, [middle, np.abs(end - start)], np.nan)
    return offset, width


def _passes(share: Array, level: float) -> Array:
    """Return where a rising profile first passes a level."""
    is_above = share > level
    k = is_above.argmax(axis=-1)
    start = np.maximum(k - 1, 0)
    low, high = (np.take_along_axis(share, end[..., None], -1)[..., 0] for end in (start, k))
    crossing = ACROSS[start] + (level - low) / (high - low) * (ACROSS[1] - ACROSS[0])
    return np.where(k > 0, crossing, np.nan)


def _lines(offset: Array) -> Array:
    """Return intercept and slope of each edge's line, (tags, 4, 2); NaN with too few points."""
    for _ in range(2):
        line = _line(offset)
        miss = np.abs(offset - line[..., :1] - line[..., 1:] * ALONG)
        typical = _median(miss)[..., None]
        offset = np.where(miss <= 3.5 * typical + 0.02, offset, np.nan)
    return _line(offset)


def _median(values: Array) -> Array:
    """Return the lower median of the finite values along the last axis, NaN of none."""
    middle = np.maximum(np.isfinite(values).sum(axis=-1, keepdims=True) - 1, 0) // 2
    return np.take_along_axis(np.sort(values, axis=-1), middle, -1)[..., 0]


def _line(offset: Array) -> Array:
    powers, fewest_points = ALONG[:, None] ** [0, 1, 2], 5
    n, sx, sxx = np.moveaxis(np.isfinite(offset) @ powers, -1, 0)
    sy, sxy, _ = np.moveaxis(np.nan_to_num(offset) @ powers, -1, 0)
    slope = (n * sxy - sx * sy) / (n * sxx - sx * sx)
    line = np.stack([(sy - slope * sx) / n, slope], axis=-1)
    return np.where((n >= fewest_points)[..., None], line, np.nan)


def _intersections(start: Complex, edge: Complex, outward: Complex, lines: Array) -> Array:
    """Return the intersection of each edge's line with the previous edge's line, (tags, 4, 2)."""
    point = start + lines[..., 0] * outward
    direction = edge + lines[..., 1] * outward
    last_point, last_direction = np.roll([point, direction], 1, axis=2)
    share = _cross(last_point - point, last_direction) / _cross(direction, last_direction)
    corners = point + share * direction
    return np.stack([corners.real, corners.imag], axis=-1)
