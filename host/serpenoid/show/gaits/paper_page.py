"""The remade study as one page and one table: figures, then the paper's claims beside ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from ..report import console

if TYPE_CHECKING:
    from ...gaits.paper_study import Claim

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }
table { border-collapse: collapse; font-size: 0.9rem } td, th { border-bottom: 1px solid #ccc;
padding: 0.4rem 0.6rem; text-align: left; vertical-align: top } img { max-width: 100% }
figure { margin: 2rem 0 } code { font-size: 0.8rem } .differs { font-weight: 600 }
"""


def claim_table(claims: Sequence[Claim]) -> None:
    """Print the claims, what is found here, and the verdicts."""
    made = Table(title="the paper's claims", title_justify="left", title_style="bold")
    for column in ("where", "the paper", "here", "verdict"):
        made.add_column(column)
    for claim in claims:
        made.add_row(claim.where, claim.paper, claim.here, claim.verdict)
    console.print(made)


def write_page(
    path: Path,
    claims: Sequence[Claim],
    shown: Sequence[tuple[str, str]],
    reading: Mapping[str, str],
) -> None:
    """Write the page; its figures stand beside it, each with its data."""
    rows = "".join(
        f"<tr><td>{escape(c.where)}</td><td>{escape(c.paper)}</td><td>{escape(c.here)}</td>"
        f'<td class="{c.verdict.split()[0]}">{escape(c.verdict)}</td>'
        f"<td><code>serpenoid {escape(c.command)}</code></td></tr>\n"
        for c in claims
    )
    figures = "".join(
        f'<figure><img src="{name}" alt="{escape(caption)}"><figcaption>{escape(caption)} '
        f'(<a href="{Path(name).with_suffix(".csv").name}">data</a>)</figcaption></figure>\n'
        if (path.parent / name).with_suffix(".csv").exists()
        else f'<figure><img src="{name}" alt="{escape(caption)}"><figcaption>{escape(caption)}'
        "</figcaption></figure>\n"
        for name, caption in shown
    )
    read = ", ".join(f"{name.replace('_', ' ')}: {value}" for name, value in reading.items())
    path.write_text(
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n'
        f"<title>The study of 2005, remade</title><style>{_STYLE}</style></head><body>\n"
        "<h1>The study of 2005, remade</h1>\n<p>An implicit model for snake robot locomotion and "
        "gait optimization (IMECE2005-82742): its figures computed anew, and its claims one by "
        f"one. Read as: {escape(read)}.</p>\n<table><tr><th>where</th><th>the paper</th>"
        f"<th>here</th><th>verdict</th><th>see it by</th></tr>\n{rows}</table>\n{figures}"
        "</body></html>\n"
    )
