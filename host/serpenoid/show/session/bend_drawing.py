"""A bent robot from above, with what a protractor shows at each joint: points, labels, SVG."""

from __future__ import annotations

import math

from ...model.bends import balanced_signs, joint_multiples

WIDE, HIGH = 640, 150


Point = tuple[float, float]


def bend_shape(
    bend: str, links: int, lambda_deg: float
) -> tuple[list[Point], list[tuple[float, float, str]]]:
    """Return the chain of a bent robot in a picture of WIDE by HIGH, tail left, and its labels.

    The chain is (x, y) of tail, joints and head; a label (x, y, text) a joint, its angle.
    """
    zigzag = tuple(2 * (k % 2) - 1 for k in range(links))
    signs = balanced_signs(links) if bend == "balanced" else zigzag
    x, y, chain = 0.0, 0.0, [(0.0, 0.0)]
    for sign in signs:
        turn = math.radians(sign * lambda_deg)
        x, y = x + math.cos(turn), y - math.sin(turn)
        chain.append((x, y))
    ys = [p[1] for p in chain]
    scale = min(0.82 * WIDE / x, 0.5 * HIGH / max(max(ys) - min(ys), 1e-9))
    left, middle = (WIDE - scale * x) / 2, HIGH / 2 + 8 - scale * (max(ys) + min(ys)) / 2
    points = [(round(left + scale * px, 1), round(middle + scale * py, 1)) for px, py in chain]
    labels = [
        (px, py - 12 if m <= 0 else py + 26, f"{180 - abs(m) * lambda_deg:g}°")
        for (px, py), m in zip(points[1:-1], joint_multiples(signs), strict=True)
    ]
    return points, labels


def bend_svg(bend: str, links: int, lambda_deg: float, name: str = "") -> str:
    """Return the drawing as SVG; name: what it shows, for those who do not see it."""
    points, named = bend_shape(bend, links, lambda_deg)
    line = " ".join(f"{x},{y}" for x, y in points)
    dots = "".join(f'<circle cx="{x}" cy="{y}" r="5"/>' for x, y in points[1:-1])
    x, y = points[-1]
    labels = "".join(
        f'<text x="{lx}" y="{ly}" text-anchor="middle">{text}</text>' for lx, ly, text in named
    )
    return (
        f'<svg viewBox="0 0 {WIDE} {HIGH}" role="img" aria-label="{name or f"{bend} bend"}" '
        'xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" font-size="17" '
        f'style="color-scheme:light"><polyline points="{line}" fill="none" stroke="#0072B2" '
        f'stroke-width="7" stroke-linejoin="round"/><g fill="#333">{dots}</g>'
        f'<text x="{x + 12}" y="{y + 5}">head</text><g>{labels}</g></svg>'
    )
