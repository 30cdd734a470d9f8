"""Draw the snake robot that crawls, as an SVG that moves by itself: one cycle, over and over.

The camera goes along at the mean speed, so the cycle closes in itself; the floor passes by.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import serpenoid as sn
from numpy.typing import NDArray
from serpenoid.show.run_figure import along_travel

FRAMES = 36  # pictures a cycle; the browser draws between them
WIDTH, HEIGHT = 720, 300  # px
SCALE = 1150  # px a metre, so that six links fill two thirds of the width
LINK_WIDTH_M, WHEEL_LENGTH_M, WHEEL_WIDTH_M, TRACK_M = 0.030, 0.026, 0.007, 0.044
STYLE = (
    "svg{background:#f4f1ea}.floor{stroke:#d8d2c4;stroke-width:2}.body{fill:#2b6a99}.head{fill:#17405f}"
    ".wheel,.joint{fill:#222}text{font:16px sans-serif;fill:#333}.bar{stroke:#333;stroke-width:3}"
    "@media(prefers-color-scheme:dark){svg{background:#20242a}.floor{stroke:#363c45}.body{fill:#5aa0d6}"
    ".head{fill:#a9d2f0}.wheel,.joint{fill:#e8e8e8}text{fill:#ddd}.bar{stroke:#ddd}}"
)


def one_cycle(robot: sn.Robot, ground: sn.Ground, gait: sn.Gait) -> sn.Run:
    """Return FRAMES + 1 pictures of the periodic motion, with the travel along x."""
    steps = 20  # time steps a picture
    scene = sn.Scene(
        robot,
        ground,
        gait,
        start="steady",
        method="nonsmooth",
        dt_s=gait.period_s / (FRAMES * steps),
        duration_s=gait.period_s,
        record_every=steps,
    )
    return along_travel(sn.simulate(scene))


def animated(kind: str, values: list[str], seconds: float) -> str:
    """Return the element that moves its parent through these values in this time."""
    return (
        f'<animateTransform attributeName="transform" type="{kind}" dur="{seconds:.2f}s" '
        f'repeatCount="indefinite" values="{";".join(values)}"/>'
    )


def rectangle(kind: str, x: float, y: float, length: float, width: float, corner: float) -> str:
    """Return a rectangle about a point of a link's own frame, all in metres."""
    x_corner, top = (x - length / 2) * SCALE, (y - width / 2) * SCALE
    return (
        f'<rect class="{kind}" x="{x_corner:.1f}" y="{top:.1f}" '
        f'width="{length * SCALE:.1f}" height="{width * SCALE:.1f}" rx="{corner * SCALE:.1f}"/>'
    )


def link(length_m: float, kind: str, has_joint: bool) -> str:
    """Return a link from above: body, two wheels on an axle at its middle, its tail-side joint."""
    wheels = "".join(
        rectangle("wheel", 0, side * TRACK_M / 2, WHEEL_LENGTH_M, WHEEL_WIDTH_M, 0.002)
        for side in (-1, 1)
    )
    axle = rectangle("wheel", 0, 0, 0.003, TRACK_M, 0)
    body = rectangle(kind, 0, 0, length_m, LINK_WIDTH_M, 0.010)
    joint = f'<circle class="joint" cx="{-length_m / 2 * SCALE:.1f}" r="6"/>'
    return wheels + axle + body + (joint if has_joint else "")


def floor(travel_m: float, seconds: float) -> str:
    """Return the lines of the floor, which pass once in the time of a cycle."""
    lines = round(travel_m / 0.05)
    spacing = travel_m / lines * SCALE
    marks = "".join(
        f'<path class="floor" d="M{k * spacing:.1f} 0V{HEIGHT}"/>'
        for k in range(int(WIDTH / spacing) + lines + 2)
    )
    return f"<g>{marks}{animated('translate', ['0 0', f'{-travel_m * SCALE:.1f} 0'], seconds)}</g>"


def draw(path: Path) -> None:
    """Write the picture of the 2005 robot in a gait that typical servos can follow."""
    robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    gait = sn.Gait(np.radians(70.0), np.radians(75.0), np.pi)
    run = one_cycle(robot, ground, gait)
    travel: float = float(run.x_m[-1, 0] - run.x_m[0, 0])
    camera = np.linspace(0.0, travel, run.t_s.size)[:, None]
    x: NDArray[np.float64] = run.x_m - camera
    middle_x, middle_y = (x.max() + x.min()) / 2, (run.y_m.max() + run.y_m.min()) / 2
    parts = [floor(travel, gait.period_s)]
    for k in range(robot.links):
        places = [
            f"{WIDTH / 2 + (px - middle_x) * SCALE:.0f} {HEIGHT / 2 - (py - middle_y) * SCALE:.0f}"
            for px, py in zip(x[:, k], run.y_m[:, k], strict=True)
        ]
        angles = [f"{-angle:.1f}" for angle in np.degrees(run.theta_rad[:, k])]
        kind = "head" if k == robot.links - 1 else "body"
        parts.append(
            f"<g>{animated('translate', places, gait.period_s)}"
            f"<g>{animated('rotate', angles, gait.period_s)}"
            f"{link(robot.link_length_m, kind, has_joint=k > 0)}</g></g>"
        )
    bar = 0.1 * SCALE
    parts.append(
        f'<path class="bar" d="M20 {HEIGHT - 18}h{bar:.0f}"/>'
        f'<text x="{30 + bar:.0f}" y="{HEIGHT - 12}">10 cm</text>'
        f'<text x="{WIDTH - 20}" y="{HEIGHT - 12}" text-anchor="end">'
        f"{travel / gait.period_s * 100:.0f} cm/s, in real time</text>"
    )
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">'
        "<title>A snake robot of six links on wheels crawls to the right</title>"
        f"<style>{STYLE}</style>{''.join(parts)}</svg>\n",
        encoding="utf-8",
    )
