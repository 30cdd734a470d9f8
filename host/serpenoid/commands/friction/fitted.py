"""`serpenoid fit`, and what rests on a fit: `advise`, `compare`, `report`."""

from __future__ import annotations

from pathlib import Path

import serpenoid as sn

from ...base.checks import NOT_NEGATIVE, Limits
from ...show.screen import say
from ..declare import SETTINGS, OutFile, Setting, Values, command, group_settings, option, settings
from ..options import busy, print_result, session_fit, show_json, typed_servo, warn_of_alarms

SETTINGS["samples"] = (
    Setting("samples", "samples of friction, drawn from the fit", "", Limits(16, 4096), "64"),
)
SETTINGS["amplitude"] = (
    Setting(
        "amplitude_sigma",
        "standard deviation of the joints' true over commanded amplitude",
        limits=NOT_NEGATIVE,
        usual="0.03",
    ),
)


def measured(
    folder: Path, servo: str | None, settings: Values
) -> tuple[sn.Session, sn.FrictionFit, sn.ServoKind | None, Values]:
    """Return a session, the fit of its readings, the servos, and the notes of the fit for JSON."""
    session = sn.load_session(folder)
    fit = session_fit(session)
    notes = warn_of_alarms(fit)
    return session, fit, typed_servo(servo, settings), notes


@command()
@option(
    "--method",
    "All parameters in one fit, with their intervals, or the paper's two lines.",
    choice=["joint", "naive"],
    default="joint",
)
@option("--save/--no-save", "Keep it as fit.json beside the readings (not if naive).", default=True)
def fit(
    session: Path,
    method: str,
    figure: Path | None,
    save: bool,
    verbose: bool,
    as_json: bool,
) -> None:
    """Fit friction to a session's readings: stations (equations 58 to 62) and pushes.

    Gait runs stay out: `compare` tests predictions by them.

    Prints the whole snake's friction and each link's, and with --verbose what every reading does
    to them; --robot DIR gives it to any other command.
    """
    from ...show import report

    loaded = sn.load_session(session)
    for note in loaded.notes:
        say(f"note: {note}", err=True)
    say(f"session.toml: {loaded.setup.in_words()}", err=True)
    fit = busy("fitting", lambda _: sn.fit_friction(loaded, method=method))
    if figure is not None:
        fit.plot(figure, session=loaded)
        report.wrote(figure)
    if as_json:
        show_json(fit.to_dict())
    else:
        report.show(fit, verbose=verbose)
        say("\n".join(fit.remarks))
        if verbose:
            report.influence(fit)
    if save and method != "naive":
        sn.save_fit(fit, session)


@command()
@settings("plug", "samples")
def advise(
    session: Path,
    gaits: list[sn.Gait],
    servo: str | None,
    settings: Values,
    verbose: bool,
    as_json: bool,
) -> None:
    """Tell which reading to take next: the one that shrinks the speeds' band most a minute.

    A station, a push, a film or a servo's test, as this session can have them. The band is that of
    `compare`: any hobby servo may move the joints unless --servo says which.
    """
    loaded, _, kind, notes = measured(session, servo, settings)
    how = group_settings(settings, "samples")
    advice = busy(
        "advising", lambda share: sn.advise(loaded, gaits, servo=kind, progress=share, **how)
    )
    print_result(advice, as_json, verbose, notes)


@command()
@settings("plug", "samples", "amplitude")
def compare(
    session: Path,
    gaits: list[sn.Gait],
    servo: str | None,
    figure: Path | None,
    settings: Values,
    verbose: bool,
    as_json: bool,
) -> None:
    """Compare a session's gait runs with the speeds that its friction predicts.

    First whether they agree, with a p-value over all gaits that the servos can follow, and which
    one factor would explain the speeds. Then each gait beside its 95 % band and the implicit
    model's speed. Any hobby servo may move the joints unless --servo says which.
    """
    from ...show import report

    loaded, fit, kind, notes = measured(session, servo, settings)
    how = group_settings(settings, "samples", "amplitude") | {"gaits": gaits, "servo": kind}
    compared = busy("comparing", lambda share: sn.compare(loaded, fit, progress=share, **how))
    if figure is not None:
        compared.plot(figure)
        report.wrote(figure)
    print_result(compared, as_json, verbose, notes)


@command()
@option(
    "--out",
    "page",
    "Page to write, unless report.html in the session's folder.",
    type=OutFile(".html"),
)
@settings("plug")
def report(session: Path, servo: str | None, page: Path | None, settings: Values) -> None:
    """Write a session's report: one self-contained HTML file, the same bytes when made again.

    Its speeds are those of `compare` and `advise`: any hobby servo unless --servo says which.
    """
    from ...base.files import write_text
    from ...prediction.comparison import compared_gaits
    from ...show.session.report_page import session_page

    page = page or session / "report.html"
    loaded, fit, kind, _ = measured(session, servo, settings)
    text = busy(
        "comparing, advising and drawing",
        lambda _: session_page(
            loaded,
            fit,
            sn.compare(loaded, fit, servo=kind) if compared_gaits(loaded) else None,
            sn.advise(loaded, servo=kind) if loaded.setup.plan.gaits else None,
        ),
    )
    write_text(page, text)
    say(f"wrote {page}")
