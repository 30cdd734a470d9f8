"""A session as tables: how far it is, and every reading with what became of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from .. import report

if TYPE_CHECKING:
    from ...calibration.session import Session


def rows(session: Session) -> list[list[str]]:
    """Return one row a reading: number, what, values, state; in the order of the numbers."""
    found: list[tuple[int, str, str, bool, str]] = []
    for r in session.readings:
        bend, incline = math.degrees(r.lambda_rad), math.degrees(r.incline_rad)
        values = f"{incline:.2f} deg, belt {r.belt_speed_m_s:.3f}, drift {r.drift_m_s:+.3f} m/s"
        found.append((r.number, f"station, bend {bend:.4g} deg", values, r.voided, r.comment))
    for z in session.zeros:
        values = f"zero {math.degrees(z.zero_rad):+.3f} deg"
        side = "before" if z.before else "after"
        found.append((z.number, f"inclinometer, {side}", values, z.voided, z.comment))
    for b in session.bends:
        values = f"{math.degrees(b.between_links_rad):.4g} deg between links"
        name = f"protractor, bend {math.degrees(b.lambda_rad):.4g} deg"
        found.append((b.number, name, values, b.voided, b.comment))
    for g in session.gait_runs:
        name = f"gait, {g.omega_rad_s / (2 * math.pi):.3g} Hz"
        values = f"{g.speed_m_s:.4f} ± {g.speed_sigma_m_s:.4f} m/s"
        found.append((g.number, name, values, g.voided, g.comment))
    return [
        [str(n), what, values, "void" if voided else "", comment]
        for n, what, values, voided, comment in sorted(found)
    ]


def show(session: Session, parts: list[tuple[str, str]]) -> None:
    """Print what was read, then how far each part of the plan is."""
    columns = ["reading", "what", "values", "", "comment"]
    report.table(session.setup.name, columns, rows(session))
    for name, state in parts:
        report.console.print(f"{name:14} {state}", highlight=False)
    for note in session.notes:
        report.console.print(f"note: {note}", highlight=False, soft_wrap=True)


def as_dict(session: Session, parts: list[tuple[str, str]], say: str) -> dict[str, Any]:
    """Return the same as plain values."""
    zero = session.zero
    return {
        "name": session.setup.name,
        "parts": dict(parts),
        "next": say,
        "kept_stations": len(session.kept),
        "kept_gait_runs": len(session.kept_gait_runs),
        "zero_deg": math.degrees(zero.value_rad),
        "zero_sigma_deg": math.degrees(zero.sigma_rad),
        "sha256": session.sha256,
        "readings": [
            dict(zip(("reading", "what", "values", "state", "comment"), row, strict=True))
            for row in rows(session)
        ],
        "notes": list(session.notes),
    }
