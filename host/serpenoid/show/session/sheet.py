"""A sheet to print and fill in beside the treadmill or on the floor, for one session's plan."""

from __future__ import annotations

import html
import math
from pathlib import Path

from ...calibration.session import Session
from ...calibration.taking.bends import bend_in_words
from ...calibration.taking.expected import Series, series_of, series_of_pushes
from ...calibration.taking.floor.procedure import SPEED_M_S, expected_way_m
from ...calibration.taking.procedure import settle_s
from ...calibration.taking.sheet import LINES, SLIDES, sheet_text, ways_of
from ...model.files import write_text
from .bend_drawing import bend_svg

SPARE_LINES = 2  # for pushes that were struck out
STYLE = """
@page { size: A4; margin: 14mm; }
body { font: 11pt/1.35 system-ui, sans-serif; color: #000; background: #fff; max-width: 182mm;
  margin: 0 auto; }
h1 { font-size: 15pt; margin: 0 0 1mm; } h2 { font-size: 11.5pt; margin: 4mm 0 1mm; }
p { margin: 1mm 0; } table { border-collapse: collapse; width: 100%; break-inside: avoid; }
th, td { border: .3mm solid #666; padding: 0 2mm; height: 7mm; text-align: left; }
th { font-weight: 600; height: 6mm; background: #eee; } section { break-inside: avoid; }
svg { width: 100mm; display: block; margin: 1mm auto 2mm; }
.nr { width: 8mm; } .short { width: 24mm; }
"""


def sheet(session: Session) -> str:
    """Return the sheet as one HTML page that needs nothing else."""
    setup = session.setup
    mass_g = 1000 * setup.robot.links * setup.robot.link_mass_kg
    about = (
        f"{setup.robot.links} links, {mass_g:.1f} g, links of "
        f"{1000 * setup.robot.link_length_m:.1f} mm; surface: {setup.surface}; place: {setup.place}"
    )
    if setup.procedure.on == "floor":
        taken = _floor_parts(session)
    else:
        zero = _table(["inclinometer (°)", "end for end (°)", "remark"], 1)
        taken = [
            f"<p>{_how(session)}</p>",
            f"<section><h2>Inclinometer zero, before (kind zero)</h2>{zero}</section>",
            *(_bend(series, setup.robot.links) for series in series_of(setup.procedure)),
            f"<section><h2>Inclinometer zero, after (kind zero)</h2>{zero}</section>",
        ]
    parts = [
        f"<h1>Calibration: {html.escape(setup.name)}</h1><p>{html.escape(about)}</p>"
        "<p>date: ____________ &emsp; who: ________________________</p>",
        *taken,
        _gaits(session),
    ]
    title = f"<title>{html.escape(setup.name)}</title>"
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">{title}'
        f"<style>{STYLE}</style></head><body>{''.join(parts)}</body></html>\n"
    )


def write_sheet(session: Session, path: Path) -> None:
    """Write the sheet: to print, or as CSV to type it into."""
    typed = path.suffix.lower() == ".csv"
    write_text(path, sheet_text(session) if typed else sheet(session))


def _floor_parts(session: Session) -> list[str]:
    how = (
        f"Push the robot along its own axis, head first, at a brisk walk ({SPEED_M_S:g} m/s). Let "
        "go within a hand's breadth; leave it until it rests. Turn it round after each push: there "
        "and back along one line. Write down the way and the time from the hand to rest, or the "
        "name of the film that shows it. Strike out a push that turned by more than 10° or hit "
        "something; push again."
    )
    slides = _table(
        ["bend (°)", "incline (° or %)", "length from rest (m)", "time (s)", "remark"], SLIDES
    )
    board = (
        "If there is a board with the same surface: let go at rest, head down, and time a length."
    )
    return [
        f"<p>{how}</p>",
        *(_pushes(session, series) for series in series_of_pushes(session.setup.procedure)),
        f"<section><h2>Slides down a board (kind slide)</h2><p>{board}</p>{slides}</section>",
    ]


