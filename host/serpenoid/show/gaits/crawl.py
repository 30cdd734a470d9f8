"""One cycle of a gait as a picture that moves: SVG for a page, and its data.

The camera goes along at the mean speed, so that the cycle closes in itself and repeats for ever.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.files import write_text
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.run import Run
from ...simulation.scene import Scene
from ...simulation.simulate import simulate
from ..figure_data import by_link, write_columns
from ..plot import BLUE, GREY, RED, along_travel, gait_title, robot_words

Array = NDArray[np.float64]
Places = NDArray[np.complex128]  # m: along the way, across it as imaginary part
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
        return f"{gait_title(self.gait)}: {self.way_m / self.gait.period_s:.3g} m/s"

    @property
    def centre(self) -> Places:
        """Return the links' centres, (F, n): along the way, and across it as imaginary part."""
        return self.x_m + 1j * self.y_m

    def ends(self) -> Places:
        """Return tail and head of each link, (F, n, 2)."""
        along = self.robot.link_length_m / 2 * np.exp(1j * self.theta_rad)
        return np.stack([self.centre - along, self.centre + along], axis=2)

    def arrows(self) -> Places:
        """Return where the arrow of each force begins and ends, (F, n, 2)."""
        size = _ARROW * self.robot.link_length_m / float(np.hypot(*self.force_n.T).max())
        force = self.force_n[..., 0] + 1j * self.force_n[..., 1]
        return np.stack([self.centre, self.centre + size * force], axis=2)


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
    turn = np.exp(1j * (turned.theta_rad - run.theta_rad)[0, 0])
    force = turn * (run.friction_x_n + 1j * run.friction_y_n)
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
        np.stack([force.real, force.imag], axis=2),
        slip,
        way / marks,
        way,
    )


def write_data(found: Crawl, path: Path) -> None:
    """Write the frames: where each link is, what the ground does to it, how fast it slips."""
    tables = {
        "x{}_m": found.x_m,
        "y{}_m": found.y_m,
        "theta{}_rad": found.theta_rad,
        "force_x{}_n": found.force_n[:, :, 0],
        "force_y{}_n": found.force_n[:, :, 1],
        "slip{}_m_s": found.slip_m_s,
    }
    write_columns(path, {"t_s": found.t_s} | by_link(tables))


class _Canvas:
    """Metres onto the SVG's units, y upwards, in a cycle of some seconds on the screen."""

    def __init__(self, found: Crawl):
        ends, margin = found.ends().real, 1.2 * found.robot.link_length_m
        self.left, self.right = float(ends.min()) - margin, float(ends.max()) + margin
        self.scale = _WIDE / (self.right - self.left)
        self.middle = float((found.y_m.max() + found.y_m.min()) / 2)
        self.seconds = max(2.0, min(found.gait.period_s, 6.0))

    def x(self, metres: Array) -> Array:
        """Return places along the way."""
        return (metres - self.left) * self.scale

    def y(self, metres: Array) -> Array:
        """Return places across it."""
        return _HIGH / 2 + _HEAD_ROOM - (metres - self.middle) * self.scale

    def line(self, kind: str, ends: Places) -> str:
        """Return a line that moves between two ends, (F, 2)."""
        corners = {}
        for number, end in enumerate(ends.T, 1):
            corners |= {f"x{number}": self.x(end.real), f"y{number}": self.y(end.imag)}
        return self.shape("line", kind, corners)

    def shape(
        self, name: str, kind: str, moved: Mapping[str, Array], colours: Sequence[str] = ()
    ) -> str:
        """Return an element whose attributes follow their values (F,), and its fill the colours."""
        frames = {key: [f"{v:.1f}" for v in values] for key, values in moved.items()}
        now = " ".join(f'{key}="{values[0]}"' for key, values in frames.items())
        moves = "".join(self._moved(key, values) for key, values in frames.items())
        if colours:
            now, moves = f'fill="{colours[0]}" {now}', moves + self._moved("fill", colours)
        return f'<{name} class="{kind}" {now}>{moves}</{name}>\n'

    def _moved(self, name: str, values: Sequence[str]) -> str:
        jumps = ' calcMode="discrete"' if name == "fill" else ""
        return (
            f'<animate attributeName="{name}"{jumps} dur="{self.seconds:.3f}s" '
            f'repeatCount="indefinite" values="{";".join(values)}"/>'
        )


def write_svg(found: Crawl, path: Path) -> None:
    """Write the animated SVG, which moves without any script.

    A wheel is filled while it sticks, open while it slips sideways.
    """
    canvas = _Canvas(found)
    parts = [_ground(found, canvas)]
    ends, arrows = found.ends(), found.arrows()
    for i in range(found.robot.links):
        parts.append(canvas.line("head" if i == found.robot.links - 1 else "link", ends[:, i]))
        place = {"cx": canvas.x(found.x_m[:, i]), "cy": canvas.y(found.y_m[:, i])}
        shades = np.where(found.stuck[:, i], "#111111", "#ffffff").tolist()
        parts.append(canvas.shape("circle", "wheel", place, shades))
        parts.append(canvas.line("force", arrows[:, i]))
    write_text(path, _HEAD + _words(found, canvas.seconds) + "".join(parts) + "</svg>\n")


def _ground(found: Crawl, canvas: _Canvas) -> str:
    """Return marks on the ground, which go by."""
    marks = np.arange(canvas.left, canvas.right + 2 * found.mark_m, found.mark_m)
    lines = "".join(
        f'<line class="mark" x1="{x:.1f}" x2="{x:.1f}" y1="{_HIGH - 34}" y2="{_HIGH - 26}"/>'
        for x in canvas.x(marks).tolist()
    )
    turns = round(found.way_m / found.mark_m)
    return (
        f'<g>{lines}<animateTransform attributeName="transform" type="translate" from="0 0" '
        f'to="{-found.way_m * canvas.scale / turns:.2f} 0" dur="{canvas.seconds / turns:.4f}s" '
        'repeatCount="indefinite"/></g>\n'
    )


_HEAD = (
    f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDE} {_HIGH}" '
    'font-family="sans-serif" font-size="12">\n'
    f"<style>.link,.head{{stroke:{BLUE};stroke-width:9;stroke-linecap:round}} "
    f".head{{stroke:#003a5c}} .force{{stroke:{RED};stroke-width:2.5}} "
    ".wheel{r:5px;stroke:#111;stroke-width:1.5} .mark{stroke:#888}</style>\n"
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
