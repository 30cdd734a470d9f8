"""Draw the wiring of supply, board and servos as SVGs for the page on wiring.

A dot marks joined wires; a wire that crosses another without contact has a bow.
"""

from __future__ import annotations

from pathlib import Path

RED, BLACK, ORANGE, BLUE = "#c22", "#222", "#c60", "#26a"
WIDTH, PITCH = 580, 96  # width of the picture and distance of servos, px
PLUS, MINUS = (280, 110), (320, 385)  # the star points
BOW = 6  # radius of a bow, px
Point = tuple[float, float]


def wire(colour: str, *points: Point, width: float = 2.5) -> str:
    """Return a wire through these points."""
    path = " ".join(f"{x:g},{y:g}" for x, y in points)
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def text(x: float, y: float, words: str, anchor: str = "middle") -> str:
    """Return the SVG of a label at a position."""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}">{words}</text>'


def box(x: float, y: float, width: float, height: float, *lines: str) -> str:
    """Return the SVG of a part with its name."""
    first = y + height / 2 + 5 - 9 * (len(lines) - 1)
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="4" fill="#eef2f7" '
        'stroke="#222" stroke-width="2"/>'
    ) + "".join(text(x + width / 2, first + 18 * k, line) for k, line in enumerate(lines))


def dot(point: Point, colour: str, radius: float = 4) -> str:
    """Return a point where wires join."""
    return f'<circle cx="{point[0]:g}" cy="{point[1]:g}" r="{radius:g}" fill="{colour}"/>'


def servo_x(number: int) -> float:
    """Return the x of a servo's middle, px."""
    return 88 + PITCH * (number - 1)


def supply() -> str:
    """Return supply, fuse, switch and capacitor, with both star points."""
    return "".join(
        [
            wire(RED, (90, 35), (PLUS[0], 35), PLUS, width=4),
            wire(BLACK, (20, 60), (20, MINUS[1]), MINUS, width=4),
            wire(RED, PLUS, (426, 60)),
            wire(BLACK, (550, 60), (565, 60), (565, MINUS[1]), MINUS),
            box(4, 4, 104, 66, "supply", "5 to 6 V", "10 A (3 A)"),
            box(122, 8, 58, 66, "fuse", "10 A", "(3 A)"),
            box(196, 20, 62, 30, "switch"),
            box(426, 36, 124, 48, "capacitor", "+ 1000 µF −"),
            dot(PLUS, RED, 7),
            dot(MINUS, BLACK, 7),
            text(28, 94, "in brackets: micro servos", "start"),
            text(PLUS[0] - 12, PLUS[1] - 6, "star +", "end"),
            text(MINUS[0] - 8, MINUS[1] + 22, "star −", "end"),
        ]
    )


def signal(x: float, y_board: float) -> str:
    """Return the signal wire from the board to a servo, with a bow at every crossing."""
    crossings = {MINUS[1]}  # y, px; first that of the wires from supply and capacitor
    for number in range(1, 6):
        end = servo_x(number) + 22
        along = (x - end) / (MINUS[0] - end)
        if 0 < along < 1:
            crossings.add(275 + along * (MINUS[1] - 275))
    bows = "".join(
        f" V {y + BOW:g} a {BOW} {BOW} 0 0 1 0 {-2 * BOW}" for y in sorted(crossings)[::-1]
    )
    path = f"M {x:g} {y_board} {bows} V 225"
    return f'<path d="{path}" fill="none" stroke="{ORANGE}" stroke-width="2.5"/>'


def servos(y_board: float) -> str:
    """Return five servos, each with wires to both star points, a signal and a pull-down."""
    parts = []
    for number in range(1, 6):
        x = servo_x(number)
        parts += [
            wire(RED, PLUS, (x, 170)),
            wire(BLACK, (x + 22, 225), (x + 22, 275), MINUS),
            signal(x - 22, y_board),
            wire(ORANGE, (x - 22, 254), (x + 22, 254), width=1.5),
            dot((x - 22, 254), ORANGE),
            dot((x + 22, 254), BLACK),
            box(x - 40, 170, 80, 55, "+", f"servo {number}", f"S {5 * chr(0xA0)} −"),
            box(x - 18, 243, 36, 22, "10k"),
        ]
    return "".join(parts)


def usb(y: float) -> str:
    """Return the cable to the computer."""
    return wire(BLACK, (530, y), (WIDTH, y), width=5) + text(552, y - 8, "USB")


def on_pins() -> str:
    """Return the board that gives the signals, with a resistor in each signal wire."""
    parts = [
        wire(BLACK, MINUS, (MINUS[0], 490)),
        box(30, 490, 500, 84, "", "Uno, Nano or Mega", "its 5 V pin feeds no servo"),
    ]
    for number in range(1, 6):
        x = servo_x(number) - 22
        parts += [box(x - 20, 412, 40, 40, "330", "Ω"), text(x, 508, str(4 + number))]
    return "".join([*parts, text(MINUS[0], 508, "GND"), usb(540)])


def on_driver() -> str:
    """Return the PCA9685 and its board: signals and ground, without servo power."""
    parts = [wire(BLACK, MINUS, (MINUS[0], 430)), box(30, 430, 500, 84, "PCA9685, V+ stays free")]
    parts += [text(MINUS[0], 448, "GND")] + [
        text(servo_x(n) - 22, 448, str(n - 1)) for n in range(1, 6)
    ]
    lines = {
        "VCC|5 V": (100, RED),
        "/OE|4": (190, BLUE),
        "SCL|A5": (280, BLUE),
        "SDA|A4": (370, BLUE),
        "GND|GND": (460, BLACK),
    }
    for names, (x, colour) in lines.items():
        above, below = names.split("|")
        parts += [wire(colour, (x, 514), (x, 590)), text(x, 508, above), text(x, 608, below)]
    pull_up = [wire(BLUE, (100, 552), (190, 552)), dot((100, 552), RED), dot((190, 552), BLUE)]
    board = box(30, 590, 500, 60, "", "Uno or Nano")
    return "".join([*pull_up, box(125, 540, 40, 24, "1k"), board, *parts, usb(630)])


def draw(path: Path, board: str, height: int, top_of_board: int) -> None:
    """Write a diagram to an SVG file."""
    plug = "plug, in order: S white, yellow or orange; + red; − black or brown"
    inside = supply() + servos(top_of_board) + board + text(WIDTH / 2, height - 8, plug)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
        'font-family="sans-serif" font-size="17"><title>Five servos, each with wires of its own to '
        f'two star points</title><rect width="{WIDTH}" height="{height}" fill="white"/>{inside}'
        "</svg>\n",
        encoding="utf-8",
    )


def draw_file(path: Path) -> None:
    """Write the diagram that the file name asks for: pins of a board, or a PCA9685."""
    if path.stem == "wiring":
        draw(path, on_pins(), 616, 490)
    else:
        draw(path, on_driver(), 691, 430)
