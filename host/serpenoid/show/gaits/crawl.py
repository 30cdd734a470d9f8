"""One cycle of a gait as a picture that moves: SVG for a page, and its data.

The camera goes along at the mean speed, so that the cycle closes in itself and repeats for ever.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.files import write_csv, write_text
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.run import Run
from ...simulation.scene import Scene
from ...simulation.simulate import simulate
from ..figure_data import beside
from ..plot import BLUE, GREY, RED, along_travel, robot_words
from .gait_figures import gait_words

Array = NDArray[np.float64]
FRAMES = 48
_STUCK = 1e-6  # of body length x rate: a wheel slower than this across the link sticks
_ARROW = 0.9  # link lengths that the largest force is drawn as
_WIDE, _HIGH, _HEAD_ROOM = 720, 370, 24  # of the SVG, in its units


@dataclass(frozen=True)
class Crawl:
    """Hold one cycle as the camera sees it: F frames of n links.

    t_s (F,); x_m, y_m, theta_rad (F, n): centres and angles; force_n (F, n, 2): of the ground on
    each link; slip_m_s (F, n): speed across the link. mark_m: distance of marks on the ground, of
    which a whole number goes by in a cycle; way_m: what the snake travels in the cycle.
    """

    robot: Robot
    ground: Ground
    gait: Gait
    t_s: Array
    x_m: Array
    y_m: Array
    theta_rad: Array
    force_n: Array
    slip_m_s: Array
    mark_m: float
    way_m: float

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Tell of each wheel, (F, n), whether it does not slip sideways."""
        scale = self.robot.body_length_m * self.gait.omega_rad_s
        return np.abs(self.slip_m_s) < _STUCK * scale

    @property
    def title(self) -> str:
        """Return robot and gait."""
        speed = self.way_m / self.gait.period_s
        return f"{gait_words(self.gait)}: {speed:.3g} m/s"

    def ends(self) -> tuple[Array, Array]:
        """Return tails and heads of the links, each (F, n, 2)."""
        half = self.robot.link_length_m / 2
        centre = np.stack([self.x_m, self.y_m], axis=2)
        along = half * np.stack([np.cos(self.theta_rad), np.sin(self.theta_rad)], axis=2)
        return centre - along, centre + along

    def arrows(self) -> Array:
        """Return where the arrows of force end, (F, n, 2), from the links' centres."""
        size = _ARROW * self.robot.link_length_m / float(np.hypot(*self.force_n.T).max())
        return np.stack([self.x_m, self.y_m], axis=2) + size * self.force_n


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
    return _seen(robot, ground, gait, run)


def _seen(robot: Robot, ground: Ground, gait: Gait, run: Run) -> Crawl:
    turned = along_travel(run)
    angle = float((run.theta_rad - turned.theta_rad)[0, 0])
    c, s = math.cos(angle), math.sin(angle)
    fx, fy = run.friction_x_n, run.friction_y_n
    force = np.stack([c * fx + s * fy, -s * fx + c * fy], axis=2)
    slip = turned.vy_m_s * np.cos(turned.theta_rad) - turned.vx_m_s * np.sin(turned.theta_rad)
    centre = turned.centre_m
    way = float(centre[-1, 0] - centre[0, 0])
    with_camera = way * np.linspace(0, 1, turned.t_s.size) + centre[0, 0]
    marks = max(1, round(way / (0.5 * robot.link_length_m)))
    return Crawl(
        robot,
        ground,
        gait,
        turned.t_s,
        turned.x_m - with_camera[:, None],
        turned.y_m,
        turned.theta_rad,
        force,
        slip,
        way / marks,
        way,
    )


def write_data(found: Crawl, path: Path) -> None:
    """Write the frames: where each link is, what the ground does to it, how fast it slips."""
    n = found.robot.links
    parts = {
        "x{}_m": found.x_m,
        "y{}_m": found.y_m,
        "theta{}_rad": found.theta_rad,
        "force_x{}_n": found.force_n[:, :, 0],
        "force_y{}_n": found.force_n[:, :, 1],
        "slip{}_m_s": found.slip_m_s,
    }
    header = ["t_s", *(name.format(i + 1) for name in parts for i in range(n))]
    write_csv(beside(path), header, np.column_stack([found.t_s, *parts.values()]).tolist())


class _Canvas:
    """Metres onto the SVG's units, y upwards."""

    def __init__(self, found: Crawl) -> None:
        tails, heads = found.ends()
        x = np.concatenate([tails[:, :, 0], heads[:, :, 0]])
        margin = 1.2 * found.robot.link_length_m
        self.left, self.right = float(x.min()) - margin, float(x.max()) + margin
        self.scale = _WIDE / (self.right - self.left)
        self.middle = float((found.y_m.max() + found.y_m.min()) / 2)

    def x(self, metres: Array) -> Array:
        """Return places along the way."""
        return (metres - self.left) * self.scale

    def y(self, metres: Array) -> Array:
        """Return places across it."""
        return _HIGH / 2 + _HEAD_ROOM - (metres - self.middle) * self.scale


