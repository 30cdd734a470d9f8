"""How fast and how far a push can be, and which unit of length makes it likely where it is not."""

from __future__ import annotations

from .declaration import LENGTH_UNITS, Range

MAX_PUSH_M_S = 3.0  # at the start; robots of this size are pushed at 0.3 to 1.5 m/s
MAX_PUSH_M = 10.0  # until it rests
LIKELY_M_S: Range = (0.2, MAX_PUSH_M_S)
LIKELY_M: Range = (0.1, MAX_PUSH_M)
MAX_PLACE_SIGMA_M = 0.05  # of a place; a tape is read to 1 to 5 mm, a film to 1 to 3 mm


def likely_units(speed_m_s: float, way_m: float, unit: str = "") -> list[str]:
    """Return the units in which a push would be likely, other than the one that was taken.

    unit: that one; if none is given, lengths were taken as m, but m itself counts, too.
    """
    found = []
    for name, length_m in LENGTH_UNITS.items():
        factor = length_m / LENGTH_UNITS[unit or "m"]
        speed_fits = LIKELY_M_S[0] <= factor * speed_m_s <= LIKELY_M_S[1]
        if name != unit and speed_fits and LIKELY_M[0] <= factor * way_m <= LIKELY_M[1]:
            found.append(f"{name} ({factor * way_m:.2g} m from {factor * speed_m_s:.2g} m/s)")
    return found


def unlikely_push(speed_m_s: float, way_m: float, unit: str = "m") -> str:
    """Return why a push cannot be so fast or so long; "" if it can.

    unit: that its lengths were read in.
    """
    if speed_m_s <= MAX_PUSH_M_S and way_m <= MAX_PUSH_M:
        return ""
    units = likely_units(speed_m_s, way_m, unit)
    instead = f"; likely instead of {unit}: {', '.join(units)}" if units else ""
    return (
        f"{way_m:.3g} m from {speed_m_s:.3g} m/s is no push: at most {MAX_PUSH_M:g} m and "
        f"{MAX_PUSH_M_S:g} m/s{instead}"
    )
