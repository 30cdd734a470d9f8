"""The commands of `serpenoid video`: tags to print, and a film to numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import serpenoid as sn

from ..base.checks import POSITIVE, check_number
from ..show.screen import say
from .declare import (
    EXISTING,
    FOLDER,
    OutFile,
    Values,
    group_settings,
    number,
    option,
    row,
    settings,
)
from .group import Commands
from .options import busy, make_gait, named_snake, show_json

if TYPE_CHECKING:
    from ..video.result import FilmMeasurement


@click.group(name="video", cls=Commands, usual="film")
def VIDEO_GROUP() -> None:
    """Measure speed, path and every joint from a film of the robot with printed tags.

    `serpenoid video tags` prints the tags; `serpenoid video FILE` measures a film.
    """


row(
    "session_folder",
    option(
        "--session",
        "session_folder",
        "Session with this robot; a measured film becomes one of its readings.",
        type=FOLDER,
    ),
)
row(
    "tag_mm",
    number(
        "--tag-mm",
        "Side of a tag's black square; that of the session or of the sheet unless given.",
    ),
)


def _robot(
    session: Path | None, tag_mm: float | None, settings: Values
) -> tuple[sn.Robot, float | None]:
    """Return the robot and its tags' side (m): of the options, else of the session."""
    from ..session.folder import read_session

    setup = read_session(session).setup if session else None
    base = setup.robot if setup else named_snake("2005").robot
    sizes = group_settings(settings, "sizes")
    side_m = setup.robot_table.tag_side_m if setup else None
    side_m = side_m if tag_mm is None else check_number("tag_mm", tag_mm, *POSITIVE) / 1e3
    return replace(base, **sizes, link_inertia_kg_m2=None), side_m


@VIDEO_GROUP.command()
@option("--paper", "Size of the paper.", choice=["a4", "letter"], default="a4")
@option(
    "--out",
    "path",
    "File to write.",
    type=OutFile(".pdf", ".png", ".svg"),
    default=Path("tags.pdf"),
)
@settings("sizes")
def tags(
    session_folder: Path | None, tag_mm: float | None, paper: str, path: Path, settings: Values
) -> None:
    """Write a sheet of tags to print: one for each link, with cut lines and a ruler."""
    from ..show.video.tag_sheet import tag_sheet
    from ..video.seeing.extra import need_extra
    from ..video.seeing.tags import tag_cells, tag_side_m

    need_extra()
    robot, side = _robot(session_folder, tag_mm, settings)
    side = side or tag_side_m(robot.link_length_m)
    tag_sheet(tag_cells(robot.links), side, robot.link_length_m, paper, path)
    say(f"wrote {path}: {robot.links} tags of {1e3 * side:g} mm; print at 100 %")


@VIDEO_GROUP.command()
@click.argument("file", type=click.Path(path_type=Path))
@option(
    "--recording",
    "The run's recording (.wire), which has its gait and the board's time.",
    type=EXISTING,
)
@option(
    "--way",
    "Direction of the crawl along the line of the session's pushes; level ground unless given.",
    choice=["there", "back"],
)
@option("--track", "Table to write: time, position, heading, joint angles.", type=OutFile(".csv"))
@settings("sizes", "offset")
def film(
    file: Path,
    session_folder: Path | None,
    tag_mm: float | None,
    settings: Values,
    recording: Path | None,
    way: str | None,
    capture_fps: float | None,
    track: Path | None,
    figure: Path | None,
    as_json: bool,
    **typed_gait: Any,
) -> None:
    """Measure a film: speed, path, turn, rate, and each joint's amplitude, centre and phase.

    Each with its standard deviation. With a gait or a recording, joints are compared with what
    was commanded.
    """
    from ..robot.recording.run_gait import recorded_gait
    from ..show.report import wrote
    from ..show.video.film_figure import film_figure, show_film
    from ..video.measure_film import measure_film
    from ..video.result import write_track

    if way is not None and session_folder is None:
        raise click.UsageError("--way is along the line of a session's pushes; give --session")
    robot, side = _robot(session_folder, tag_mm, settings)
    typed = group_settings(settings, "offset") | {
        n: v for n, v in typed_gait.items() if v is not None
    }
    if recording and typed:
        raise click.UsageError("--recording has the gait; leave the gait's options out")
    gait = recorded_gait(recording, robot.links - 1) if recording else None
    gait = make_gait(typed) if typed else gait
    how: Values = {"board_rate": recording is not None, "capture_fps": capture_fps}
    arguments = file, robot.links, robot.link_length_m, side, gait
    film = busy("watching the film", lambda share: measure_film(*arguments, progress=share, **how))
    if track is not None:
        write_track(film.measured, track)
    if figure is not None:
        film_figure(film, figure)
    wrote(track, figure)
    if as_json:
        show_json(film.run.to_dict())
    else:
        show_film(film)
    if session_folder is not None:
        _record(film, session_folder, file.name, way)


def _record(measured: FilmMeasurement, session: Path, name: str, way: str | None) -> None:
    """Write the film's numbers and its track into a session.

    way: along the line of the pushes; None: on level ground. A film that cannot be a reading, or is
    one already, is told of, and its numbers are shown all the same.
    """
    from ..session.journal import Journal
    from ..video.made_gait import film_cells

    with Journal(session) as journal:
        try:
            cells, samples = film_cells(measured, journal.session.setup.plan.gaits)
            cells |= {} if way is None else {"way": way}
            number = journal.add("video", cells, comment=name, samples=samples)
        except sn.BadInput as error:
            return say(f"serpenoid: warning: no reading: {error}", err=True)
    return say(f"{session}: reading {number}", err=True)
