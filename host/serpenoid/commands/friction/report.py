"""`serpenoid report`: a session's story, figures and numbers in one HTML file."""

from __future__ import annotations

from pathlib import Path

import click

from ...show.screen import say
from ..declare import option
from ..given import session_fit
from ..options import AS_JSON, servo_option, show_json, take_servo
from ..paths import FOLDER, out_file


@click.command()
@click.argument("session", type=FOLDER)
@option("--out", "Where to; report.html in the session's folder.", type=out_file(".html"))
@option("--bibtex", "Write what to cite into this file, too.", type=out_file(".bib"))
@option("--beside", "Another session of this robot, to compare the frictions with.", type=FOLDER)
@servo_option
@AS_JSON
def report(
    session: Path,
    out: Path | None,
    bibtex: Path | None,
    beside: Path | None,
    as_json: bool,
) -> None:
    """Write a session's report: one self-contained HTML file, the same bytes when made again.

    Its speeds are those of `compare` and `advise`: any hobby servo unless --servo says which.
    """
    from ...calibration import advice, comparison
    from ...calibration.session_file import load_session
    from ...calibration.session_rows import events_of
    from ...model.files import write_text
    from ...show.progress import progress
    from ...show.session.report_page import session_page

    out = out or session / "report.html"
    compared = advised = None
    servo = take_servo("hobby")
    loaded = load_session(session)
    fit = session_fit(session)
    if comparison.compared_gaits(loaded):
        with progress(comparison.gait_count(loaded), "gaits") as advance:
            compared = comparison.compare(loaded, fit, servo=servo, progress=advance)
    if loaded.setup.procedure.gaits:
        advised = advice.advise(loaded, servo=servo)
    other = None
    if beside is not None:
        from ...calibration.advising.two_fits import two_sessions

        other = two_sessions(loaded, load_session(beside))
    page = session_page(loaded, fit, compared, advised, events_of(loaded), other)
    write_text(out, page)
    if bibtex is not None:
        from ...show.citation import entries
        from ...show.report import wrote

        write_text(bibtex, entries())
        wrote(bibtex)
    verdict = None if compared is None else compared.verdict
    show_json({"report": str(out), "verdict": verdict}) if as_json else say(f"wrote {out}")
