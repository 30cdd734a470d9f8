"""The command `serpenoid figures`: the study of 2005 remade, figure by figure, claim by claim."""

from __future__ import annotations

from pathlib import Path

import click

from ...show.screen import progress, say
from ..declare import Command, directory, option
from ..options import AS_JSON, interruptible, show_json, write_json

STEPS = 6  # of the progress


@click.command(cls=Command)
@option("--out", "Folder for figures and claims.", type=directory, default=Path("figures-out"))
@AS_JSON
def figures(out: Path, as_json: bool) -> None:
    """Draw the figures of the 2005 paper anew, and set its claims beside what is found.

    Writes Figs. 6 to 13 and 15 to 17, the front of least power of the 2005 robot, and claims.json.
    Some twenty seconds. Joints follow the gait exactly, as the paper's do, so there is no --servo;
    the speeds of Fig. 17 have the band of any hobby servo beside them.
    """
    from ...paper.claims import as_dict
    from ...show.report import table
    from .remade import draw

    out.mkdir(parents=True, exist_ok=True)
    with progress(STEPS, "figures") as advance:
        found = interruptible(lambda: draw(out, advance))
    values = as_dict(found)
    write_json(out / "claims.json", values)
    if as_json:
        show_json(values)
    else:
        cells = [[c.where, c.paper, c.here, c.verdict] for c in found]
        table("the paper's claims", ["where", "the paper", "here", "verdict"], cells, 4)
        say(f"wrote {out / 'claims.json'} and the figures")
