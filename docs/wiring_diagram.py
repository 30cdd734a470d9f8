"""Draw how supply, board and servos are wired, as SVGs for the page on wiring.

A point where wires join is a dot; a wire that only crosses another has a bow there.
"""

from __future__ import annotations

from pathlib import Path

RED, BLACK, ORANGE, BLUE = "#c22", "#222", "#c60", "#26a"
WIDTH, PITCH = 580, 96  # px, of the picture and from servo to servo
PLUS, MINUS = (280, 110), (320, 385)  # the star points
BOW = 6  # px, radius where a signal crosses a wire to the star
Point = tuple[float, float]


def wire(colour: str, *points: Point, width: float = 2.5) -> str:
    """Return a wire through these points."""
    path = " ".join(f"{x:g},{y:g}" for x, y in points)
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def text(x: float, y: float, words: str, anchor: str = "middle") -> str:
    """Return words at a place."""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}">{words}</text>'


def box(x: float, y: float, width: float, height: float, *lines: str) -> str:
    """Return a part with its name."""
    first = y + height / 2 + 5 - 9 * (len(lines) - 1)
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="4" fill="#eef2f7" '
        'stroke="#222" stroke-width="2"/>'
    ) + "".join(text(x + width / 2, first + 18 * k, line) for k, line in enumerate(lines))


def dot(point: Point, colour: str, radius: float = 4) -> str:
    """Return a point where wires join."""
    return f'<circle cx="{point[0]:g}" cy="{point[1]:g}" r="{radius:g}" fill="{colour}"/>'


def servo_x(number: int) -> float:
    """Return the middle of a servo."""
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
    """Return a signal's wire from the board up to its servo, with a bow over each it crosses."""
    minus_pins = {MINUS[1]}  # both wires to the star, supply's and capacitor's
    for number in range(1, 6):
        end = servo_x(number) + 22
        along = (x - end) / (MINUS[0] - end)
        if 0 < along < 1:
            minus_pins.add(275 + along * (MINUS[1] - 275))
    bows = "".join(
        f" V {y + BOW:g} a {BOW} {BOW} 0 0 1 0 {-2 * BOW}" for y in sorted(minus_pins)[::-1]
    )
    path = f"M {x:g} {y_board} {bows} V 225"
    return f'<path d="{path}" fill="none" stroke="{ORANGE}" stroke-width="2.5"/>'


def servos(y_board: float) -> str:
    """Return five servos: wires of their own to both stars, a signal and its pull-down."""
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


def on_pins() -> str:
    """Return the board whose pins are the signals, with a resistor in each of them."""
    parts = [
        wire(BLACK, MINUS, (MINUS[0], 490)),
        box(30, 490, 500, 84, "", "Uno, Nano or Mega", "its 5 V pin feeds no servo"),
    ]
    for number in range(1, 6):
        x = servo_x(number) - 22
        parts += [box(x - 20, 412, 40, 40, "330", "Ω"), text(x, 508, str(4 + number))]
    usb = [wire(BLACK, (530, 540), (WIDTH, 540), width=5), text(552, 532, "USB")]
    return "".join([*parts, text(MINUS[0], 508, "GND"), *usb])


def on_driver() -> str:
    """Return the PCA9685 and the board that speaks to it: signals and ground, no servo power."""
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
    usb = [wire(BLACK, (530, 630), (WIDTH, 630), width=5), text(552, 622, "USB")]
    return "".join([*pull_up, box(125, 540, 40, 24, "1k"), board, *parts, *usb])


def draw(path: Path, board: str, height: int, top_of_board: int) -> None:
    """Write a diagram."""
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
    """Write the diagram of a file's name: for a board's pins, or for a PCA9685."""
    if path.stem == "wiring":
        draw(path, on_pins(), 616, 490)
    else:
        draw(path, on_driver(), 691, 430)
