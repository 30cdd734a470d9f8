"""The command `serpenoid figures`: the study of 2005 remade, figure by figure, claim by claim."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import serpenoid as sn

from ...show.screen import say
from ..declare import command, directory, option
from ..options import AS_JSON, busy, show_json

if TYPE_CHECKING:
    from ...paper.claims import Claim

SPRINGS_RTOL = 1e-3  # of the implicit model's speed
HERTZ = 0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0


@command()
@option("--out", "Folder for figures and claims.", type=directory, default=Path("figures-out"))
@AS_JSON
def figures(out: Path, as_json: bool) -> None:
    """Draw the figures of the 2005 paper anew, and set its claims beside what is found.

    Writes Figs. 6 to 13 and 15 to 17, the front of least power of the 2005 robot, and claims.json.
    Some twenty seconds. Joints follow the gait exactly, as the paper's do, so there is no --servo.
    Fig. 17 shows the speeds of both models; its claims are compared with the band that the
    readings leave.
    """
    from ...paper.claims import as_dict
    from ...show.report import table

    found = busy("drawing figures", lambda _: draw(out))
    values = as_dict(found)
    show_json(values, out / "claims.json")
    if as_json:
        return show_json(values)
    cells = [[c.where, c.paper, c.here, c.verdict] for c in found]
    table("the paper's claims", ["where", "the paper", "here", "verdict"], cells, 4)
    return say(f"wrote {out / 'claims.json'} and the figures")


def draw(out: Path) -> list[Claim]:
    """Compute the study and draw its figures into a folder; return the claims."""
    import numpy as np

    from ... import _core
    from ...base.long_calls import in_threads
    from ...paper import study
    from ...paper.claims import claims
    from ...prediction.band import speed_band
    from ...show import plot
    from ...show.gaits import gait_figures

    closed = study.compare_formulations("zero")
    opened = study.compare_formulations("slow_manifold")
    gait_figures.errors_in_time(closed, opened, out / "fig6-7.png")
    front = study.papers_front()
    words = f"the paper's robot: {plot.robot_words(study.ROBOT, study.GROUND)}; net power"
    gait_figures.power_of(study.papers_sweep(), front, words, out / "fig8.png")
    papers = {"beta_deg": 80.0, "alpha_deg": 30.0}
    gait_figures.optimum_figure(front, papers, words, out / "fig9-11.png")
    run = study.path_run(study.PATH_GAIT, 3)
    title = "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s"
    plot.path_and_poses(run, title, out / "fig12-13.png")
    session = sn.load_session(Path(_core.__file__).parent / "calibration_data" / "nirakh-2005")
    fit = sn.fit_friction(session)
    lost = "readings regenerated from the lines that the paper prints: its own are lost"
    fit.plot(out / "fig15-16.png", session=session, note=lost)
    gaits = [sn.Gait.degrees(70, 75, hertz=hertz) for hertz in HERTZ]
    bands = in_threads(lambda gait: speed_band(fit, gait, servo=None), gaits)
    exact = np.array([band.speed_m_s for band in bands])
    on_springs = partial(sn.steady_springs, fit.robot, fit.ground, rtol=SPRINGS_RTOL)
    implicit = in_threads(on_springs, gaits)
    speeds = np.array([springs.speed_m_s for springs in implicit])
    title = "2005 robot, α = 70°, β = 75°"
    plot.formulations_figure(np.array(HERTZ), exact, speeds, title, out / "fig17.png")
    body = study.OF_2005, study.BINGHAM
    optima = [best for best in sn.power_front(*body, speeds_m_s=study.FRONT_2005_M_S) if best]
    words = f"2005 robot: {plot.robot_words(*body)}"
    gait_figures.power_of(study.cloud_2005(), optima, words, out / "front-2005.png")
    ends = [(hz, b.low_m_s, b.high_m_s) for hz, b in zip(HERTZ, bands, strict=True)]
    return claims(closed, opened, front, ends)
