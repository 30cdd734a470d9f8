"""What the demo shows of a robot of the lab: a treadmill session, pushes along a floor, a film.

Everything is simulated, so that the truth is known.
"""

from __future__ import annotations

import math
import shutil
import textwrap
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import serpenoid as sn

from .. import _core
from ..base.files import read_json, write_text
from ..calibration.friction_result import DOUBTFUL, whole_ground
from ..lab.crawl import crawl_speed
from ..prediction.band import speed_band
from ..prediction.comparison import compared_gaits
from ..prediction.curve import speed_curves
from ..robot.robot import RobotBoard
from ..session.instruments import FloorTools
from ..session.journal import Journal
from ..show.comparison_figure import comparison_figure
from ..show.report import console
from ..show.screen import progress, working
from ..show.session.floor_figure import push_figure
from ..show.session.report_page import session_page
from ..taking.board_run import board_gait
from ..taking.new_session import create_session, default_setup, on_place
from ..taking.simulated import SimulatedPerson
from ..taking.treadmill import take_all
from ..taking.world import Truth, drawn_floor
from .options import write_json

if TYPE_CHECKING:
    from ..session.session import Setup

STEPS, WIDTH, NAME = 8, 96, "demo, simulated"
FRICTIONS = ("ct", "cn", "ft0", "fn0")
SEED, WHEELS_KG, SERVOS = 2005, 0.036, sn.servo("hobby")
TRUTH = Truth(
    sn.Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27),
    incline_zero_rad=math.radians(0.12),
    misreads=0.05,
    servo=SERVOS.draws(1, SEED)[0],
)


def say(text: str) -> None:
    """Print a text as it stands."""
    console.print(text)


def step(number: int, *sentences: str) -> None:
    """Print what a step of the demo gave."""
    head = f"[{number}/{STEPS}] "
    text = " ".join(sentence for sentence in sentences if sentence)
    say(textwrap.fill(head + text, WIDTH, subsequent_indent=" " * len(head)))


def true_frictions(ground: sn.Ground) -> dict[str, float]:
    """Return the true frictions of the whole snake by name."""
    return {name: getattr(ground, name) for name in FRICTIONS}


def beside_truth(fit: sn.FrictionFit, ground: sn.Ground) -> str:
    """Return how many intervals of a fit contain the truth, and the rolling friction for one."""
    truth, rows = true_frictions(ground), fit.rows()
    inside = sum(row.low <= truth[name] <= row.high for name, row in zip(truth, rows, strict=True))
    rolling = rows[FRICTIONS.index("ft0")]
    return (
        f"{inside} of {len(rows)} true frictions lie inside their 95 % intervals; dry friction "
        f"along is {rolling.value:.3g} N ({rolling.low:.3g} to {rolling.high:.3g}, truth "
        f"{truth['ft0']:.3g})."
    )


def run_loop(out: Path, own: sn.FrictionFit | None = None) -> tuple[sn.FrictionFit, sn.Ground]:
    """Take a session, fit, predict, compare, drive the gait for a speed; return fit and truth.

    own: of a robot whose friction is then the truth; that of 2005 unless given. The session is left
    in out/session, to be looked at by every other command.
    """
    truth = (
        TRUTH
        if own is None
        else replace(TRUTH, ground=whole_ground(list(own.whole_snake.values())))
    )
    session = take_session(out / "session", truth, own and own.robot)
    step(
        1,
        f"A session on a simulated treadmill, as `serpenoid calibrate` leads through it: "
        f"{len(session.kept)} readings at rest and {len(session.kept_gait_runs)} gait runs.",
    )
    session, fit, voided = _without_outlier(session, sn.fit_friction(session))
    sn.save_fit(fit, out / "session")
    step(2, f"Its friction: {beside_truth(fit, truth.ground)}", voided)
    compared = _compare(session, fit)
    curves = speed_curves(session, fit, compared, SERVOS)
    comparison_figure(compared, curves, out / "comparison.png")
    with working("looking at each reading that could be next"):
        advised = sn.advise(session)
    step(4, advised.note or f"What to read next: {advised.best.in_words()}.")
    wanted_m_s = float(f"{compared.gaits[1].exact_m_s:.1g}")
    wanted = _drive_wanted(session, fit, wanted_m_s, truth)
    numbers = {
        "fit": fit.to_dict(),
        "truth": true_frictions(truth.ground),
        "comparison": compared.to_dict(),
        "advice": advised.to_dict(),
        "wanted": wanted,
    }
    page = session_page(session, fit, compared, advised, curves)
    write_text(out / "report.html", page)
    write_json(out / "loop.json", numbers)
    return fit, truth.ground


