"""The whole loop without a robot, in five steps: each tells what it found beside the truth.

A robot of the virtual lab is measured: a treadmill session, pushes along a floor, a filmed crawl.
"""

from __future__ import annotations

import math
import shutil
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np

import serpenoid as sn

from .. import _core
from ..base.files import read_json, write_text
from ..lab.crawl import crawl_speed
from ..model.gait import gait_name
from ..prediction.speeds import speed_band
from ..session.journal import Journal
from ..session.settings import Provenance, Setup
from ..show.report import console
from ..show.screen import say, working
from ..show.session.report_page import session_page
from ..taking.new_session import create_session, default_setup, on_place
from ..taking.simulated import SimulatedPerson, Truth, take_all, wheel_inertia_kg

STEPS, WIDTH = 5, 96
SEED, WHEELS_KG, SERVOS = 2005, 0.036, sn.servo("hobby")
FLOOR_SLOPE_DEG = 0.2  # slope of the demo's floor, as of many a level one
FRICTIONS = {"ct": 0.084, "cn": 1.2, "ft0": 0.14, "fn0": 0.27}  # the whole 2005 robot's
TRUTH = Truth(
    sn.Ground(**FRICTIONS),
    incline_zero_rad=math.radians(0.12),
    servo=SERVOS.draws(1, SEED)[0],
)


def run_demo(folder: Path) -> None:
    """Measure, fit, predict, compare and find a gait; all of it is written into the folder."""
    session = take_session(folder / "session")
    _step(
        1,
        f"A session of a simulated robot on a treadmill: {len(session.kept_stations)} readings at "
        f"rest and {len(session.kept_gait_runs)} gait runs, as `serpenoid calibrate` asks for.",
    )
    fit = sn.fit_friction(session)
    sn.save_fit(fit, folder / "session")
    _step(2, f"Its friction: {_beside_truth(fit)}")

    with working("comparing") as show_share:
        compared = sn.compare(session, fit, servo=SERVOS, progress=show_share)
    compared.plot(folder / "comparison.png")
    gait = compared.gaits[1]
    _step(
        3,
        f"Its speed at {gait.frequency_hz:.2g} Hz: {gait.low_m_s:#.2g} to "
        f"{gait.high_m_s:#.2g} m/s predicted with hobby servos, {gait.measured_m_s:#.2g} run.",
        "Both agree." if compared.verdict == "agrees" else compared.verdict_text,
    )
    floor = push_along_floor(folder)
    film = measure_film_of_demo(folder)
    _step(4, f"Without a treadmill, pushed along a floor: {_beside_truth(floor)}", film)
    _drive_cheapest(fit, float(f"{gait.exact_m_s:.1g}"))

    with working("looking at each reading that could be next"):
        advised = sn.advise(session)
    write_text(folder / "report.html", session_page(session, fit, compared, advised))
    say(f"Look at {folder / 'report.html'}")


def _step(number: int, *sentences: str) -> None:
    """Print what a step of the demo gave."""
    head = f"[{number}/{STEPS}] "
    text = head + " ".join(sentences)
    console.print(textwrap.fill(text, WIDTH, subsequent_indent=" " * len(head)))


def _beside_truth(fit: sn.FrictionFit) -> str:
    """Return how many intervals of a fit contain the truth, and the rolling friction for one."""
    rows = dict(zip(FRICTIONS, fit.rows(), strict=True))
    inside = sum(row.low <= FRICTIONS[name] <= row.high for name, row in rows.items())
    rolling = rows["ft0"]
    return (
        f"{inside} of {len(rows)} true values lie in their 95 % intervals; dry friction along is "
        f"{rolling.value:.3g} N ({rolling.low:.3g} to {rolling.high:.3g}, truth "
        f"{FRICTIONS['ft0']:.3g})."
    )


def take(folder: Path, setup: Setup, world: Truth) -> sn.Session:
    """Take a session of the demo's in place of an earlier one; raises BadInput for another's."""
    file = folder / "session.toml"
    if file.exists():
        if f'name = "{setup.name}"' not in file.read_text(encoding="utf-8"):
            raise sn.BadInput(
                f"{folder} holds a session that is not the demo's; give another --out"
            )
        shutil.rmtree(folder)
    source, note = f"the virtual lab, seed {SEED}", "the demo's: no measurement"
    provenance = Provenance(kind="simulated", source=source, note=note)
    create_session(folder, replace(setup, provenance=provenance))
    with Journal(folder) as journal, working("measuring"):
        return take_all(journal, SimulatedPerson(journal.session.setup, world, SEED))


def take_session(folder: Path) -> sn.Session:
    """Take the session on a treadmill."""
    return take(folder, default_setup("demo, simulated"), TRUTH)


def push_along_floor(folder: Path) -> sn.FrictionFit:
    """Take pushes there and back in each bend into the folder, fit and draw them."""
    setup = default_setup("demo, floor")
    plan = replace(on_place(setup.plan, "floor"), gaits=(), pushes=2)
    body = replace(setup.robot_table, wheels_kg=WHEELS_KG)
    setup = replace(setup, robot_table=body, plan=plan)
    slope_rad = math.radians(FLOOR_SLOPE_DEG)
    world = Truth(TRUTH.ground, slope_rad=slope_rad, rolling_kg=wheel_inertia_kg(setup))
    session = take(folder / "floor", setup, world)
    fit = sn.fit_friction(session)
    sn.save_fit(fit, folder / "floor")
    fit.plot(folder / "floor.png", session=session)
    return fit


def measure_film_of_demo(folder: Path) -> str:
    """Measure the rendered film that is installed with the package (studies/demo_film.py)."""
    from ..video.seeing.extra import need_extra

    data = Path(_core.__file__).parent / "calibration_data" / "demo-film"
    truth = read_json(data / "truth.json")
    try:
        need_extra()
    except sn.BadInput as error:
        return f"The film of a crawl is left out: {error}"
    from ..show.video.film_figure import film_figure
    from ..video.measure_film import measure_film

    gait = sn.Gait(truth["alpha_rad"], truth["beta_rad"], truth["omega_rad_s"])
    with working("watching the film"):
        film = measure_film(data / "film.mp4", truth["links"], truth["link_length_m"], gait=gait)
    film_figure(film, folder / "film.png")
    run = film.run
    return (
        f"On a film it crawls at {1000 * run.speed_m_s:.1f} ± {1000 * run.speed_sigma_m_s:.1f} "
        f"mm/s (truth {1000 * truth['speed_m_s']:.1f})."
    )


def _drive_cheapest(fit: sn.FrictionFit, speed_m_s: float) -> None:
    """Find the cheapest gait for a speed, run it in the lab, and tell both speeds."""
    with working("searching"):
        best = sn.least_power_gait(fit.robot, fit.ground, speed_m_s=speed_m_s)
    band = speed_band(fit, best.gait, servo=SERVOS)
    with working("the lab's robot crawls"):
        crawls = crawl_speed(TRUTH.robot(fit.robot, np.random.default_rng(SEED)), best.gait)
    _step(
        5,
        f"The cheapest gait for {speed_m_s:g} m/s with ideal joints: {gait_name(best.gait)}, "
        f"{1000 * best.power_w:.0f} mW. Predicted: {band.in_words()}; the lab's robot crawls at "
        f"{crawls:#.2g}.",
    )
