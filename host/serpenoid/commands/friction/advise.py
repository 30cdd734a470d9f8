"""`serpenoid advise`: the next reading that is worth most."""

from __future__ import annotations

from pathlib import Path

import click

from ..given import session_fit
from ..options import AS_JSON, listed_gait, servo_option, show_json, take_servo
from ..paths import FOLDER


@click.command()
@click.argument("session", type=FOLDER)
@click.option(
    "--gait",
    "gaits",
    nargs=3,
    type=float,
    multiple=True,
    metavar="ALPHA_DEG BETA_DEG HZ",
    help="A gait that matters.",
)
@click.option(
    "--samples",
    type=click.IntRange(16, 4096),
    default=48,
    show_default=True,
    help="Frictions drawn from the fit.",
)
@click.option("--runs", is_flag=True, help="Count gait runs, too, which no friction fit uses.")
@servo_option
@AS_JSON
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
    from ...show.friction_report import show_advice
    from ...show.progress import progress

    wanted = [listed_gait(*gait) for gait in gaits]
    loaded = load_session(session)
    session_fit(session)  # tells its alarms
    with progress(len(wanted) or len(loaded.setup.procedure.gaits), "gaits") as advance:
        servo = take_servo(servo_name, "hobby")
        found = ask(loaded, wanted, samples=samples, runs=runs, servo=servo, progress=advance)
    show_json(found.to_dict()) if as_json else show_advice(found)
