"""The remade study as one page and one table: figures, then the paper's claims beside ours."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from ...lab.belt import Belt
from ...lab.robot import LabRobot, pose_of
from ...model.bends import balanced_signs
from ...model.files import write_text
from ...model.ground import Ground
from ...model.robot import Robot
from ...paper.claims import Claim
from ..report import table

_STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #fff; --link: #0a58ca; --line: #d0d7de }
@media (prefers-color-scheme: dark) {
:root { --ink: #e6edf3; --paper: #14181d; --link: #79b8ff; --line: #3a434d }
img { filter: invert(.92) hue-rotate(180deg) } }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem;
color: var(--ink); background: var(--paper) }
a { color: var(--link) } nav ul { display: flex; flex-wrap: wrap; gap: .2rem 1.2rem; padding: 0;
list-style: none }
.wide, figure { overflow-x: auto } table { border-collapse: collapse; font-size: 0.9rem }
td, th { border-bottom: 1px solid var(--line); padding: 0.4rem 0.6rem; text-align: left;
vertical-align: top; min-width: 5rem } figure { margin: 2rem 0 } code { font-size: 0.85rem }
p code { white-space: nowrap }
img { display: block; max-width: 100%; min-width: min(36rem, 100%); background: #fff }
.differs { font-weight: 600 }
@media (max-width: 40rem) { img { max-width: none; width: 40rem }
table, tbody, tr, td { display: block } th { display: none }
tr { border-bottom: 1px solid var(--line); padding: 0.5rem 0 }
td { border: 0; padding: 0.1rem 0 } td:nth-child(1) { font-weight: 600 }
td:nth-child(2)::before { content: "the paper: " } td:nth-child(3)::before { content: "here: " }
figcaption { position: sticky; left: 0; width: calc(100vw - 2rem) } }
"""
_READ = {
    "power": {"net": "the net mean of P", "abs": "the mean of |P|", "positive": "the mean of P+"},
    "angles": {"joint": "the joints", "absolute": "the links"},
    "speed_along": {"mean": "the mean direction of travel", "x": "global x"},
}
_VERDICTS = {
    "agrees": "agree",
    "in part": "agree in part",
    "differs": "differ",
    "not comparable": "cannot be compared",
}


def claim_table(claims: Sequence[Claim]) -> None:
    """Print the claims, what is found here, and the verdicts."""
    cells = [[c.where, c.paper, c.here, c.verdict] for c in claims]
    table("the paper's claims", ["where", "the paper", "here", "verdict"], cells, 4)


def write_page(
    path: Path,
    claims: Sequence[Claim],
    shown: Sequence[tuple[str, str]],
    reading: Mapping[str, str],
) -> None:
    """Write the page; its figures stand beside it, each with its data."""
    count = Counter(claim.verdict for claim in claims)
    verdicts = ", ".join(f"{count[v]} {words}" for v, words in _VERDICTS.items() if count[v])
    parts = [("claims", "The claims"), *((Path(n).stem, c.split(":")[0]) for n, c in shown)]
    links = "".join(f'<li><a href="#{at}">{escape(words)}</a></li>' for at, words in parts)
    power, angles, along = (escape(_READ[name][reading[name]]) for name in _READ)
    rows = "".join(
        f"<tr><td>{_where(c, shown)}</td><td>{escape(c.paper)}</td><td>{escape(c.here)}</td>"
        f'<td class="{c.verdict.split()[0]}">{escape(c.verdict)}</td>'
        f"<td><code>serpenoid {escape(c.command)}</code></td></tr>\n"
        for c in claims
    )
    figures = ""
    for name, caption in shown:
        data = Path(name).with_suffix(".csv").name
        link = f' (<a href="{data}">data</a>)' if (path.parent / data).exists() else ""
        figures += (
            f'<figure id="{Path(name).stem}" tabindex="0"><img src="{name}" '
            f'alt="{escape(caption)}"><figcaption>{escape(caption)}{link}</figcaption></figure>\n'
        )
    write_text(
        path,
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>The study of 2005, remade</title><style>{_STYLE}</style></head><body>\n"
        "<main><h1>The study of 2005, remade</h1>\n<p>Nirakh, Brennan and Gandhi, <em>An "
        "Implicit Model for Snake Robot Locomotion and Gait Optimization</em> (IMECE2005-82742): "
        "its figures computed anew, and its claims one by one. "
        f"Of {len(claims)} claims {verdicts}.</p>\n"
        f'<nav aria-label="On this page"><ul>{links}</ul></nav>\n'
        f"<p>Where the paper leaves it open: power is {power}, Eq. 57 drives the angles of "
        f"{angles}, speed counts along {along}; <code>serpenoid figures</code> with "
        "<code>--power</code>, <code>--angles</code> or <code>--speed-along</code> reads it the "
        "other ways. β is the lag from joint to joint, α the amplitude, ω the rate, k the "
        "stiffness of the implicit model's joints; ct and cn are viscous friction along and "
        "across a link, ft0 and fn0 dry friction.</p>\n"
        '<h2 id="claims">The claims</h2>\n<div class=wide role="region" tabindex="0" '
        'aria-labelledby="claims"><table><tr><th scope="col">where</th><th scope="col">the paper'
        '</th><th scope="col">here</th><th scope="col">verdict</th><th scope="col">see it by</th>'
        f"</tr>\n{rows}</table></div>\n<p>{_let_go()}</p>\n{figures}</main></body></html>\n",
    )


def _let_go() -> str:
    """Return what becomes of the paper's bent posture on a belt, and of a balanced one."""
    zigzag, balanced = (
        abs(turned_deg([(-1) ** k for k in range(6)], 1.0)),
        abs(turned_deg(balanced_signs(6), 1.0)),
    )
    return (
        "Eq. 60 holds a snake whose every link is at λ, left and right in turn. Its forces "
        "balance, its moments do not: let go on the belt at λ = 7.5° in that very balance, the "
        f"2005 robot turns by {zigzag:.0f}° in one second. The paper tells of no guide; without "
        "one, its bent readings are not of Eq. 60, and C<sub>n</sub> = 1.2 N s/m is uncertain. "
        f"With links at + − 0 0 − + times λ it turns by {balanced:.1f}°: "
        "<code>serpenoid calibrate</code> bends it so."
    )


def turned_deg(signs: Sequence[int], duration_s: float) -> float:
    """Return by how much the 2005 robot turns, let go on a belt where Eq. 60 balances at 7.5°."""
    robot = LabRobot.whole(Robot(6, 0.0756, 0.076), Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27))
    belt = Belt(robot)
    belt.pose(pose_of(signs, math.radians(7.5)))
    belt.tilt(math.radians(2.8))
    belt.run(0.42)
    belt.put()
    belt.wait(duration_s)
    return math.degrees(belt.look().heading_rad)


def _where(claim: Claim, shown: Sequence[tuple[str, str]]) -> str:
    """Return where a claim stands in the paper, linked to the figure here that shows it."""
    number = re.search(r"\d+", claim.where)
    for name, _ in shown:
        of = re.fullmatch(r"fig(\d+)(?:-(\d+))?", Path(name).stem)
        if number and of and int(of[1]) <= int(number[0]) <= int(of[2] or of[1]):
            return f'<a href="#{of[0]}">{escape(claim.where)}</a>'
    return escape(claim.where)
