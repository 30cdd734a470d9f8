"""Draw one link of the robot with its sizes, and six of them in line, as an SVG."""

from __future__ import annotations

from pathlib import Path

from wiring_diagram import text, wire

LINK_MM, BODY_MM, WHEEL_MM, TYRE_MM, TRACK_MM = 76.0, 30.0, 26.0, 7.0, 44.0
WIDTH, HEIGHT = 700, 400  # px
ONE_LINK_PX_MM, SIX_LINKS_PX_MM = 4.0, 1.15
GREY, BLUE, DARK = "#eef2f7", "#26a", "#222"


def rectangle(x: float, y: float, width: float, height: float, fill: str, corner: float) -> str:
    """Return an SVG rectangle around its middle; sizes in px."""
    return (
        f'<rect x="{x - width / 2:.1f}" y="{y - height / 2:.1f}" width="{width:.1f}" '
        f'height="{height:.1f}" rx="{corner:.1f}" fill="{fill}" stroke="{DARK}"/>'
    )


def link(x: float, y: float, scale: float, has_servo: bool) -> str:
    """Return the SVG of a link from above: body, wheels on their axle, servo, joints."""
    half = LINK_MM / 2 * scale
    parts = [
        rectangle(x, y, (LINK_MM + BODY_MM) * scale, BODY_MM * scale, GREY, BODY_MM / 2 * scale),
        wire(DARK, (x, y - TRACK_MM / 2 * scale), (x, y + TRACK_MM / 2 * scale)),
    ]
    for side in (-1, 1):
        wheel_y = y + side * TRACK_MM / 2 * scale
        parts.append(rectangle(x, wheel_y, WHEEL_MM * scale, TYRE_MM * scale, DARK, 2))
    if has_servo:
        parts.append(rectangle(x + half - 10 * scale, y, 40 * scale, 20 * scale, "#cdd8e6", 2))
    for joint_x in (x - half, x + half):
        parts.append(f'<circle cx="{joint_x:.1f}" cy="{y:.1f}" r="{2 * scale:.1f}" fill="{BLUE}"/>')
    return "".join(parts)


def size(x: float, y: float, length: float, label: str) -> str:
    """Return the SVG of a length along x, with marks at its ends and a label above."""
    ends = [wire(DARK, (x + k * length, y - 6), (x + k * length, y + 6), width=1) for k in (0, 1)]
    line = wire(DARK, (x, y), (x + length, y), width=1)
    return "".join([*ends, line, text(x + length / 2, y - 8, label)])


def draw(path: Path) -> None:
    """Write the drawing to an SVG file."""
    scale, x, y = ONE_LINK_PX_MM, 260.0, 160.0
    half, outer = LINK_MM / 2 * scale, (TRACK_MM + TYRE_MM) / 2 * scale
    parts = [
        link(x, y, scale, has_servo=True),
        size(x - half, y - outer - 24, 2 * half, f"{LINK_MM:g} mm, joint to joint"),
        size(x - WHEEL_MM / 2 * scale, y + outer + 24, WHEEL_MM * scale, f"wheel {WHEEL_MM:g} mm"),
        text(x + half + 76, y - 34, f"body {BODY_MM:g} mm wide,", "start"),
        text(x + half + 76, y - 16, "ends round about the joint", "start"),
        text(x + half + 76, y + 12, "servo: its shaft", "start"),
        text(x + half + 76, y + 30, "is the joint", "start"),
        text(x + 70, y + outer + 4, f"wheels {TRACK_MM:g} mm apart, axle at the middle", "start"),
    ]
    small = SIX_LINKS_PX_MM
    for k, has_servo in enumerate((True,) * 5 + (False,)):
        parts.append(link(80 + k * LINK_MM * small, 335, small, has_servo=has_servo))
    parts += [text(40, 390, "tail: link 1", "start"), text(600, 390, "head: link 6", "end")]
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        'font-family="sans-serif" font-size="14"><title>One link from above with its sizes, and '
        'the six links in line</title><rect width="100%" height="100%" fill="#fff"/>'
        f"{''.join(parts)}</svg>\n",
        encoding="utf-8",
    )