def _moved(name: str, values: Iterable[float], seconds: float) -> str:
    told = ";".join(f"{v:.1f}" for v in values)
    return (
        f'<animate attributeName="{name}" dur="{seconds:.3f}s" repeatCount="indefinite" '
        f'values="{told}"/>'
    )


def _line(kind: str, ends: Sequence[Array], seconds: float) -> str:
    """Return a line whose four coordinates move."""
    names = ("x1", "y1", "x2", "y2")
    now = " ".join(f'{name}="{v[0]:.1f}"' for name, v in zip(names, ends, strict=True))
    moves = "".join(_moved(n, v.tolist(), seconds) for n, v in zip(names, ends, strict=True))
    return f'<line class="{kind}" {now}>{moves}</line>\n'


def _wheel(x: Array, y: Array, stuck: NDArray[np.bool_], seconds: float) -> str:
    """Return a wheel: filled while it sticks, open while it slips sideways."""
    shades = ["#111111" if s else "#ffffff" for s in stuck.tolist()]
    fill = (
        f'<animate attributeName="fill" calcMode="discrete" dur="{seconds:.3f}s" '
        f'repeatCount="indefinite" values="{";".join(shades)}"/>'
    )
    return (
        f'<circle class="wheel" r="5" fill="{shades[0]}" cx="{x[0]:.1f}" cy="{y[0]:.1f}">'
        f"{_moved('cx', x.tolist(), seconds)}{_moved('cy', y.tolist(), seconds)}{fill}</circle>\n"
    )


def write_svg(found: Crawl, path: Path) -> None:
    """Write the animated SVG, which moves without any script."""
    canvas, seconds = _Canvas(found), max(2.0, min(found.gait.period_s, 6.0))
    tails, heads = found.ends()
    tips = found.arrows()
    marks = np.arange(canvas.left, canvas.right + 2 * found.mark_m, found.mark_m)
    ground = "".join(
        f'<line class="mark" x1="{x:.1f}" x2="{x:.1f}" y1="{_HIGH - 34}" y2="{_HIGH - 26}"/>'
        for x in canvas.x(marks).tolist()
    )
    back = -found.way_m * canvas.scale
    turns = round(found.way_m / found.mark_m)
    parts = [
        f'<g>{ground}<animateTransform attributeName="transform" type="translate" from="0 0" '
        f'to="{back / turns:.2f} 0" dur="{seconds / turns:.4f}s" repeatCount="indefinite"/></g>\n'
    ]
    for i in range(found.robot.links):
        x, y = canvas.x(found.x_m[:, i]), canvas.y(found.y_m[:, i])
        ends = [
            canvas.x(tails[:, i, 0]),
            canvas.y(tails[:, i, 1]),
            canvas.x(heads[:, i, 0]),
            canvas.y(heads[:, i, 1]),
        ]
        parts.append(_line("head" if i == found.robot.links - 1 else "link", ends, seconds))
        parts.append(_wheel(x, y, found.stuck[:, i], seconds))
        force = [x, y, canvas.x(tips[:, i, 0]), canvas.y(tips[:, i, 1])]
        parts.append(_line("force", force, seconds))
    write_text(path, _HEAD + _words(found, seconds) + "".join(parts) + "</svg>\n")


_HEAD = (
    f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDE} {_HIGH}" '
    'font-family="sans-serif" font-size="12">\n'
    f"<style>.link,.head{{stroke:{BLUE};stroke-width:9;stroke-linecap:round}} "
    f".head{{stroke:#003a5c}} .force{{stroke:{RED};stroke-width:2.5}} "
    ".wheel{stroke:#111;stroke-width:1.5} .mark{stroke:#888}</style>\n"
    f'<rect width="{_WIDE}" height="{_HIGH}" fill="#ffffff"/>\n'
)


def _words(found: Crawl, seconds: float) -> str:
    """Return what the picture says of itself."""
    pace = found.gait.period_s / seconds
    pace_words = "in real time" if abs(pace - 1) < 0.01 else f"at {pace:.2g} times real speed"
    return (
        f'<text x="8" y="18" font-size="14">{found.title}</text>\n'
        f'<text x="8" y="36" fill="{GREY}">{robot_words(found.robot, found.ground)}</text>\n'
        f'<text x="8" y="{_HIGH - 8}" fill="{GREY}">shaded: head; wheels filled: they stick'
        f" sideways, open: they slip; thin: force of the ground; {pace_words}</text>\n"
    )
