"""The demo's first part: the whole loop without hardware, on a treadmill whose truth is known."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...calibration.advice import advise
from ...calibration.advising.next_reading import Advice
from ...calibration.comparison import Comparison, compare, gait_count
from ...calibration.fit_file import save_fit
from ...calibration.friction_fit import fit_friction
from ...calibration.friction_result import DOUBTFUL, whole_ground
from ...calibration.session_rows import events_of
from ...calibration.speed_samples import speed_band
from ...calibration.taking.board_run import board_gait
from ...calibration.taking.journal import Journal
from ...calibration.taking.new_session import create_session, default_setup
from ...calibration.taking.simulated import SimulatedPerson
from ...calibration.taking.treadmill import take_all
from ...calibration.taking.world import Truth
from ...gaits.least_power import least_power_gait
from ...lab.crawl import crawl_speed
from ...model.errors import BadInput
from ...model.files import write_text
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot as Body
from ...robot.robot import RobotBoard
from ...servos.catalogue import servo
from ...show.comparison_figure import comparison_figure
from ...show.progress import progress, working
from ...show.session.report_page import session_page
from ..options import finite
from .words import beside_truth, step, true_frictions

if TYPE_CHECKING:
    from ...calibration.friction_result import FrictionFit
    from ...calibration.session import Session, Setup

NAME = "demo, simulated"
SEED, SERVOS = 2005, servo("hobby")
TRUTH = Truth(
    Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27),
    incline_zero_rad=math.radians(0.12),
    misreads=0.05,
    servo=SERVOS.draws(1, SEED)[0],
)


def run_loop(out: Path, own: FrictionFit | None = None) -> tuple[FrictionFit, Ground]:
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
    session, fit, voided = _without_outlier(session, fit_friction(session))
    save_fit(fit, out / "session")
    step(2, f"Its friction: {beside_truth(fit, truth.ground)}", voided)
    compared = _compare(session, fit, out / "comparison.png")
    advised = _advise(session)
    wanted_m_s = float(f"{compared.gaits[1].exact_m_s:.1g}")
    wanted = _drive_wanted(session, fit, wanted_m_s, truth)
    numbers = {
        "fit": fit.to_dict(),
        "truth": true_frictions(truth.ground),
        "comparison": compared.to_dict(),
        "advice": advised.to_dict(),
        "wanted": wanted,
    }
    page = session_page(session, fit, compared, advised, events_of(session))
    write_text(out / "report.html", page)
    write_text(out / "loop.json", json.dumps(finite(numbers), indent=2, allow_nan=False) + "\n")
    return fit, truth.ground


def take_session(folder: Path, truth: Truth = TRUTH, body: Body | None = None) -> Session:
    """Take the demo's session anew; raises BadInput where another one is in its place."""
    setup = replace(
        default_setup(NAME),
        kind="simulated",
        source="a simulated treadmill, seed 2005",
        note="the demo's: no measurement",
        surface="simulated belt",
    )
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


def begin_anew(folder: Path, setup: Setup) -> None:
    """Begin a session of the demo's in place of an earlier one; raises BadInput for another's."""
    if (folder / "session.toml").exists():
        if f'name = "{setup.name}"' not in (folder / "session.toml").read_text(encoding="utf-8"):
            raise BadInput(f"{folder} holds a session that is not the demo's; give another --out")
        shutil.rmtree(folder)
    create_session(folder, setup)


def _without_outlier(session: Session, fit: FrictionFit) -> tuple[Session, FrictionFit, str]:
    """Void the reading without which chi2 is least, where the readings cannot all be right.

    The third value says so in words.
    """
    if fit.p_value is None or fit.p_value > DOUBTFUL or session.folder is None:
        return session, fit, ""
    fits = {}
    for reading in session.kept:
        others = tuple(replace(r, voided=r.voided or r is reading) for r in session.readings)
        fits[reading.number] = fit_friction(replace(session, readings=others))
    worst = min(fits, key=lambda number: fits[number].chi2)
    words = (
        f"chi2 was {fit.chi2:.0f} for {fit.dof} degrees of freedom, and is "
        f"{fits[worst].chi2:.0f} without reading {worst}: this misreading is voided."
    )
    with Journal(session.folder) as journal:
        journal.event("void", worst, "misread: chi2 says so")
        return journal.session, fits[worst], words


def _compare(session: Session, fit: FrictionFit, out: Path) -> Comparison:
    with progress(gait_count(session), "gaits") as advance:
        compared = compare(session, fit, servo=SERVOS, progress=advance)
    comparison_figure(compared, out)
    gait = compared.gaits[1]
    step(
        3,
        f"Its speed at {gait.frequency_hz:.2g} Hz: {gait.low_all_m_s:#.2g} to "
        f"{gait.high_all_m_s:#.2g} m/s predicted with any hobby servos, {gait.measured_m_s:#.2g} "
        f"measured; ideal joints {gait.exact_m_s:#.2g}.",
        "Both agree." if compared.verdict == "agrees" else compared.verdict_text,
    )
    return compared


def _advise(session: Session) -> Advice:
    with working("looking at each reading that could be next"):
        advice = advise(session)
    step(4, advice.note or f"What to read next: {advice.best.in_words()}.")
    return advice


def _drive_wanted(
    session: Session, fit: FrictionFit, speed_m_s: float, truth: Truth
) -> dict[str, float]:
    with working("searching"):
        best = least_power_gait(session.setup.robot, fit.ground, speed_m_s=speed_m_s)
    gait = best.gait
    with RobotBoard("virtual:fast") as robot:
        driven = board_gait(robot, Gait(gait.alpha_rad, gait.beta_rad, gait.omega_rad_s))
    band = speed_band(fit, driven, servo=SERVOS)
    with working("the lab's robot crawls"):
        crawls = crawl_speed(truth.robot(session.setup.robot, np.random.default_rng(SEED)), driven)
    alpha, beta = math.degrees(driven.alpha_rad), math.degrees(driven.beta_rad)
    with_servos = band.cannot_run or (
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
