"""`serpenoid advise`: the next reading that is worth most."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..declare import flag, option
from ..given import session_fit
from ..options import AS_TABLES, listed_gaits, servo_option, take_servo, tell
from ..paths import FOLDER

if TYPE_CHECKING:
    from ...model.gait import Gait


@click.command()
@click.argument("session", type=FOLDER)
@listed_gaits
@option("--samples", "Frictions drawn from the fit.", type=click.IntRange(16, 4096), default=48)
@flag("--runs", "Count gait runs, too, which no friction fit uses.")
@servo_option
@AS_TABLES
def advise(
    session: Path,
    gaits: list[Gait],
    samples: int,
    runs: bool,
    as_json: bool,
) -> None:
    """Tell which reading to take next: the one that shrinks the predicted speeds' band most.

    The band is that of `compare`: any hobby servo may move the joints unless --servo says which.
    """
    from ...calibration.advice import advise as ask
    from ...calibration.session_file import load_session
    from ...show.progress import progress

    loaded = load_session(session)
    session_fit(session)  # tells its alarms
    with progress(len(gaits) or len(loaded.setup.procedure.gaits), "gaits") as advance:
        servo = take_servo("hobby")
        found = ask(loaded, gaits, samples=samples, runs=runs, servo=servo, progress=advance)
    tell(found, as_json)
