"""A tag's corners from its edges: where grey passes the middle between black border and white rim.

The detector's corners stand on whole pixels of the contour; they give the place to look at. Along
each edge the grey profile across it is read, a line is laid through the crossings, and neighbouring
lines are cut. A second look starts from these: a blurred tag's contour is so far off that the first
profiles end before the grey does, and the tag comes out too small across its motion.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array, Grey, Mask

ALONG = np.linspace(0.1, 0.9, 13)  # Places at which an edge is read, as a share of it.
CELLS = 6
ACROSS = np.linspace(-1.0, 1.0, 25)


def refine(picture: Grey, quads: Array) -> tuple[Array, Array]:
    """Return corners (tags, 4, 2) and each tag's edge width, px.

    quads: the detector's corners, clockwise. The width is the distance over which grey rises from
    a quarter to three quarters. A tag whose edges cannot be read keeps its corners; width NaN.
    """
    corners, first = _refined(picture, quads)
    corners, second = _refined(picture, corners)
    return corners, np.where(np.isfinite(second), second, first)


def _refined(picture: Grey, quads: Array) -> tuple[Array, Array]:
    """Return corners and widths as `refine` does, from one look."""
    import cv2

    start, end = quads, np.roll(quads, -1, axis=1)
    edge = end - start
    length = np.linalg.norm(edge, axis=-1, keepdims=True)
    # Clockwise on a picture whose y points down: outside is to the left of the way along.
    outward = np.stack([edge[..., 1], -edge[..., 0]], axis=-1) / length
    # A tag seen aslant is narrower one way: across an edge, a cell is as wide as the area tells.
    x, y = quads[..., 0], quads[..., 1]
    area = 0.5 * np.abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1))
    # Half a cell of border and rim is read, at most 8 px: in steps below a pixel.
    reach = 0.5 / CELLS * area[:, None, None] / np.maximum(length, 1e-6)
    reach = np.minimum(reach, 8.0)
    base = start[:, :, None] + ALONG[:, None] * edge[:, :, None]
    places = base[..., None, :] + (reach[..., None] * ACROSS)[..., None] * outward[:, :, None, None]
    flat = places.reshape(len(quads) * 4, -1, 2).astype(np.float32)
    grey = cv2.remap(
        picture, flat[..., 0], flat[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
    )
    offset, width = _crossings(grey.reshape(places.shape[:-1]).astype(float))
    lines = _lines(offset * reach)
    corners = _cut(start, edge, outward, lines)
    read = np.isfinite(offset) & np.isfinite(width)
    rows = len(quads), -1
    widths = _median((width * reach).reshape(rows), read.reshape(rows))
    is_read = np.isfinite(corners).all(axis=(1, 2))
    is_read &= np.abs(corners - quads).max(axis=(1, 2)) < 2 * reach.max(axis=(1, 2))
    in_picture = (places >= 0) & (places <= np.array(picture.shape[::-1]) - 1)
    is_read &= in_picture.all(axis=(1, 2, 3, 4))  # a rim that the picture cuts off tells no edge
    return np.where(is_read[:, None, None], corners, quads), np.where(is_read, widths, np.nan)


def _crossings(profile: Array) -> tuple[Array, Array]:
    """Return where profiles (..., points) pass their middle, NaN where not, and how wide they rise.

    Both in units of the reach.
    """
    dark, bright = profile[..., :3].mean(axis=-1), profile[..., -3:].mean(axis=-1)
    rise = bright - dark
    # A lamp's reflection lifts the black while white can rise no further: there the edge is where
    # black has risen by half of what it rises elsewhere. Blur lifts black, but lowers white, too.
    top = np.quantile(bright, 0.95)
    washed = (bright > top - 5.0) & (dark > np.quantile(dark, 0.2) + 15.0)  # grey levels
    if not washed.all():
        rise = np.where(washed, np.median(rise[~washed]), rise)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (profile - dark[..., None]) / rise[..., None]
    crossings = [_passes(share, level) for level in (0.25, 0.5, 0.75)]
    contrast = np.quantile(rise, 0.5, axis=(-2, -1), keepdims=True)
    # An edge rises by half of the contrast of the picture's edges, and by 12 grey levels.
    is_edge = rise > np.maximum(0.5 * contrast, 12.0)
    return np.where(is_edge, crossings[1], np.nan), np.abs(crossings[2] - crossings[0])


def _passes(share: Array, level: float) -> Array:
    """Return where a rising profile first passes a level."""
    is_above = share > level
    k = is_above.argmax(axis=-1)
    start = np.maximum(k - 1, 0)
    low, high = (np.take_along_axis(share, end[..., None], -1)[..., 0] for end in (start, k))
    with np.errstate(invalid="ignore", divide="ignore"):
        crossing = ACROSS[start] + (level - low) / (high - low) * (ACROSS[1] - ACROSS[0])
    return np.where(k > 0, crossing, np.nan)


def _lines(offset: Array) -> Array:
    """Return intercept and slope of each edge's line, (tags, 4, 2); NaN with too few points."""
    mask = np.isfinite(offset)
    for _ in range(2):
        line = _line(offset, mask)
        miss = np.abs(offset - line[..., :1] - line[..., 1:] * ALONG)
        typical = _median(miss, mask)[..., None]
        mask = mask & (miss <= 3.5 * typical + 0.02)
    return _line(offset, mask)


def _median(values: Array, mask: Mask) -> Array:
    """Return the median of those that are there along the last axis, NaN of none."""
    ranked = np.sort(np.where(mask, values, np.nan), axis=-1)
    middle = np.maximum(mask.sum(axis=-1) - 1, 0) // 2
    return np.take_along_axis(ranked, middle[..., None], -1)[..., 0]


def _line(offset: Array, mask: Mask) -> Array:
    w = mask.astype(float)
    y = np.where(mask, offset, 0.0)
    n, sx, sxx = w.sum(-1), (w * ALONG).sum(-1), (w * ALONG**2).sum(-1)
    sy, sxy = y.sum(-1), (y * ALONG).sum(-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = (n * sxy - sx * sy) / (n * sxx - sx * sx)
        line = np.stack([(sy - slope * sx) / n, slope], axis=-1)
    fewest_points = 5
    return np.where((n >= fewest_points)[..., None], line, np.nan)


def _cut(start: Array, edge: Array, outward: Array, lines: Array) -> Array:
    """Return where each edge's line meets that of the edge before it."""
    point = start + lines[..., :1] * outward
    direction = edge + lines[..., 1:] * outward
    last_point, last_direction = np.roll(point, 1, axis=1), np.roll(direction, 1, axis=1)
    gap = last_point - point
    with np.errstate(invalid="ignore", divide="ignore"):
        cross = (
            direction[..., 0] * last_direction[..., 1] - direction[..., 1] * last_direction[..., 0]
        )
        share = (
            gap[..., 0] * last_direction[..., 1] - gap[..., 1] * last_direction[..., 0]
        ) / cross
    return point + share[..., None] * direction
