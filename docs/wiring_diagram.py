"""Draw how supply, board and servos are wired, as an SVG for the page on wiring."""

from __future__ import annotations

from pathlib import Path

PINS = (5, 6, 7, 8, 9)  # of joints 1 to 5
TOP, STEP = 190, 92  # of the first servo, and from one to the next
RED, BLACK, ORANGE = "#c22", "#222", "#c60"
BOARD_X, SERVO_X, PLUS_X, MINUS_X = 60, 560, 500, 530


def line(points: list[tuple[float, float]], colour: str, width: float = 2.5) -> str:
    """Return a wire through these points."""
    path = " ".join(f"{x:g},{y:g}" for x, y in points)
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def text(x: float, y: float, words: str, size: int = 15, anchor: str = "start") -> str:
    """Return words at a place."""
    return f'<text x="{x:g}" y="{y:g}" font-size="{size}" text-anchor="{anchor}">{words}</text>'


def box(x: float, y: float, width: float, height: float, *words: str) -> str:
    """Return a part with its name, a line for each of the words."""
    shape = (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="5" fill="#eef2f7" '
        'stroke="#222" stroke-width="2"/>'
    )
    first = y + height / 2 + 5 - 9 * (len(words) - 1)
    names = (text(x + width / 2, first + 18 * k, w, 14, "middle") for k, w in enumerate(words))
    return shape + "".join(names)


def dot(x: float, y: float, colour: str) -> str:
    """Return a joint of wires."""
    return f'<circle cx="{x:g}" cy="{y:g}" r="5" fill="{colour}"/>'


def supply() -> str:
    """Return supply, fuse and switch, capacitor, and the two star points."""
    return "".join(
        [
            line([(170, 60), (PLUS_X, 60), (PLUS_X, 110)], RED, 4),
            line([(170, 100), (MINUS_X, 100), (MINUS_X, 135)], BLACK, 4),
            box(40, 40, 130, 80, "supply", "5 to 6 V"),
            box(220, 45, 70, 30, "fuse"),
            box(320, 45, 80, 30, "switch"),
            dot(PLUS_X, 110, RED),
            dot(MINUS_X, 135, BLACK),
            text(PLUS_X - 10, 122, "star +", 13, "end"),
            line([(PLUS_X, 110), (640, 110), (640, 40), (680, 40)], RED),
            line([(MINUS_X, 135), (670, 135), (670, 80), (680, 80)], BLACK),
            box(680, 30, 130, 60, "capacitor", "1000 µF, 10 V"),
            text(MINUS_X + 12, 155, "star ground", 13),
        ]
    )


def board() -> str:
    """Return the board, its one wire to the star ground and its cable to the computer."""
    bottom = TOP + STEP * len(PINS) - 30
    return "".join(
        [
            line([(MINUS_X, 135), (BOARD_X + 75, 135), (BOARD_X + 75, TOP - 30)], BLACK),
            line([(MINUS_X, 135), (MINUS_X, TOP + STEP * 4 + 20)], BLACK),
            text(BOARD_X + 90, 153, "GND, a wire of its own", 13),
            box(
                BOARD_X,
                TOP - 30,
                150,
                bottom - TOP + 30,
                "Uno, Nano",
                "or Mega",
                "",
                "5 V pin: free",
            ),
            line([(BOARD_X, TOP + 20), (20, TOP + 20)], BLACK, 5),
            text(8, TOP + 10, "USB", 13),
        ]
    )


def joint(number: int) -> str:
    """Return one servo with its three wires, series resistor and pull-down."""
    y = TOP + STEP * (number - 1)
    wires = [
        line([(PLUS_X, 110), (PLUS_X, y), (SERVO_X, y)], RED),
        line([(MINUS_X, y + 20), (SERVO_X, y + 20)], BLACK),
        dot(MINUS_X, y + 20, BLACK),
        line([(BOARD_X + 150, y - 10), (420, y - 10), (420, y + 40), (SERVO_X, y + 40)], ORANGE),
        line([(380, y - 10), (380, y + 20), (MINUS_X, y + 20)], ORANGE, 1.5),
        dot(380, y - 10, ORANGE),
    ]
    parts = [
        box(268, y - 22, 80, 24, "330 Ω"),
        box(440, y + 9, 50, 22, "10 k"),
        box(SERVO_X, y - 12, 170, 64, f"servo of joint {number}"),
        text(BOARD_X + 158, y - 16, f"pin {PINS[number - 1]}", 13),
    ]
    return "".join(wires + parts)


def draw(path: Path) -> None:
    """Write the diagram."""
    height = TOP + STEP * len(PINS) - 10
    parts = [board(), *(joint(j) for j in range(1, len(PINS) + 1)), supply()]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 830 {height}" role="img" '
        'font-family="sans-serif"><title>Supply, fuse, switch, star points, board and five servos'
        f'</title><rect width="830" height="{height}" fill="white"/>{"".join(parts)}</svg>\n',
        encoding="utf-8",
    )
