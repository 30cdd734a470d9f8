"""The command `serpenoid figures`: the study of 2005 remade, figure by figure, claim by claim."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ...model.files import write_text
from ...show.screen import say
from ..declare import option
from ..options import AS_JSON, finite, interruptible, show_json
from ..paths import directory

if TYPE_CHECKING:
    from ...calibration.prediction import SpeedPoint
    from ...gaits.finder import LeastPower
    from ...gaits.robust import RobustGait
    from ...paper.claims import Claim
    from ...paper.study import Comparison, Reading
    from ...periodic.sweep import Sweep

Shown = list[tuple[str, str]]  # pictures with their captions
CLIFF_M_S = 0.05  # speed of the two gaits whose cliffs are drawn


@click.command()
@option(
    "--out",
    "Folder for figures, their data and the page.",
    type=directory,
    default=Path("figures-out"),
)
@option("--power", "Mean of P, of |P| or of P+.", choice=["net", "abs", "positive"], default="net")
@option(
    "--angles",
    "What Eq. 57 drives: joints, or links.",
    choice=["joint", "absolute"],
    default="joint",
)
@option(
    "--speed-along",
    "Direction the speed counts in: of travel, or global x.",
    choice=["mean", "x"],
    default="mean",
)
@AS_JSON
def figures(out: Path, power: str, angles: str, speed_along: str, as_json: bool) -> None:
    """Draw the figures of the 2005 paper anew, and set its claims beside what is found.

    Writes Figs. 6 to 13 and 15 to 17, fronts of least-power and robust gaits, the cliff of a
    fragile and a robust gait, the robot crawling (SVG), a data file beside each,
    claims.json and index.html. Some ten seconds. Joints follow the gait exactly, as the paper's
    do, so there is no --servo; the speeds of Fig. 17 have the band of any hobby servo beside them.
    """
    from ...paper.claims import as_dict
    from ...paper.study import Reading
    from ...show.gaits.paper_page import claim_table, write_page
    from ...show.progress import progress

    out.mkdir(parents=True, exist_ok=True)
    reading = Reading(power, angles, speed_along)
    with progress(7, "figures") as advance:
        found, shown = interruptible(lambda: _draw(out, reading, advance))
    values = as_dict(found, reading)
    write_text(out / "claims.json", json.dumps(finite(values), indent=2) + "\n")
    write_page(out / "index.html", found, shown, values["reading"])
    if as_json:
        show_json(values | {"page": str(out / "index.html")})
    else:
        claim_table(found)
        say(f"wrote {out / 'index.html'} and {len(shown)} figures with their data")


def _draw(out: Path, reading: Reading, advance: Callable[[int], None]) -> tuple[list[Claim], Shown]:
    """Compute and draw; return the claims, and the pictures with their captions."""
    from ...paper import study
    from ...paper.claims import claims as set_beside

    closed = study.compare_formulations("zero")
    opened = study.compare_formulations("slow_manifold")
    advance(1)
    cloud, front = study.papers_sweep(powers=reading.power != "net"), study.papers_front(reading)
    advance(1)
    shown = [*_crawling(out), *_of_time(out, closed, opened)]
    shown += _of_optima(out, cloud, front, reading)
    advance(1)
    points, drawn = _of_experiment(out)
    shown += drawn
    advance(1)
    robust, drawn = _of_robustness(out, study.COSTS[reading.power])
    shown += drawn
    advance(1)
    shown += _of_cliffs(out, robust)
    advance(1)
    bands = [(p.frequency_hz, p.low_ideal_m_s, p.high_ideal_m_s) for p in points]
    claims = set_beside(closed, opened, front, reading, bands)
    advance(1)
    return claims, shown


def _crawling(out: Path) -> Shown:
    from ...paper import study
    from ...show.gaits import crawl

    found = crawl.crawl(study.OF_2005, study.BINGHAM, study.EXPERIMENT)
    crawl.write_svg(found, out / "crawl.svg")
    crawl.write_data(found, out / "crawl.svg")
    return [("crawl.svg", "The 2005 robot crawling, with slip and forces")]


def _of_time(out: Path, closed: Comparison, opened: Comparison) -> Shown:
    from ...paper import study
    from ...show import plot
    from ...show.gaits.paper_figures import errors_in_time, path_data

    errors_in_time(closed, opened, out / "fig6-7.png")
    run = study.path_run(study.PATH_GAIT, 3)
    title = "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s"
    plot.path_and_poses(run, title, out / "fig12-13.png")
    path_data(run, out / "fig12-13.png")
    return [
        ("fig6-7.png", "Figs. 6 and 7: implicit less exact model, tail of three links"),
        ("fig12-13.png", "Figs. 12 and 13: path and six poses of the periodic state"),
    ]


def _of_optima(out: Path, cloud: Sweep, front: list[LeastPower], reading: Reading) -> Shown:
    from ...paper import study
    from ...show.gaits import gait_figures
    from ...show.gaits.paper_figures import power_of
    from ...show.plot import robot_words

    cost = study.COSTS[reading.power]
    robust = study.robust_front(study.ROBOT, study.GROUND, study.ROBUST_M_S, cost, samples=256)
    along = [1.0 if reading.speed_along == "mean" else study.along_x(b.gait) for b in front]
    words = f"the paper's robot: {robot_words(study.ROBOT, study.GROUND)}; {reading.power} power"
    amplitudes = [study.shown_amplitude_deg(b.gait, reading) for b in front]
    power_of(cloud, front, robust, along, cost, words, out / "fig8.png")
    gait_figures.optimum_figure(
        front, {"beta_deg": 80, "alpha_deg": 30}, words, out / "fig9-11.png", amplitudes, along
    )
    gait_figures.shape_maps(cloud, 4, f"{words}; ω = 5 rad/s", out / "shapes.png")
    return [
        ("fig8.png", "Fig. 8: power against speed, the least, and the robust gaits'"),
        ("fig9-11.png", "Figs. 9 to 11: the optimum's rate, lag and amplitude"),
        ("shapes.png", "Speed and cost of transport over the shapes"),
    ]


def _of_experiment(out: Path) -> tuple[list[SpeedPoint], Shown]:
    """Draw friction and speed of the 2005 robot; return the speeds, too."""
    from ...calibration.friction_fit import fit_friction
    from ...calibration.prediction import predict_all
    from ...calibration.session_file import load_session
    from ...model.gait import Gait
    from ...show import plot
    from ...show.gaits.paper_figures import friction_data, speed_data
    from ..demo import ALPHA_DEG, BETA_DEG, session_folder

    session = load_session(session_folder())
    fit = fit_friction(session)
    plot.friction_lines(
        session,
        fit,
        out / "fig15-16.png",
        "readings regenerated from the lines that the paper prints: its own are lost",
    )
    friction_data(session, fit, out / "fig15-16.png")
    gaits = [
        Gait(math.radians(ALPHA_DEG), math.radians(BETA_DEG), 2 * math.pi * f)
        for f in (0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0)
    ]
    points = predict_all(session.setup.robot, fit, gaits)
    plot.speed_against_frequency(
        points, f"2005 robot, α = {ALPHA_DEG:g}°, β = {BETA_DEG:g}°", out / "fig17.png"
    )
    speed_data(points, out / "fig17.png")
    return points, [
        ("fig15-16.png", "Figs. 15 and 16: friction along and across the links"),
        ("fig17.png", "Fig. 17: speed against frequency of the 2005 robot"),
    ]


def _of_robustness(out: Path, cost: str) -> tuple[RobustGait, Shown]:
    """Draw both fronts of the 2005 robot; return the robust gait for CLIFF_M_S, too."""
    from ...gaits.least_power import power_front
    from ...paper import study
    from ...show.gaits.paper_figures import power_of
    from ...show.plot import robot_words

    speeds = study.FRONT_2005_M_S
    found = power_front(study.OF_2005, study.BINGHAM, speeds_m_s=speeds, cost=cost)
    front = [best for best in found if best is not None]
    robust = study.robust_front(study.OF_2005, study.BINGHAM, speeds, cost, samples=256)
    words = f"2005 robot: {robot_words(study.OF_2005, study.BINGHAM)}"
    cloud = study.cloud_2005(powers=cost != "power")
    power_of(cloud, front, robust, [1.0] * len(front), cost, words, out / "front-2005.png")
    caption = "The 2005 robot on dry ground: least power, and what robust costs"
    return robust[speeds.index(CLIFF_M_S)], [("front-2005.png", caption)]


def _of_cliffs(out: Path, robust: RobustGait) -> Shown:
    from ...gaits.uncertainty import Uncertainty
    from ...paper import study
    from ...show.gaits.gait_figures import cliff_figure

    for name, gait in (("fragile", robust.fragile.gait), ("robust", robust.gait)):
        cliff_figure(study.OF_2005, study.BINGHAM, gait, Uncertainty(), out / f"cliff-{name}.png")
    wanted = f"{CLIFF_M_S:g} m/s"
    return [
        ("cliff-fragile.png", f"The cliff: the least-power gait for {wanted} stands beside it"),
        (
            "cliff-robust.png",
            f"The robust gait for {wanted}, {100 * robust.premium:.0f} % dearer: "
            "95 % of the robots that may be real keep nine tenths of the speed",
        ),
    ]
