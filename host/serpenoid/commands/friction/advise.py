"""`serpenoid advise`: the next reading that is worth most."""

from __future__ import annotations

from pathlib import Path

import click

from ..declare import flag, option
from ..given import session_fit
from ..options import AS_TABLES, listed_gait, listed_gaits, servo_option, take_servo, tell
from ..paths import FOLDER


@click.command()
@click.argument("session", type=FOLDER)
@listed_gaits
@option("--samples", "Frictions drawn from the fit.", type=click.IntRange(16, 4096), default=48)
@flag("--runs", "Count gait runs, too, which no friction fit uses.")
@servo_option
@AS_TABLES
def advise(
    session: Path,
    gaits: tuple[tuple[float, float, float], ...],
    samples: int,
    runs: bool,
    servo_name: str | None,
    as_json: bool,
) -> None:
    """Tell which reading to take next: the one that shrinks the predicted speeds' band most.

    The band is that of `compare`: any hobby servo may move the joints unless --servo says which.
    """
    from ...calibration.advice import advise as ask
    from ...calibration.session_file import load_session
    from ...show.progress import progress

    wanted = [listed_gait(*gait) for gait in gaits]
    loaded = load_session(session)
    session_fit(session)  # tells its alarms
    with progress(len(wanted) or len(loaded.setup.procedure.gaits), "gaits") as advance:
        servo = take_servo(servo_name, "hobby")
        found = ask(loaded, wanted, samples=samples, runs=runs, servo=servo, progress=advance)
    tell(found, as_json)
