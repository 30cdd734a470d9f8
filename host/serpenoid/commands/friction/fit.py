"""`serpenoid fit`: friction from a session's readings, kept as fit.json beside them."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ...model.errors import SerpenoidError
from ...show.screen import say
from ..declare import flag, option
from ..options import AS_TABLES, servo_option, show_json, take_servo
from ..paths import FIGURES, FOLDER, out_file

if TYPE_CHECKING:
    from ...calibration.friction_result import FrictionFit
    from ...calibration.session import Session

MANY = 300  # readings, whose fit may take a second or more


@click.command()
@click.argument("session", type=FOLDER)
@option(
    "--method",
    "Honest intervals; the same with misreadings in it; or the paper's two lines.",
    choice=["joint", "robust", "naive"],
    default="joint",
)
@flag("--crawls", "Fit the gait runs and films, too, or alone; some 20 s.")
@servo_option
@option(
    "--plot",
    "figure",
    "Draw the lines and readings into this PNG, PDF or SVG.",
    type=out_file(*FIGURES),
)
@flag("--influence", "List what every reading does to the fit.")
@option("--save/--no-save", "Keep it as fit.json beside the readings (not if naive).", default=True)
@AS_TABLES
def fit(
    session: Path,
    method: str,
    crawls: bool,
    figure: Path | None,
    influence: bool,
    save: bool,
    as_json: bool,
) -> None:
    """Fit friction to a session's readings: stations (Eqs. 58-62), pushes and slides.

    Crawls stay out, since `compare` tests predictions by them. --crawls fits them, too: any hobby
    servo may have moved the joints unless --servo says which.

    Prints the whole snake's friction and each link's; --session DIR gives it to any other command.
    """
    from ...calibration.advising.break_away import break_away_notes
    from ...calibration.friction_fit import fit_friction
    from ...calibration.session_file import load_session
    from ...show import report
    from ...show.progress import working

    loaded = load_session(session)
    count = len(loaded.kept)
    servo = take_servo("hobby") if crawls else None
    with working(f"fitting {count} readings") if count > MANY or crawls else nullcontext():
        found = fit_friction(loaded, method=method, crawls=crawls, servo=servo)
    if figure is not None:
        _draw(loaded, found, figure)
    not_kept = _save(found, session) if save and method != "naive" else None
    if as_json:
        show_json(found.to_dict())
    else:
        report.show(found)
        notes = [f"note: {note}" for note in break_away_notes(found, loaded)]
        say("\n".join([*found.remarks, *notes]))
        if influence:
            report.influence(found)
    if not_kept is not None:
        raise SerpenoidError(
            f"{not_kept}: the fit is shown, but not kept as fit.json"
        ) from not_kept


def _save(found: FrictionFit, session: Path) -> OSError | None:
    """Keep the fit beside the readings; return why not, if so."""
    from ...calibration.fit_file import save_fit

    try:
        save_fit(found, session)
    except OSError as error:
        return error
    return None


def _draw(session: Session, found: FrictionFit, figure: Path) -> None:
    """Draw what there is: pushes over time, or stations with their lines."""
    if session.on_floor:
        from ...show.session.floor_figure import push_figure

        return push_figure(session, found, figure)
    from ...show.figure_data import beside
    from ...show.plot import friction_lines
    from ...show.report import wrote

    friction_lines(session, found, figure)
    return wrote(figure, beside(figure))
