"""The study of 2005 remade: each figure drawn with its data beside, and the claims."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import serpenoid as sn

from ...paper import study
from ...paper.claims import Claim, claims
from ...prediction.predict import SpeedPoint, predict_all
from ...show import plot
from ...show.gaits import crawl, gait_figures
from ..demo import ALPHA_DEG, BETA_DEG, session_folder

HERTZ = 0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0
CAPTIONS = {
    "crawl.svg": "The 2005 robot crawling, with slip and forces",
    "fig6-7.png": "Figs. 6 and 7: implicit less exact model, tail of three links",
    "fig12-13.png": "Figs. 12 and 13: path and six poses of the periodic state",
    "fig8.png": "Fig. 8: power against speed, and the least",
    "fig9-11.png": "Figs. 9 to 11: the optimum's rate, lag and amplitude",
    "shapes.png": "Speed and cost of transport over the shapes",
    "fig15-16.png": "Figs. 15 and 16: friction along and across the links",
    "fig17.png": "Fig. 17: speed against frequency of the 2005 robot",
    "front-2005.png": "The 2005 robot on dry ground: least power",
}


def draw(
    out: Path, reading: study.Reading, advance: Callable[[int], None]
) -> tuple[list[Claim], list[tuple[str, str]]]:
    """Compute and draw into a folder; return the claims, and the pictures with their captions."""
    closed = study.compare_formulations("zero")
    opened = study.compare_formulations("slow_manifold")
    advance(1)
    cloud, front = study.papers_sweep(powers=reading.power != "net"), study.papers_front(reading)
    advance(1)
    cycle = crawl.crawl(study.OF_2005, study.BINGHAM, study.EXPERIMENT)
    crawl.write_svg(cycle, out / "crawl.svg")
    crawl.write_data(cycle, out / "crawl.svg")
    gait_figures.errors_in_time(closed, opened, out / "fig6-7.png")
    run = study.path_run(study.PATH_GAIT, 3)
    title = "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s"
    plot.path_and_poses(run, title, out / "fig12-13.png")
    gait_figures.path_data(run, out / "fig12-13.png")
    _optima(out, cloud, front, reading)
    advance(1)
    points = _experiment(out)
    advance(1)
    _front_of_2005(out, study.COSTS[reading.power])
    advance(1)
    bands = [(p.frequency_hz, p.low_ideal_m_s, p.high_ideal_m_s) for p in points]
    beside = claims(closed, opened, front, reading, bands)
    advance(1)
    return beside, list(CAPTIONS.items())


def _optima(out: Path, cloud: sn.Sweep, front: list[sn.LeastPower], reading: study.Reading) -> None:
    cost = study.COSTS[reading.power]
    along = [1.0 if reading.speed_along == "mean" else study.along_x(b.gait) for b in front]
    robot = plot.robot_words(study.ROBOT, study.GROUND)
    words = f"the paper's robot: {robot}; {reading.power} power"
    amplitudes = [study.shown_amplitude_deg(b.gait, reading) for b in front]
    gait_figures.power_of(cloud, front, along, cost, words, out / "fig8.png")
    papers = {"beta_deg": 80.0, "alpha_deg": 30.0}
    gait_figures.optimum_figure(front, papers, words, out / "fig9-11.png", amplitudes, along)
    gait_figures.shape_maps(cloud, 4, f"{words}; ω = 5 rad/s", out / "shapes.png")


def _experiment(out: Path) -> list[SpeedPoint]:
    """Draw friction and speed of the 2005 robot; return the speeds."""
    session = sn.load_session(session_folder())
    fit = sn.fit_friction(session)
    lost = "readings regenerated from the lines that the paper prints: its own are lost"
    plot.friction_lines(session, fit, out / "fig15-16.png", lost)
    shape = math.radians(ALPHA_DEG), math.radians(BETA_DEG)
    gaits = [sn.Gait(*shape, math.tau * hertz) for hertz in HERTZ]
    points = predict_all(session.setup.robot, fit, gaits)
    title = f"2005 robot, α = {ALPHA_DEG:g}°, β = {BETA_DEG:g}°"
    plot.speed_against_frequency(points, title, out / "fig17.png")
    gait_figures.speed_data(points, out / "fig17.png")
    return points


def _front_of_2005(out: Path, cost: str) -> None:
    """Draw the least power of the 2005 robot against its speed."""
    body, speeds = (study.OF_2005, study.BINGHAM), study.FRONT_2005_M_S
    front = [best for best in sn.power_front(*body, speeds_m_s=speeds, cost=cost) if best]
    words = f"2005 robot: {plot.robot_words(*body)}"
    cloud = study.cloud_2005(powers=cost != "power")
    path, along = out / "front-2005.png", [1.0] * len(front)
    gait_figures.power_of(cloud, front, along, cost, words, path)
