"""One cycle of a gait as a picture that moves: SVG for a page.

The camera goes along at the mean speed, so that the cycle closes in itself and repeats for ever.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...base.files import write_text
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.scene import Scene
from ...simulation.simulate import simulate
from ..plot import BLUE, GREY, RED, along_travel, gait_title, robot_words

Array = NDArray[np.float64]
Places = NDArray[np.complex128]  # m: along the way, across it as imaginary part
FRAMES = 48
_STUCK = 1e-6  # of body length x rate: a wheel slower than this across the link sticks
_ARROW = 0.9  # link lengths that the largest force is drawn as
_WIDE, _HIGH, _HEAD_ROOM = 720, 370, 24  # of the SVG, in its units
_JUMPS = ' calcMode="discrete"'


@dataclass(frozen=True)
class Crawl:
    """Hold one cycle as the camera sees it: F frames of n links, (F, n) each but t_s, (F,).

    centre and theta_rad: where the links are; force_n: of the ground on each; slip_m_s: speed
    across the link. Of a force and a place the imaginary part is across the way. way_m: what the
    snake travels in the cycle.
    """

    robot: Robot
    ground: Ground
    gait: Gait
    t_s: Array
    centre: Places
    theta_rad: Array
    force_n: Places
    slip_m_s: Array
    way_m: float

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Tell of each wheel, (F, n), whether it does not slip sideways."""
        scale = self.robot.body_length_m * self.gait.omega_rad_s
        return np.abs(self.slip_m_s) < _STUCK * scale


def crawl(robot: Robot, ground: Ground, gait: Gait) -> Crawl:
    """Run one cycle of the periodic state of a gait that goes straight."""
    every = 20
    run = simulate(
        Scene(
            robot,
            ground,
            gait,
            start="steady",
            method="rk4" if ground.smooth else "nonsmooth",
            dt_s=gait.period_s / (FRAMES * every),
            duration_s=gait.period_s,
            record_every=every,
            record=("friction",),
        )
    )
    turned = along_travel(run)
    turn = np.exp(1j * (turned.theta_rad - run.theta_rad)[0, 0])
    force = turn * (run.friction_x_n + 1j * run.friction_y_n)
    slip = turned.vy_m_s * np.cos(turned.theta_rad) - turned.vx_m_s * np.sin(turned.theta_rad)
    start, *_, end = turned.centre_m[:, 0].tolist()
    camera = (end - start) * np.linspace(0, 1, turned.t_s.size) + start
    centre = turned.x_m - camera[:, None] + 1j * turned.y_m
    return Crawl(
        robot, ground, gait, turned.t_s, centre, turned.theta_rad, force, slip, end - start
    )


def write_svg(cycle: Crawl, path: Path) -> None:
    """Write the animated SVG, which moves without any script.

    A wheel is filled while it sticks, open while it slips sideways.
    """
    robot, gait, way = cycle.robot, cycle.gait, cycle.centre
    arm = robot.link_length_m / 2 * np.exp(1j * cycle.theta_rad)
    arrow = _ARROW * robot.link_length_m / float(np.abs(cycle.force_n).max()) * cycle.force_n
    places = np.stack([way - arm, way + arm, way, way + arrow])
    ends, margin = places[:2].real, 1.2 * robot.link_length_m
    left, right = float(ends.min()) - margin, float(ends.max()) + margin
    scale, middle = _WIDE / (right - left), float((way.imag.max() + way.imag.min()) / 2)
    down = _HIGH / 2 + _HEAD_ROOM - (places.imag - middle) * scale
    drawn = (places.real - left) * scale + 1j * down
    seconds = max(2.0, min(gait.period_s, 6.0))
    pace = gait.period_s / seconds
    pace_words = "in real time" if abs(pace - 1) < 0.01 else f"at {pace:.2g} times real speed"
    # marks on the ground, half a link apart or so, which go by
    count = max(1, round(cycle.way_m / (0.5 * robot.link_length_m)))
    apart = cycle.way_m / count
    marks = "".join(
        f'<line class="mark" x1="{x:.1f}" x2="{x:.1f}" y1="{_HIGH - 34}" y2="{_HIGH - 26}"/>'
        for x in ((np.arange(left, right + 2 * apart, apart) - left) * scale).tolist()
    )
    parts = [
        f"{_HEAD}"
        f'<text x="8" y="18" font-size="14">{gait_title(gait)}: '
        f"{cycle.way_m / gait.period_s:.3g} m/s</text>\n"
        f'<text x="8" y="36" fill="{GREY}">{robot_words(robot, cycle.ground)}</text>\n'
        f'<text x="8" y="{_HIGH - 8}" fill="{GREY}">shaded: head; wheels filled: they stick'
        f" sideways, open: they slip; thin: force of the ground; {pace_words}</text>\n"
        f'<g>{marks}<animateTransform attributeName="transform" type="translate" from="0 0" '
        f'to="{-apart * scale:.2f} 0" dur="{seconds / count:.4f}s" '
        'repeatCount="indefinite"/></g>\n'
    ]
    for i, (tail, head, start, tip) in enumerate(drawn.transpose(2, 0, 1)):
        fills = np.where(cycle.stuck[:, i], "#111111", "#ffffff").tolist()
        wheel = {"fill": fills, "cx": _digits(start.real), "cy": _digits(start.imag)}
        kind = "head" if i == robot.links - 1 else "link"
        parts += [
            _moving("line", kind, _line(tail, head), seconds),
            _moving("circle", "wheel", wheel, seconds),
            _moving("line", "force", _line(start, tip), seconds),
        ]
    write_text(path, "".join(parts) + "</svg>\n")


def _digits(values: Array) -> list[str]:
    return [f"{value:.1f}" for value in values]


def _line(start: Places, end: Places) -> dict[str, list[str]]:
    """Return the attributes of a line between two ends, (F,) each."""
    ends = {"x1": start.real, "y1": start.imag, "x2": end.real, "y2": end.imag}
    return {name: _digits(values) for name, values in ends.items()}


def _moving(name: str, kind: str, frames: Mapping[str, Sequence[str]], seconds: float) -> str:
    """Return an element whose attributes follow their frames; a fill jumps."""
    now = " ".join(f'{key}="{values[0]}"' for key, values in frames.items())
    moves = "".join(
        f'<animate attributeName="{key}"{_JUMPS if key == "fill" else ""} dur="{seconds:.3f}s" '
        f'repeatCount="indefinite" values="{";".join(values)}"/>'
        for key, values in frames.items()
    )
    return f'<{name} class="{kind}" {now}>{moves}</{name}>\n'


_HEAD = (
    f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDE} {_HIGH}" '
    'font-family="sans-serif" font-size="12">\n'
    f"<style>.link,.head{{stroke:{BLUE};stroke-width:9;stroke-linecap:round}} "
    f".head{{stroke:#003a5c}} .force{{stroke:{RED};stroke-width:2.5}} "
    ".wheel{r:5px;stroke:#111;stroke-width:1.5} .mark{stroke:#888}</style>\n"
    f'<rect width="{_WIDE}" height="{_HIGH}" fill="#ffffff"/>\n'
)
