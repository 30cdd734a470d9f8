"""The report of a session: one HTML file that needs nothing else, the same whenever made."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import Any

from ...friction.result import DOUBTFUL, FrictionFit
from ...prediction.advice import Advice
from ...prediction.comparison import Comparison
from ...session.session import Session
from ..comparison_figure import draw_comparison, panels
from ..plot import draw_friction, figure
from .floor_figure import draw_pushes

_STYLE = """
:root{color-scheme:light dark;--ink:#1c1e21;--paper:#fff;--line:#d9dce1;--soft:#5b616b}
@media(prefers-color-scheme:dark){:root{--ink:#e8eaed;--paper:#17191c;--line:#3a3e45;--soft:#a3a9b3}}
@media print{:root{--ink:#000;--paper:#fff;--line:#bbb;--soft:#444}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:60rem;padding:1.5rem 1rem;background:var(--paper);color:var(--ink);
font:16px/1.5 system-ui,sans-serif}
h1{font-size:1.6rem;margin:0}h2{font-size:1.15rem;margin:2rem 0 .5rem}
h3{font-size:1rem;margin:1.2rem 0 .3rem}
.soft{color:var(--soft)}.verdict{border-left:4px solid #0072B2;padding:.4rem .8rem;margin:1rem 0}
.wide{overflow-x:auto;margin-bottom:.8rem}table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .7rem;border-bottom:1px solid var(--line);text-align:right;white-space:nowrap}
th{white-space:normal}th:first-child,td:first-child{text-align:left}
figure{margin:0 0 .5rem;overflow-x:auto}
figure img{display:block;width:100%;max-width:28rem;height:auto}
.void{color:var(--soft)}.void td{text-decoration:line-through}
.words th,.words td{text-align:left;white-space:normal}.words td:last-child{overflow-wrap:anywhere}
.off td:nth-child(4){white-space:nowrap}
.said td{color:var(--soft);white-space:normal}tr:has(+.said) td{border:0}
code{overflow-wrap:anywhere}
@media screen and (prefers-color-scheme:dark){figure img{filter:invert(.9) hue-rotate(180deg)}}
@media screen and (max-width:500px){body{padding:1rem .7rem}table{font-size:.85rem}
th,td{padding:.25rem .3rem;white-space:normal}}
@media print{@page{size:A4;margin:14mm}body{font-size:9.5pt;max-width:none;padding:0}
h2{break-after:avoid}figure,tr{break-inside:avoid}figure img{min-width:0;max-height:110mm}
.wide{overflow:visible}table{font-size:8.5pt}th,td{padding:.1rem .35rem}}
"""


def session_page(
    session: Session,
    fit: FrictionFit,
    compared: Comparison | None,
    advice: Advice | None,
) -> str:
    """Return the whole page; what is None is left out."""
    setup, drawings = session.setup, []
    notes = [fit.remarks[0], *fit.notes, *session.notes]
    if session.kept_stations and not session.on_floor:
        what = "friction against speed, readings and lines"
        drawings.append(_svg(what, draw_friction, fit, session, size=(4.2, 6.4), rows=2))
    if session.kept_pushes:
        what = "pushes: places over time with the law, and residuals"
        drawings.append(_svg(what, draw_pushes, session, fit, size=(4.2, 6.0), rows=2))
    parts = [
        f"<h1>{escape(setup.name)}</h1>",
        _story(session),
        _summary(fit, compared),
        "<h2>Friction</h2>",
        *drawings,
        _table(*fit.table()),
        f"<ul>{''.join(f'<li>{_prose(n)}</li>' for n in notes)}</ul>",
    ]
    if compared is not None:
        what = "speeds predicted and measured"
        drawn = _svg(what, draw_comparison, compared, size=(4.2, 5.2), **panels(compared))
        parts += ["<h2>Speed</h2>", drawn, _table(*compared.table(verbose=False))]
    if advice is not None:
        heads, cells = advice.table()
        listed = _table(heads, cells, "words") if cells else ""
        parts += ["<h2>The next reading</h2>", f"<p>{_prose(advice.in_words())}</p>{listed}"]
    parts += [
        "<h2>Readings</h2>",
        _readings(session, fit),
        "<h2>Where this comes from</h2>",
        _provenance(session, fit),
    ]
    head = (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(setup.name)}: friction and speed</title><style>{_STYLE}</style></head>"
    )
    return head + "<body>\n<main>\n" + "\n".join(parts) + "\n</main>\n</body></html>\n"


def _svg(
    what: str, draw: Callable[..., None], *shown: Any, size: tuple[float, float], **panels: Any
) -> str:
    """Return a drawing as a picture in the page; salted ids make it the same again."""
    file = io.BytesIO()
    with figure(*size, **panels) as (fig, axes):
        draw(fig, axes, *shown)
        fig.savefig(file, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    data = base64.b64encode(file.getvalue()).decode()
    picture = f'<img alt="{escape(what)}" src="data:image/svg+xml;base64,{data}">'
    return f'<figure tabindex="0">{picture}</figure>'


def _table(head: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "") -> str:
    """Return a table; kind: "words" where it has text, not numbers."""
    return _framed(head, "".join(map(_row, rows)), kind)


def _row(cells: Sequence[str], kind: str = "") -> str:
    return f'<tr class="{kind}">' + "".join(f"<td>{_prose(c)}</td>" for c in cells) + "</tr>"


def _framed(head: Sequence[str], body: str, kind: str) -> str:
    top = "".join(f'<th scope="col">{escape(h)}</th>' for h in head)
    return (
        f'<div class="wide" tabindex="0"><table class="{kind}"><tr>{top}</tr>{body}</table></div>'
    )


def _story(session: Session) -> str:
    setup, robot = session.setup, session.setup.robot
    place = setup.laboratory
    where = ", ".join(x for x in (place.surface, place.place, place.people) if x != "not said")
    return (
        f'<p class="soft">A {escape(setup.provenance.kind)} session: a robot of {robot.links} '
        f"links, {robot.mass_kg:.4g} kg, {robot.links * robot.link_length_m:.3g} m"
        f"{escape('; ' + where if where else '')}. {escape(str(session))}.</p>"
    )


def _summary(fit: FrictionFit, compared: Comparison | None) -> str:
    text = (
        "The readings agree with one another."
        if fit.p_value is None or fit.p_value >= DOUBTFUL
        else "The readings disagree by more than their stated errors allow."
    )
    more = "" if compared is None else f" {compared.verdict_text}"
    return f'<p class="verdict">{_prose(text + more)}</p>'


def _prose(text: str) -> str:
    """Return a sentence for the page: commands, which stand between backticks, as code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def _readings(session: Session, fit: FrictionFit) -> str:
    """Return one table of all readings, with how far those in the fit are off.

    Remarks stand in rows of their own, so that the table is no wider than a phone.
    """
    fitted = zip(session.fitted, fit.residuals, strict=True)
    residuals = {reading.number: f"{round(residual, 1) + 0.0:+.1f}" for reading, residual in fitted}
    body = ""
    for r in session.readings:
        cells = [str(r.number), *r.in_words(), residuals.get(r.number, "")]
        body += _row(cells, "void" if r.voided else "")
        remark = ": ".join(filter(None, ["voided" if r.voided else "", r.comment]))
        if remark:
            body += f'<tr class="said"><td colspan="4">{escape(remark)}</td></tr>'
    return _framed(["no.", "what", "shown", "off by, σ"], body, "words off")


def _provenance(session: Session, fit: FrictionFit) -> str:
    from importlib.metadata import version

    setup = session.setup
    boards = list(dict.fromkeys(e.detail for e in session.events if e.event == "connect"))
    driven = f"<p>Robot: {escape('; '.join(boards))}.</p>" if boards else ""
    provenance = setup.provenance
    note = "" if provenance.note == "none" else f'<p class="soft">{escape(provenance.note)}</p>'
    return (
        f"<p>{escape(provenance.source)}</p>{driven}{note}"
        f"<p>Fitted ({escape(fit.method)}) by serpenoid {escape(version('serpenoid'))}; readings' "
        f"SHA-256 <code>{escape(fit.session_sha256)}</code>. To cite: the session by its name and "
        "hash, the program by its CITATION.cff, and Nirakh, Brennan and Gandhi, IMECE2005-82742, "
        "for models and procedure.</p>"
    )
