"""Writes a track as Tracker, Kinovea and spreadsheets do: their heads, units, marks and cells."""

from __future__ import annotations

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048, "yd": 0.9144}
SECONDS = {"s": 1.0, "ms": 1e-3, "μs": 1e-6, "min/100": 0.6, "hour/10000": 0.36}


def spelled(value, comma):
    return f"{value:.5f}".replace(".", "," if comma else ".")


def tracker(rows, unit="m", separator="\t", comma=False, points=("mass A",), first="t"):
    """Tracker's File > Export > Data File: points beside each other, never a unit."""
    lines = ["#multi:"] if len(points) > 1 else []
    lines.append(separator + "".join(name + 2 * separator for name in points))
    lines.append(first + separator + len(points) * f"x{separator}y{separator}")
    for number, (t, x, y) in enumerate(rows):
        time = str(number) if first == "frame" else f"{t:.4E}".replace(".", "," * comma or ".")
        cells = [time]
        for k in range(len(points)):
            cells += [spelled(v / METRES[unit] + k, comma) for v in (x, y)]
        lines.append(separator.join(cells))
    return "\n".join(lines) + "\n"


def kinovea_table(rows, unit="cm", time="Time (ms)", seconds=1e-3, separator=","):
    """Kinovea's kinematics dialog, or its trajectory CSV where no unit is in the names."""
    comma, of_length = separator == ";", f" ({unit})"
    names = [time, f"Track 1/X{of_length}", f"Track 1/Y{of_length}"]
    lines = [separator.join(f'"{name}"' for name in names)]
    for t, x, y in rows:
        numbers = [t / seconds, *(v / METRES.get(unit, 1.0) for v in (x, y))]
        lines.append(separator.join(f'"{spelled(v, comma)}"' for v in numbers))
    return "\r\n".join(lines) + "\r\n"
