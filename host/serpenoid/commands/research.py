"""The commands for researchers: bench, and figures, the study of 2005 remade."""

from __future__ import annotations

import dataclasses
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
@flag("--quick", "Three scenes and a coarse map, in a quarter of a minute; else four minutes.")
def bench(folder: Path, quick: bool) -> None:
    """Measure every method beside SciPy: error against run time, stability, and costs.

    Exit status 1 where a run hangs, has a NaN or is silently wrong.
    """
    from ..base.files import write_csv
    from ..bench import extremes, scenes, stability_map, work_precision
    from ..bench.work_precision_figure import work_precision_figure

    def saved(name: str, measured: Iterable[Any]) -> list[Any]:
        rows = list(measured)
        header = [field.name for field in dataclasses.fields(rows[0])]
        write_csv(folder / name, header, [list(dataclasses.astuple(row)) for row in rows])
        return rows

    tell = partial(say, err=True)
    tell("what each term of a scene costs ...")
    saved("costs.csv", scenes.measure(quick))
    rows = saved("accuracy.csv", work_precision.measure(quick, tell))
    work_precision_figure(rows, folder / "accuracy.png")
    cells = saved("stability.csv", stability_map.measure(quick, tell))
    stability_map.stability_figure(cells, folder / "stability.png")
    words = [outcome.outcome for outcome in saved("extremes.csv", extremes.measure(quick, tell))]
    words += ["HANG" if cell.note else cell.kind for cell in cells]
    say(f"Milliseconds a simulated second at an error of 1e-6:\n\n{work_precision.table(rows)}\n")
    defects = {word: words.count(word) for word in extremes.DEFECTS}
    counts = ", ".join(f"{count} {word}" for word, count in defects.items())
    say(f"Defects, extreme scenes included: {counts}\nFigures and numbers are in {folder}")
    if any(defects.values()):
        raise SystemExit(1)


SPRINGS_RTOL = 1e-3  # accuracy of the implicit model's speed
HERTZ = 0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0


@command()
@option(
    "--out", "folder", "Folder for figures and claims.", type=directory, default=Path("figures-out")
)
def figures(folder: Path) -> None:
    """Draw the figures of the 2005 paper anew, and set its claims beside what is found.

    Writes Figs. 6 to 13 and 15 to 17, the front of least power of the 2005 robot, and claims.json.
    Some twenty seconds. Joints follow the gait exactly, as the paper's do, so there is no --servo.
    Fig. 17 shows the speeds of both models; its claims are compared with the band that the
    readings leave.
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
    from ..prediction.band import speed_band
    from ..show import plot
    from ..show.gaits import gait_figures

    closed = study.compare_formulations("zero")
    opened = study.compare_formulations("slow_manifold")
    gait_figures.errors_in_time(closed, opened, folder / "fig6-7.png")
    front = study.papers_front()
    words = f"the paper's robot: {plot.robot_words(study.ROBOT, study.GROUND)}; net power"
    gait_figures.power_of(study.papers_sweep(), front, words, folder / "fig8.png")
    gait_figures.optimum_figure(front, words, folder / "fig9-11.png")
    run = study.path_run(study.PATH_GAIT, 3)
    title = "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s"
    plot.path_and_poses(run, title, folder / "fig12-13.png")
    session = sn.load_session(Path(_core.__file__).parent / "calibration_data" / "nirakh-2005")
    fit = sn.fit_friction(session)
    lost = "readings regenerated from the lines that the paper prints: its own are lost"
    fit.plot(folder / "fig15-16.png", session=session, note=lost)
    gaits = [sn.Gait.degrees(70, 75, hertz=hertz) for hertz in HERTZ]
    bands = in_threads(lambda gait: speed_band(fit, gait, servo=None), gaits)
    exact = np.array([band.speed_m_s for band in bands])
    on_springs = partial(sn.steady_springs, fit.robot, fit.ground, rtol=SPRINGS_RTOL)
    implicit = in_threads(on_springs, gaits)
    speeds = np.array([springs.speed_m_s for springs in implicit])
    title = "2005 robot, α = 70°, β = 75°"
    plot.formulations_figure(np.array(HERTZ), exact, speeds, title, folder / "fig17.png")
    words = f"2005 robot: {plot.robot_words(study.OF_2005, study.BINGHAM)}"
    cloud, optima = study.cloud_2005(), study.front_2005()
    gait_figures.power_of(cloud, optima, words, folder / "front-2005.png")
    ends = [(hz, b.low_m_s, b.high_m_s) for hz, b in zip(HERTZ, bands, strict=True)]
    return study.claims(closed, opened, front, ends)