def take_session(folder: Path, truth: Truth = TRUTH, body: sn.Robot | None = None) -> sn.Session:
    """Take the demo's session anew; raises BadInput where another one is in its place."""
    setup = _simulated(default_setup(NAME), "a simulated treadmill", "belt")
    begin_anew(folder, setup if body is None else replace(setup, robot=body))
    with RobotBoard("virtual:fast") as robot, Journal(folder) as journal:
        setup = journal.session.setup
        treadmill = SimulatedPerson(
            setup, truth, SEED, run_gait=lambda gait: board_gait(robot, gait)
        )
        journal.event("start", detail="demo")
        with working("stations, bends and gait runs"):
            session = take_all(journal, treadmill)
        journal.event("end")
        return session


def _simulated(setup: Setup, source: str, surface: str) -> Setup:
    """Return a set-up that says that it is the demo's."""
    return replace(
        setup,
        kind="simulated",
        source=f"{source}, seed {SEED}",
        note="the demo's: no measurement",
        surface=f"simulated {surface}",
    )


def begin_anew(folder: Path, setup: Setup) -> None:
    """Begin a session of the demo's in place of an earlier one; raises BadInput for another's."""
    if (folder / "session.toml").exists():
        if f'name = "{setup.name}"' not in (folder / "session.toml").read_text(encoding="utf-8"):
            raise sn.BadInput(
                f"{folder} holds a session that is not the demo's; give another --out"
            )
        shutil.rmtree(folder)
    create_session(folder, setup)


def _without_outlier(
    session: sn.Session, fit: sn.FrictionFit
) -> tuple[sn.Session, sn.FrictionFit, str]:
    """Void the reading without which chi2 is least, where the readings cannot all be right.

    The third value says so in words.
    """
    if fit.p_value is None or fit.p_value > DOUBTFUL or session.folder is None:
        return session, fit, ""
    worst = min(fit.influence, key=lambda reading: reading.chi2_without).reading
    with Journal(session.folder) as journal:
        journal.event("void", worst, "misread: chi2 says so")
        without = sn.fit_friction(journal.session)
        words = (
            f"chi2 was {fit.chi2:.0f} for {fit.dof} degrees of freedom, and is "
            f"{without.chi2:.0f} without reading {worst}: this misreading is voided."
        )
        return journal.session, without, words


def _compare(session: sn.Session, fit: sn.FrictionFit) -> sn.Comparison:
    with progress(len(compared_gaits(session)), "gaits") as advance:
        compared = sn.compare(session, fit, servo=SERVOS, progress=advance)
    gait = compared.gaits[1]
    step(
        3,
        f"Its speed at {gait.frequency_hz:.2g} Hz: {gait.low_all_m_s:#.2g} to "
        f"{gait.high_all_m_s:#.2g} m/s predicted with any hobby servos, {gait.measured_m_s:#.2g} "
        f"measured; ideal joints {gait.exact_m_s:#.2g}.",
        "Both agree." if compared.verdict == "agrees" else compared.verdict_text,
    )
    return compared


