"""The study of 2005 remade: each figure drawn, and the claims."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import serpenoid as sn

from ... import _core
from ...paper import study
from ...paper.claims import Claim, claims
from ...prediction.predict import SpeedPoint, predict_all
from ...show import plot
from ...show.gaits import gait_figures

HERTZ = 0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0


def draw(out: Path, advance: Callable[[int], None]) -> list[Claim]:
    """Compute the study and draw its figures into a folder; return the claims."""
    closed = study.compare_formulations("zero")
    opened = study.compare_formulations("slow_manifold")
    advance(1)
    cloud, front = study.papers_sweep(), study.papers_front()
    advance(1)
    gait_figures.errors_in_time(closed, opened, out / "fig6-7.png")
    run = study.path_run(study.PATH_GAIT, 3)
    title = "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s"
    plot.path_and_poses(run, title, out / "fig12-13.png")
    _optima(out, cloud, front)
    advance(1)
    points = _experiment(out)
    advance(1)
    _front_of_2005(out)
    advance(1)
    bands = [(p.frequency_hz, p.low_ideal_m_s, p.high_ideal_m_s) for p in points]
    found = claims(closed, opened, front, bands)
    advance(1)
    return found


def _optima(out: Path, cloud: sn.Sweep, front: list[sn.LeastPower]) -> None:
    words = f"the paper's robot: {plot.robot_words(study.ROBOT, study.GROUND)}; net power"
    gait_figures.power_of(cloud, front, words, out / "fig8.png")
    papers = {"beta_deg": 80.0, "alpha_deg": 30.0}
    gait_figures.optimum_figure(front, papers, words, out / "fig9-11.png")


def _experiment(out: Path) -> list[SpeedPoint]:
    """Draw friction and speed of the 2005 robot; return the speeds."""
    folder = Path(_core.__file__).parent / "calibration_data" / "nirakh-2005"
    session = sn.load_session(folder)
    fit = sn.fit_friction(session)
    lost = "readings regenerated from the lines that the paper prints: its own are lost"
    plot.friction_lines(session, fit, out / "fig15-16.png", lost)
    gaits = [sn.Gait.degrees(70, 75, hertz=hertz) for hertz in HERTZ]
    points = predict_all(session.setup.robot, fit, gaits)
    plot.formulations_figure(points, "2005 robot, α = 70°, β = 75°", out / "fig17.png")
    return points


def _front_of_2005(out: Path) -> None:
    """Draw the least power of the 2005 robot against its speed."""
    body, speeds = (study.OF_2005, study.BINGHAM), study.FRONT_2005_M_S
    front = [best for best in sn.power_front(*body, speeds_m_s=speeds) if best]
    words = f"2005 robot: {plot.robot_words(*body)}"
    gait_figures.power_of(study.cloud_2005(), front, words, out / "front-2005.png")
