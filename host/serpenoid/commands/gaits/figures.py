"""The command `serpenoid figures`: the study of 2005 remade, figure by figure, claim by claim."""

from __future__ import annotations

from pathlib import Path

import click

from ...show.screen import progress, say
from ..declare import directory, option
from ..options import AS_JSON, interruptible, show_json, write_json


@click.command()
@option(
    "--out",
    "Folder for figures, their data and the page.",
    type=directory,
    default=Path("figures-out"),
)
@option("--power", "Mean of P, of |P| or of P+.", choice=["net", "abs", "positive"], default="net")
@option(
    "--angles",
    "What Eq. 57 drives: joints, or links.",
    choice=["joint", "absolute"],
    default="joint",
)
@option(
    "--speed-along",
    "Direction the speed counts in: of travel, or global x.",
    choice=["mean", "x"],
    default="mean",
)
@AS_JSON
def figures(out: Path, power: str, angles: str, speed_along: str, as_json: bool) -> None:
    """Draw the figures of the 2005 paper anew, and set its claims beside what is found.

    Writes Figs. 6 to 13 and 15 to 17, fronts of least-power gaits, the robot crawling (SVG), a data
    file beside each, claims.json and index.html. Some twenty seconds. Joints follow the gait
    exactly, as the paper's do, so there is no --servo; the speeds of Fig. 17 have the band of any
    hobby servo beside them.
    """
    from ...paper.claims import as_dict
    from ...paper.study import Reading
    from ...show.gaits.paper_page import claim_table, write_page
    from .remade import draw

    out.mkdir(parents=True, exist_ok=True)
    reading = Reading(power, angles, speed_along)
    with progress(6, "figures") as advance:
        found, shown = interruptible(lambda: draw(out, reading, advance))
    values = as_dict(found, reading)
    write_json(out / "claims.json", values)
    write_page(out / "index.html", found, shown, values["reading"])
    if as_json:
        show_json(values | {"page": str(out / "index.html")})
    else:
        claim_table(found)
        say(f"wrote {out / 'index.html'} and {len(shown)} figures with their data")
