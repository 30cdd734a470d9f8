"""The commands `bench`, which measures the methods, and `figures`, which repeats the 2005 study."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import serpenoid as sn

from ..show.screen import say
from .declare import command, directory, flag, option
from .options import busy, show_json

if TYPE_CHECKING:
    from ..paper.study import Claim


@command()
@option(
    "--out", "folder", "Folder for figures and numbers.", type=directory, default=Path("bench-out")
)
@flag("--quick", "Three scenes and a coarse map: 15 seconds in place of three minutes.")
def bench(folder: Path, quick: bool) -> None:
    """Compare every method with SciPy: error against run time, stability, and cost of each term.

    The exit status is 1 if a run hangs, gives a NaN or is wrong without a warning.
    """
    from ..base.files import write_csv
    from ..bench import extremes, scenes, stability_map, work_precision
    from ..bench.work_precision_figure import work_precision_figure

    warnings.simplefilter("ignore")  # Extreme scenes are extreme on purpose.

    def save(name: str, measured: Iterable[Any]) -> list[Any]:
        """Write a table of results, and return its rows."""
        rows = list(measured)
        header = [field.name for field in dataclasses.fields(rows[0])]
        write_csv(folder / name, header, [list(dataclasses.astuple(row)) for row in rows])
        return rows

    tell = partial(say, err=True)
    tell("what each term of a scene costs ...")
    save("costs.csv", scenes.measure(quick))
    rows = save("accuracy.csv", work_precision.measure(quick, tell))
    work_precision_figure(rows, folder / "accuracy.png")
    cells = save("stability.csv", stability_map.measure(quick, tell))
    stability_map.stability_figure(cells, folder / "stability.png")
    outcomes = save("extremes.csv", extremes.measure(quick, tell))
    words = [row.outcome for row in outcomes]
    words += ["HANG" if cell.note else cell.kind for cell in cells]
    say(f"Milliseconds a simulated second at an error of 1e-6:\n\n{work_precision.table(rows)}\n")
    defects = {word: words.count(word) for word in extremes.DEFECTS}
    counts = ", ".join(f"{count} {word}" for word, count in defects.items())
    say(f"Defects, extreme scenes included: {counts}\nFigures and numbers are in {folder}")
    if any(defects.values()):
        raise SystemExit(1)


@command()
@option(
    "--out", "folder", "Folder for figures and claims.", type=directory, default=Path("figures-out")
)
def figures(folder: Path) -> None:
    """Draw the figures of the 2005 paper anew, and compare its claims with today's results.

    Writes Figs. 6 to 13 and 15 to 17, the gaits of least power of the 2005 robot, and claims.json,
    in some twenty seconds. Joints follow the gait exactly, as the paper's do, so there is no
    --servo. Fig. 17 shows the speeds of both models; its claims are compared with the 95 % band
    from the uncertainty of friction.
    """
    from ..show.report import table

    results = busy("drawing figures", lambda _: draw(folder))
    show_json({"claims": [claim._asdict() for claim in results]}, folder / "claims.json")
    table("the paper's claims", ["where", "the paper", "here", "verdict"], results, 4)
    say(f"wrote {folder / 'claims.json'} and the figures")


def draw(folder: Path) -> list[Claim]:
    """Compute the study and draw its figures into a folder; return the claims."""
    import numpy as np

    from .. import _core
    from ..base.long_calls import in_threads
    from ..paper import study
    from ..prediction.speeds import speed_band
    from ..show import plot, run_figure
    from ..show.gaits import gait_figures

    zero_gap = study.compare_formulations("zero")
    slow_manifold = study.compare_formulations("slow_manifold")
    gait_figures.errors_in_time(zero_gap, slow_manifold, folder / "fig6-7.png")
    front = study.optima(study.ROBOT, study.GROUND, 0.7)
    words = f"the paper's robot: {run_figure.robot_words(study.ROBOT, study.GROUND)}; net power"
    gait_figures.power_of(study.papers_sweep(), front, words, folder / "fig8.png")
    gait_figures.optimum_figure(front, words, folder / "fig9-11.png")
    run = study.path_run(study.PATH_GAIT, 3)
    title = "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s"
    run_figure.path_and_poses(run, title, folder / "fig12-13.png")
    session = sn.load_session(Path(_core.__file__).parent / "calibration_data" / "nirakh-2005")
    fit = sn.fit_friction(session)
    note = "readings regenerated from the lines that the paper prints: its own are lost"
    fit.plot(folder / "fig15-16.png", session=session, note=note)
    frequencies_hz = 0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0
    gaits = [sn.Gait.degrees(70, 75, hertz=hertz) for hertz in frequencies_hz]
    bands = in_threads(lambda gait: speed_band(fit, gait, servo=None), gaits)
    exact_m_s = np.array([band.speed_m_s for band in bands])
    implicit = partial(sn.steady_springs, fit.robot, fit.ground, rtol=1e-3)
    implicit_m_s = np.array([state.speed_m_s for state in in_threads(implicit, gaits)])
    title = "2005 robot, α = 70°, β = 75°"
    frequencies_hz = np.array(frequencies_hz)
    plot.formulations_figure(frequencies_hz, exact_m_s, implicit_m_s, title, folder / "fig17.png")
    words = f"2005 robot: {run_figure.robot_words(study.OF_2005, study.BINGHAM)}"
    optima = study.optima(study.OF_2005, study.BINGHAM, 0.2)
    gait_figures.power_of(study.cloud_2005(), optima, words, folder / "front-2005.png")
    ends = [(band.frequency_hz, band.low_m_s, band.high_m_s) for band in bands]
    return study.claims(zero_gap, slow_manifold, front, ends)
