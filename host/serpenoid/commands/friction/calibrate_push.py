"""`serpenoid calibrate push`: tracks of pushes from files, cut, looked at and kept."""

from __future__ import annotations

from pathlib import Path

import click

from ...show.screen import say
from ..declare import EXISTING, command, number, option


@command()
@click.argument("files", nargs=-1, required=True, type=EXISTING)
@number(
    "--lambda-deg",
    "Bend of the robot, as the protractor showed it; 0 where straight.",
    default=0.0,
)
@option(
    "--way",
    "Direction of the first file's first push; each next file begins the other way.",
    choice=["there", "back"],
    default="there",
)
@option(
    "--unit",
    "Unit of lengths, for a table that names none.",
    choice=["m", "cm", "mm", "in", "ft", "yd"],
)
@option("--place", "Name of the line on the floor, where there is more than one.", default="")
def push(
    folder: Path,
    files: tuple[Path, ...],
    lambda_deg: float,
    way: str,
    unit: str | None,
    place: str,
    capture_fps: float | None,
) -> None:
    """Take pushes along a floor from FILES: films, tracks of Tracker or Kinovea, CSV of t, x, y.

    In a film the robot wears the tags of `serpenoid video tags`, and holds its joints still. A
    file may hold several pushes: it is cut by itself, and each goes there or back as the picture
    shows. The hand's part is found and left out. A push that turned, was short or hit something is
    kept, void, with the reason.
    """
    from ...session.journal import Journal
    from ...taking.films import other_way, push_in_words, take_track
    from .calibrate_person import film_reader

    with Journal(folder) as journal:
        film = film_reader(journal.session.setup.robot_table.tag_side_m, capture_fps)
        for path in files:
            cells: dict[str, float | str] = {"lambda_deg": lambda_deg, "way": way}
            cells |= {"place": place} if place else {}
            pushes = take_track(journal, path, unit, cells, film, say, capture_fps)
            for reading in pushes:
                say(push_in_words(reading))
            # The robot was turned round after the last push; a void piece may be a hand.
            way = other_way(([push for push in pushes if not push.voided] or pushes)[-1].way)
