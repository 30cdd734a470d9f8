"""The whole loop without a robot, then the 2005 session: friction, speeds, pictures, summary."""

from __future__ import annotations

import math
import shutil
import sys
from pathlib import Path

import serpenoid as sn

from .. import _core
from ..prediction.predict import as_json, one_cycle, predict_all
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from ..show import plot
from ..show.screen import progress
from .demo_loop import measure_demo_film, push_along_floor, run_loop, say, step
from .options import write_json

ALPHA_DEG, BETA_DEG = 70.0, 75.0  # the gait of the paper's experiment
GAITS = [
    sn.Gait(math.radians(ALPHA_DEG), math.radians(BETA_DEG), 2 * math.pi * hz)
    for hz in (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.25, 1.5)
]
PATH_ROBOT, PATH_GROUND = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
PATH_GAIT = sn.Gait(math.radians(30), math.radians(80), 5.0)


def session_folder() -> Path:
    """Return the session that is installed with the package."""
    return Path(_core.__file__).parent / "calibration_data" / "nirakh-2005"


def run_demo(out: Path, own: sn.FrictionFit | None = None) -> None:
    """Fit, predict, draw and sum up; everything it finds is written to the folder `out`.

    own: of a robot whose friction is then the simulated treadmill's truth.
    """
    out.mkdir(parents=True, exist_ok=True)
    say("This demo needs no robot: it measures a simulated one, whose true friction is known.\n")
    floor = push_along_floor(out, *run_loop(out, own))
    film = measure_demo_film(out)
    session = sn.load_session(session_folder())
    fit = sn.fit_friction(session)
    with progress(len(GAITS), "predicting speeds") as advance:
        points = predict_all(session.setup.robot, fit, GAITS, progress=advance)
    state, run = one_cycle(PATH_ROBOT, PATH_GROUND, PATH_GAIT)
    plot.friction_lines(
        session,
        fit,
        out / "friction.png",
        "the readings are regenerated from the two lines that the paper prints: its own are lost",
    )
    plot.speed_figure(
        points, f"2005 robot, α = {ALPHA_DEG:g}°, β = {BETA_DEG:g}°", out / "speed.png"
    )
    plot.path_and_poses(run, "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s", out / "path.png")
    parts = {"film": film, "floor": floor}
    numbers = as_json(fit, points, state) | {k: v for k, v in parts.items() if v is not None}
    write_json(out / "demo.json", numbers)
    # what a builder would ask of this robot, and how far to trust it
    fastest = [p for p in points if p.follows][-1]
    cn = fit.parameters["cn"]
    step(
        8,
        f"The robot of 2005: at {fastest.frequency_hz:g} Hz about {fastest.servo_m_s:#.2g} m/s "
        f"with typical servos ({fastest.low_m_s:#.2g} to {fastest.high_m_s:#.2g}).",
        too_fast_text(GAITS[-1], HOBBY, f"Its gait at {points[-1].frequency_hz:g} Hz"),
        "The paper's data points are lost: the readings come from its two printed lines, the "
        f"intervals from assumed instruments. Friction across is known to "
        f"{100 * cn.sigma / cn.value:.0f} % only.",
    )
    here = Path(sys.argv[0])  # by its path where the shell would not find it
    serpenoid = here.name if shutil.which(here.name) else str(here)
    serpenoid = "python -m serpenoid" if here.stem == "__main__" else serpenoid
    say(f"\nLook at {out / 'report.html'}. Pictures and numbers are beside it.")
    say(
        f"Next, without a robot: {serpenoid} drive --port virtual "
        "--alpha-deg 70 --beta-deg 75 --omega-rad-s 3"
    )
    say(f"With your robot: {serpenoid} flash; then doctor, trim, calibrate new DIR, fit DIR")