def _pushes(session: Session, series: Series) -> str:
    setup = session.setup
    bend, name = math.degrees(series.lambda_rad), series.bend
    far = f"It rolls some {expected_way_m(setup, series.lambda_rad, SPEED_M_S):.1f} m."
    heading, check = "Pushes, straight (kind coast, lambda_deg 0)", "Links along a straightedge."
    drawn = ""
    if series.facing == "back":
        heading = "Pushes, straight, TAIL FIRST (kind coast, lambda_deg 0, facing back)"
    if bend:
        heading = f"Pushes, bend {bend:g}° (kind coast)"
        check, drawn = _bent(name, setup.robot.links, bend)
    ways = ways_of(setup.procedure)
    columns = ["way", "distance (m)", "time to rest (s)", "turned, + left (°)", "or film", "remark"]
    lines = _table(columns, len(ways) + SPARE_LINES, ways)
    return f"<section><h2>{heading}</h2><p>{check} {far}{drawn}</p>{lines}</section>"


def _how(session: Session) -> str:
    """Return in two lines what a person without the program has to know."""
    plan = session.setup.procedure
    first, step = (math.degrees(x) for x in (plan.incline_start_rad, plan.incline_step_rad))
    return (
        f"Incline from about {first:.3g}° in steps of {step:.2g}° or more; raise the belt until "
        f"the robot holds its place; wait {settle_s(session):.0f} s straight, less when bent; "
        f"write down. A series ends at {plan.belt_speed_max_m_s:.3g} m/s "
        f"({3.6 * plan.belt_speed_max_m_s:.3g} km/h). Strike out, do not overwrite."
    )


def _bend(series: Series, links: int) -> str:
    bend = math.degrees(series.lambda_rad)
    columns = ["incline (° or %)", "belt (km/h or m/s)", "drift, + uphill (m/s)", "remark"]
    if series.facing == "up":
        heading = "Straight, facing up (kind station, lambda_deg 0, facing up)"
        check = "Head UPHILL, belt uphill: the wheels roll backwards. Steeper until it holds."
    elif not bend:
        heading = "Straight (kind station, lambda_deg 0)"
        check = "Head downhill, belt uphill. Raise the belt until the robot holds; wait; read."
    else:
        heading = f"Bend {bend:g}° (kind station)"
        check = "".join(_bent(series.bend, links, bend))
    return f"<section><h2>{heading}</h2><p>{check}</p>{_table(columns, LINES)}</section>"


def _bent(bend: str, links: int, lambda_deg: float) -> tuple[str, str]:
    """Return what to do and to check for a bend, and its drawing."""
    words = bend_in_words(bend, lambda_deg, links).replace(" deg", "°")
    check = f"{words[0].upper()}{words[1:]} At an end it showed (kind bend): ________ °"
    return check, bend_svg(bend, links, lambda_deg)


def _gaits(session: Session) -> str:
    plan = session.setup.procedure
    if not plan.gaits:
        return ""
    rows = [
        f"α {math.degrees(g.alpha_rad):g}°, β {math.degrees(g.beta_rad):g}°, "
        f"{g.omega_rad_s / (2 * math.pi):.3g} Hz"
        for g in plan.gaits
        for _ in range(plan.gait_runs)
    ]
    columns = ["gait", "distance (m)", "time (s)", "remark"]
    return (
        "<section><h2>Gait runs, level ground of the same surface (kind gait)</h2>"
        f"{_table(columns, len(rows), rows)}</section>"
    )


def _table(columns: list[str], lines: int, first: list[str] | None = None) -> str:
    head = "".join(f"<th>{c}</th>" for c in columns)
    body = "".join(
        f'<tr><td class="nr">{k + 1}</td>'
        + "".join(
            f"<td>{first[k] if first and i == 0 and k < len(first) else ''}</td>"
            for i in range(len(columns))
        )
        + "</tr>"
        for k in range(lines)
    )
    return f'<table><tr><th class="nr"></th>{head}</tr>{body}</table>'
