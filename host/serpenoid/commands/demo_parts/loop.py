"""The demo's first part: the whole loop without hardware, on a treadmill whose truth is known."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...calibration.advice import advise
from ...calibration.advising.next_reading import Advice
from ...calibration.comparison import Comparison, compare, gait_count
from ...calibration.friction_fit import fit_friction
from ...calibration.friction_result import DOUBTFUL, whole_ground
from ...calibration.session_rows import events_of
from ...calibration.speed_samples import speed_band
from ...calibration.taking.board_run import board_gait
from ...calibration.taking.journal import Journal
from ...calibration.taking.new_session import create_session, default_setup
from ...calibration.taking.simulated import SimulatedTreadmill, Truth
from ...calibration.taking.treadmill import take_all
from ...gaits.least_power import least_power_gait
from ...lab.crawl import crawl_speed
from ...model.errors import BadInput
from ...model.files import write_text
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot as Body
from ...robot.robot import RobotBoard
from ...servos.catalogue import servo
from ...show import report
from ...show.comparison_figure import comparison_figure
from ...show.friction_report import show_advice, show_comparison
from ...show.progress import progress
from ...show.session.report_page import session_page
from ..options import finite

if TYPE_CHECKING:
    from ...calibration.friction_result import FrictionFit
    from ...calibration.session import Session, Setup

NAME = "demo, simulated"
SEED, SERVOS = 2005, servo("hobby")
TRUTH = Truth(
    Ground(ct=0.084, cn=1.2, ft0=0.14, fn0=0.27),
    math.radians(0.12),
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
    say(
        "No robot, no treadmill: both are simulated, with the firmware's own controller, so that "
        "the truth is known. It is the afternoon that `serpenoid calibrate` leads through.\n"
    )
    say("[1/8] a session on the simulated treadmill, by the procedure that a person follows")
    session = take_session(out / "session", truth, own and own.robot)
    say(
        f"      {len(session.kept)} stations and {len(session.kept_gait_runs)} gait runs; the "
        f"inclinometer's zero found at {math.degrees(session.zero.value_rad):+.2f} deg (true: "
        f"{math.degrees(truth.incline_zero_rad):+.2f})"
    )
    say("[2/8] friction fitted, beside the truth that no fit knows")
    session, fit = _without_outlier(session, fit_friction(session))
    found: dict[str, Any] = {"fit": fit.to_dict(), "truth": truth_table(fit, truth.ground)}
    say("[3/8] speeds predicted from it, and the gait runs over them")
    compared = _compare(session, fit, out / "comparison.png")
    say("[4/8] the reading to take next")
    advised = _advise(session)
    found |= {"comparison": compared.to_dict(), "advice": advised.to_dict()}
    wanted_m_s = float(f"{compared.gaits[1].exact_m_s:.1g}")
    say(f"[5/8] the cheapest gait for {wanted_m_s:g} m/s on this ground, sent to the virtual robot")
    found["wanted"] = _drive_wanted(session, fit, wanted_m_s, truth)
    page = session_page(session, fit, compared, advised, events_of(session))
    write_text(out / "report.html", page)
    say(f"      all of it in one page: {out / 'report.html'}")
    write_text(out / "loop.json", json.dumps(finite(found), indent=2, allow_nan=False) + "\n")
    return fit, truth.ground


def say(text: str) -> None:
    """Print a line as it stands."""
    report.console.print(text, highlight=False, markup=False)


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
        treadmill = SimulatedTreadmill(
            setup, truth, SEED, run_gait=lambda gait: board_gait(robot, gait)
        )
        journal.event("start", detail="demo")
        with report.busy("stations, bends and gait runs"):
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


def _without_outlier(session: Session, fit: FrictionFit) -> tuple[Session, FrictionFit]:
    """Void the reading without which chi2 is least, where the readings cannot all be right."""
    if fit.p_value is None or fit.p_value > DOUBTFUL or session.folder is None:
        return session, fit
    fits = {}
    for reading in session.kept:
        others = tuple(replace(r, voided=r.voided or r is reading) for r in session.readings)
        fits[reading.number] = fit_friction(replace(session, readings=others))
    worst = min(fits, key=lambda number: fits[number].chi2)
    say(
        f"      chi2 is {fit.chi2:.0f} for {fit.dof} degrees of freedom; without reading {worst} "
        f"{fits[worst].chi2:.0f}: somebody misread it, so it is voided"
    )
    with Journal(session.folder) as journal:
        journal.event("void", worst, "misread: chi2 says so")
        return journal.session, fits[worst]


def truth_table(fit: FrictionFit, ground: Ground) -> dict[str, float]:
    """Show a fit beside the truth; return the truth."""
    truth = {name: getattr(ground, name) for name in ("ct", "cn", "ft0", "fn0")}
    rows = [
        [
            row.name,
            row.unit,
            f"{row.value:.4g}",
            f"{row.low:.3g} to {row.high:.3g}",
            f"{true:.3g}",
            "yes" if row.low <= true <= row.high else "no",
        ]
        for row, true in zip(fit.rows(), truth.values(), strict=True)
    ]
    columns = ["whole snake", "unit", "fitted", "95 % interval", "truth", "inside"]
    report.table("friction", columns, rows)
    return truth


def _compare(session: Session, fit: FrictionFit, out: Path) -> Comparison:
    with progress(gait_count(session), "gaits") as advance:
        found = compare(session, fit, servo=SERVOS, progress=advance)
    show_comparison(found)
    comparison_figure(found, out)
    return found


def _advise(session: Session) -> Advice:
    with report.busy("looking at each reading that could be next"):
        found = advise(session)
    show_advice(found, 3)
    return found


def _drive_wanted(
    session: Session, fit: FrictionFit, speed_m_s: float, truth: Truth
) -> dict[str, float]:
    with report.busy("searching"):
        best = least_power_gait(session.setup.robot, fit.ground, speed_m_s=speed_m_s)
    gait = best.gait
    with RobotBoard("virtual:fast") as robot:
        made = board_gait(robot, Gait(gait.alpha_rad, gait.beta_rad, gait.omega_rad_s))
    band = speed_band(fit, made, servo=SERVOS)
    alpha, beta = math.degrees(made.alpha_rad), math.degrees(made.beta_rad)
    frequency_hz = made.omega_rad_s / (2 * math.pi)
    say(
        f"      alpha {alpha:.2f} deg, beta {beta:.2f} deg, {frequency_hz:.4f} Hz, "
        f"{1000 * best.power_w:.1f} mW; so the board's own set-points have it"
    )
    say(f"      predicted: {band.in_words()}")
    with report.busy("the lab's robot crawls"):
        crawls = crawl_speed(truth.robot(session.setup.robot, np.random.default_rng(SEED)), made)
    inside = "inside" if band.low_m_s <= crawls <= band.high_m_s else "outside"
    say(
        f"      the lab's robot, whose servos nobody was told, crawls at {crawls:.4f} m/s: {inside}"
    )
    return {
        "alpha_deg": alpha,
        "beta_deg": beta,
        "frequency_hz": frequency_hz,
        "power_w": best.power_w,
        "crawls_m_s": crawls,
    } | band.to_dict()
