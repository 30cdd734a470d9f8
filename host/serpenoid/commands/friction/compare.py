"""`serpenoid compare`: the robot's measured speeds beside those its friction predicts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..declare import number, option
from ..given import session_fit
from ..options import (
    AS_TABLES,
    listed_gaits,
    servo_option,
    show_json,
    take_servo,
    tell,
)
from ..paths import FIGURES, FOLDER, out_file

if TYPE_CHECKING:
    from ...model.gait import Gait


@click.command()
@click.argument("session", type=FOLDER)
@listed_gaits
@number(
    "--amplitude-sigma",
    "Standard deviation of the joints' true over commanded amplitude.",
    default=0.03,
)
@servo_option
@option("--samples", "Frictions drawn from the fit.", type=click.IntRange(16, 4096), default=64)
@option(
    "--beside",
    "other",
    "Another session of this robot: do both tell the same friction?",
    type=FOLDER,
)
@option("--plot", "figure", "Draw it into this file.", type=out_file(*FIGURES))
@AS_TABLES
def compare(
    session: Path,
    gaits: list[Gait],
    amplitude_sigma: float,
    samples: int,
    other: Path | None,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Compare a session's gait runs with the speeds that its friction predicts.

    Exact and implicit model, with the 95 % bands of sampled frictions, and of amplitude and servos
    besides; then a verdict in words. Any hobby servo may move the joints unless --servo says which.

    With --beside the frictions of two sessions are compared instead, such as of treadmill and
    floor: they agree within their intervals, or which differs.
    """
    if other is not None:
        return _sessions(session, other, as_json)
    from ...calibration import comparison
    from ...calibration.session_file import load_session
    from ...show import report
    from ...show.progress import progress

    loaded = load_session(session)
    fit = session_fit(session, with_crawls=False)
    with progress(comparison.gait_count(loaded, gaits), "gaits") as advance:
        found = comparison.compare(
            loaded,
            fit,
            gaits=gaits,
            amplitude_sigma=amplitude_sigma,
            samples=samples,
            servo=take_servo("hobby"),
            progress=advance,
        )
    if figure is not None:
        from ...show.comparison_figure import comparison_figure
        from ...show.figure_data import beside

        comparison_figure(found, figure)
        report.wrote(figure, beside(figure))
    return tell(found, as_json)


def _sessions(first: Path, second: Path, as_json: bool) -> None:
    from ...calibration.advising.two_fits import two_sessions
    from ...calibration.session_file import load_session
    from ...show import report

    found = two_sessions(load_session(first), load_session(second))
    if as_json:
        return show_json(found.to_dict())
    report.console.print(f"p = {found.p_value:.2g}. {found.verdict}")
    return report.table("friction in two sessions, whole snake", *found.table())
