"""`serpenoid fit`, and what rests on a fit: `advise`, `compare`, `report`."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import click

import serpenoid as sn

from ...show.screen import progress, say, working
from ..declare import FIGURES, FOLDER, flag, number, option, out_file
from ..given import session_fit
from ..options import AS_JSON, AS_TABLES, listed_gaits, servo_option, show_json, take_servo, tell

MANY = 300  # readings, whose fit may take a second or more


@click.command()
@click.argument("session", type=FOLDER)
@option(
    "--method",
    "Honest intervals, or the paper's two lines.",
    choice=["joint", "naive"],
    default="joint",
)
@flag("--crawls", "Fit the gait runs and films, too, or alone; some 10 s.")
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
    """Fit friction to a session's readings: stations (Eqs. 58-62) and pushes.

    Crawls stay out, since `compare` tests predictions by them. --crawls fits them, too: any hobby
    servo may have moved the joints unless --servo says which.

    Prints the whole snake's friction and each link's; --session DIR gives it to any other command.
    """
    from ...show import report

    loaded = sn.load_session(session)
    for note in loaded.notes:
        say(f"note: {note}", err=True)
    count = len(loaded.kept)
    servo = take_servo("hobby") if crawls else None
    with working(f"fitting {count} readings") if count > MANY or crawls else nullcontext():
        fit = sn.fit_friction(loaded, method=method, crawls=crawls, servo=servo)
    if figure is not None:
        from ...show.plot import friction_lines
        from ...show.session.floor_figure import push_figure

        if loaded.on_floor:
            push_figure(loaded, fit, figure)
        else:
            friction_lines(loaded, fit, figure)
        report.wrote(figure)
    not_kept = None
    if save and method != "naive":
        try:
            sn.save_fit(fit, session)
        except OSError as error:
            not_kept = error
    if as_json:
        show_json(fit.to_dict())
    else:
        report.show(fit)
        say("\n".join(fit.remarks))
        if influence:
            report.influence(fit)
    if not_kept is not None:
        raise sn.SerpenoidError(
            f"{not_kept}: the fit is shown, but not kept as fit.json"
        ) from not_kept


@click.command()
@click.argument("session", type=FOLDER)
@listed_gaits
@option("--samples", "Frictions drawn from the fit.", type=click.IntRange(16, 4096), default=64)
@flag("--runs", "Count gait runs, too, which no friction fit uses.")
@servo_option
@AS_TABLES
def advise(
    session: Path,
    gaits: list[sn.Gait],
    samples: int,
    runs: bool,
    as_json: bool,
) -> None:
    """Tell which reading to take next: the one that shrinks the predicted speeds' band most.

    The band is that of `compare`: any hobby servo may move the joints unless --servo says which.
    """
    loaded = sn.load_session(session)
    session_fit(session)  # tells its alarms
    with progress(len(gaits) or len(loaded.setup.procedure.gaits), "gaits") as advance:
        servo = take_servo("hobby")
        advice = sn.advise(loaded, gaits, samples=samples, runs=runs, servo=servo, progress=advance)
    tell(advice, as_json)


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
@option("--plot", "figure", "Draw it into this file.", type=out_file(*FIGURES))
@AS_TABLES
def compare(
    session: Path,
    gaits: list[sn.Gait],
    amplitude_sigma: float,
    samples: int,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Compare a session's gait runs with the speeds that its friction predicts.

    Exact and implicit model, with the 95 % bands of sampled frictions, and of amplitude and servos
    besides; then a verdict in words. Any hobby servo may move the joints unless --servo says which.
    """
    from ...prediction import comparison
    from ...show import report

    loaded = sn.load_session(session)
    fit = session_fit(session, with_crawls=False)
    with progress(comparison.gait_count(loaded, gaits), "gaits") as advance:
        compared = comparison.compare(
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

        comparison_figure(compared, figure)
        report.wrote(figure)
    tell(compared, as_json)


@click.command()
@click.argument("session", type=FOLDER)
@option("--out", "Where to; report.html in the session's folder.", type=out_file(".html"))
@servo_option
@AS_JSON
def report(
    session: Path,
    out: Path | None,
    as_json: bool,
) -> None:
    """Write a session's report: one self-contained HTML file, the same bytes when made again.

    Its speeds are those of `compare` and `advise`: any hobby servo unless --servo says which. Where
    only crawls tell the friction, nothing is left to test it by.
    """
    from ...base.files import write_text
    from ...prediction import advice, comparison
    from ...session.folder import load_session
    from ...show.session.report_page import session_page

    out = out or session / "report.html"
    compared = advised = None
    servo = take_servo("hobby")
    loaded = load_session(session)
    fit = tested = session_fit(session)
    if fit.with_crawls:
        try:
            tested = session_fit(session, with_crawls=False)
        except sn.BadInput as error:
            tested = None
            say(f"note: the report has no comparison and no advice: {error}", err=True)
    if tested and comparison.compared_gaits(loaded):
        with progress(comparison.gait_count(loaded), "gaits") as advance:
            compared = comparison.compare(loaded, tested, servo=servo, progress=advance)
    if tested and loaded.setup.procedure.gaits:
        advised = advice.advise(loaded, servo=servo)
    page = session_page(loaded, fit, compared, advised)
    write_text(out, page)
    verdict = None if compared is None else compared.verdict
    show_json({"report": str(out), "verdict": verdict}) if as_json else say(f"wrote {out}")