def _drive_wanted(
    session: sn.Session, fit: sn.FrictionFit, speed_m_s: float, truth: Truth
) -> dict[str, float]:
    with working("searching"):
        best = sn.least_power_gait(session.setup.robot, fit.ground, speed_m_s=speed_m_s)
    gait = best.gait
    with RobotBoard("virtual:fast") as robot:
        driven = board_gait(robot, sn.Gait(gait.alpha_rad, gait.beta_rad, gait.omega_rad_s))
    band = speed_band(fit, driven, servo=SERVOS)
    with working("the lab's robot crawls"):
        crawls = crawl_speed(truth.robot(session.setup.robot, np.random.default_rng(SEED)), driven)
    alpha, beta = math.degrees(driven.alpha_rad), math.degrees(driven.beta_rad)
    with_servos = band.too_fast or (
        f"With typical servos about {band.speed_m_s:#.2g} m/s ({band.low_m_s:#.2g} to "
        f"{band.high_m_s:#.2g})."
    )
    frequency_hz = driven.omega_rad_s / (2 * math.pi)
    step(
        5,
        f"The cheapest gait for {speed_m_s:g} m/s with ideal joints: {alpha:.0f}°/{beta:.0f}° at "
        f"{frequency_hz:.2g} Hz, {1000 * best.power_w:.0f} mW. {with_servos} The lab's "
        f"robot crawls at {crawls:#.2g}.",
    )
    return {
        "alpha_deg": alpha,
        "beta_deg": beta,
        "frequency_hz": frequency_hz,
        "power_w": best.power_w,
        "crawls_m_s": crawls,
    } | band.to_dict()


def push_along_floor(out: Path, belt: sn.FrictionFit, ground: sn.Ground) -> dict[str, Any] | None:
    """Take pushes there and back in each bend, fit them, and hold them beside the treadmill's fit.

    ground: the truth. The session is left in out/floor, its picture in out/floor.png. Returns the
    figures; None where a robot of one's own does not roll well enough to tell.
    """
    setup = default_setup("demo, floor")
    plan = replace(on_place(setup.procedure, "floor"), gaits=(), pushes=2)
    setup = replace(
        _simulated(setup, "a floor in the virtual lab", "floor"),
        robot=belt.robot,
        procedure=plan,
        floor=FloorTools(wheels_kg=WHEELS_KG),
    )
    try:
        begin_anew(out / "floor", setup)
        person = SimulatedPerson(
            setup, drawn_floor(setup, ground, np.random.default_rng(SEED)), SEED
        )
        with Journal(out / "floor") as journal, working("pushes"):
            session = take_all(journal, person)
        fit = sn.fit_friction(session)
    except sn.BadInput as error:
        step(6, f"No pushes along a floor for this robot: {error}")
        return None
    sn.save_fit(fit, out / "floor")
    bends = len({push.lambda_rad for push in session.kept_pushes})
    push_figure(session, fit, out / "floor.png")
    step(
        6,
        f"No treadmill? {len(session.kept_pushes)} filmed pushes along a floor in "
        f"{bends} bends, {person.t_s / 60:.0f} minutes: {beside_truth(fit, ground)}",
    )
    return {"fit": fit.to_dict()}


def measure_demo_film(out: Path) -> dict[str, Any] | None:
    """Measure the film that is installed with the package, beside what the lab knows.

    The film is made by studies/demo_film.py: rendering takes longer than the demo may, and needs
    the tests' renderer. Returns None where the extra [video] is missing, and says so.
    """
    from ..video.seeing.extra import need_extra

    folder = Path(_core.__file__).parent / "calibration_data" / "demo-film"
    truth = read_json(folder / "truth.json")
    try:
        need_extra()
    except sn.BadInput as error:
        step(7, f"The film of a crawl is left out: {error}")
        return None
    from ..show.video.film_figure import film_figure
    from ..video.measure_film import measure_film

    gait = sn.Gait(truth["alpha_rad"], truth["beta_rad"], truth["omega_rad_s"])
    with working("watching the film"):
        film = measure_film(folder / "film.mp4", truth["links"], truth["link_length_m"], gait=gait)
    film_figure(film, out / "film.png")
    run = film.run
    errors_deg = [
        math.degrees(joint.amplitude_rad - truth["amplitude_rad"][joint.joint - 1])
        for joint in run.joints
    ]
    step(
        7,
        f"A film of a crawl, measured: {1000 * run.speed_m_s:.1f} ± "
        f"{1000 * run.speed_sigma_m_s:.1f} mm/s (truth {1000 * truth['speed_m_s']:.1f}), the "
        f"amplitude of each joint to {max(map(abs, errors_deg)):.2f}°.",
    )
    return run.to_dict() | {"truth": truth}
