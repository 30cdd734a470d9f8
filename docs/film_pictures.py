"""Two pictures for filming.md: tags on the robot, and the camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

GREEN, GREY, BODY = "#009E73", "#777777", "#b9c3cc"
LETTERS_PT = 12.5  # legible on a phone
# Inner cells of the first six tags, white where a bit is 1, row by row from the top.
PATTERNS = (0xB532, 0x0F9A, 0x332D, 0x9946, 0x549E, 0x79CD)
ANGLES = np.radians([8, 30, 12, -28, -20, 14])


def draw(path: Path) -> None:
    """Draw the picture of a file's name: film-robot.png or film-tripod.png."""
    pictures = {"film-robot": _on_the_robot, "film-tripod": _tripod}
    fig = Figure(figsize=(7.2, 3.0), dpi=110, constrained_layout=True)
    ax = fig.subplots()
    ax.set(xlim=(0, 12), ylim=(0, 5), aspect="equal")
    ax.axis("off")
    pictures[path.stem](ax)
    fig.savefig(path)


def _label(ax: Axes, x: float, y: float, side: float, angle: float = 0.0, link: int = 0) -> None:
    """Draw a link's tag with its rim and its arrow, about its middle."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2

    def put(shape, colour: str, **more) -> None:
        corners = np.asarray(shape) @ turn.T + [x, y]
        ax.add_patch(Polygon(corners, fc=colour, **more))

    put(side * 8 / 6 * square, "white", ec=GREY, lw=0.8)
    put(side * square, "black", lw=0)
    for cell in range(16):
        if PATTERNS[link] >> (15 - cell) & 1:
            middle = np.array([cell % 4 - 1.5, 1.5 - cell // 4]) / 6
            put(side * (square / 6 + middle), "white", ec="white", lw=0.5)
    tip = np.array([[0.55, 0.07], [0.65, 0], [0.55, -0.07]])
    put(side * tip, GREY, lw=0)


def _robot(ax: Axes, x: float, y: float, link: float) -> np.ndarray:
    """Draw the robot from its tail; return the links' middles."""
    middles, tail = [], np.array([x, y])
    for angle in ANGLES:
        along = link * np.array([np.cos(angle), np.sin(angle)])
        across = 0.22 * link * np.array([-np.sin(angle), np.cos(angle)])
        ends = np.array([tail + 0.06 * along, tail + 0.94 * along])
        ax.add_patch(Polygon([*(ends + across), *(ends[::-1] - across)], fc=BODY, lw=0))
        middles.append(tail + along / 2)
        tail = tail + along
    for k, (middle, angle) in enumerate(zip(middles, ANGLES, strict=True)):
        _label(ax, *middle, 0.45 * link, angle, k)
    return np.array(middles)


def _say(ax: Axes, x: float, y: float, words: str) -> None:
    ax.text(x, y, words, fontsize=LETTERS_PT, ha="center")


def _on_the_robot(ax: Axes) -> None:
    middles = _robot(ax, 0.8, 1.5, 1.75)
    for k, (x, y) in enumerate(middles):
        _say(ax, x, y + 0.85, str(k + 1))
    _say(ax, middles[0][0], 0.6, "tail: number 1")
    _say(ax, middles[-1][0], 0.6, "head: the last number")
    _say(ax, 6.0, 4.5, "In the middle of each link, flat, all at one height; arrows to the head")


def _tripod(ax: Axes) -> None:
    ax.plot([0.3, 11.7], [0.5, 0.5], color="black")
    camera = np.array([3.0, 4.2])
    for foot in (2.2, 3.0, 3.8):
        ax.plot([3.0, foot], [3.9, 0.5], color=GREY)
    ax.add_patch(Rectangle(camera - [0.35, 0.25], 0.7, 0.5, fc="black"))
    for x in (5.0, 10.0):
        ax.plot([camera[0], x], [camera[1], 0.6], color=GREEN, lw=0.8, ls="--")
    ax.add_patch(Rectangle((5.6, 0.5), 3.4, 0.3, fc=BODY))
    _say(
        ax,
        8.6,
        3.3,
        "On a tripod, the camera 0 to 45°\nfrom straight down. Stabilisation off.\n"
        "Start it with a timer; touch nothing.",
    )
