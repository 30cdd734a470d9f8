"""The whole loop without a robot, then the 2005 session: friction, speeds, pictures, summary."""

from __future__ import annotations

import json
import math
import shutil
import sys
from pathlib import Path

from .. import _core
from ..calibration.friction_fit import fit_friction
from ..calibration.friction_result import FrictionFit
from ..calibration.prediction import SpeedPoint, as_json, one_cycle, predict_all
from ..calibration.session_file import load_session
from ..model.files import write_text
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..show import plot, report
from ..show.progress import progress
from .demo_parts.film import measure_demo_film
from .demo_parts.floor import push_along_floor
from .demo_parts.loop import run_loop, say
from .options import finite

ALPHA_DEG, BETA_DEG = 70.0, 75.0  # the gait of the paper's experiment
GAITS = [
    Gait(math.radians(ALPHA_DEG), math.radians(BETA_DEG), 2 * math.pi * hz)
    for hz in (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.25, 1.5)
]
PATH_ROBOT, PATH_GROUND = Robot(6, 1.0, 0.12), Ground(0.1, 10.0)
PATH_GAIT = Gait(math.radians(30), math.radians(80), 5.0)


def session_folder() -> Path:
    """Return the session that is installed with the package."""
    return Path(_core.__file__).parent / "calibration_data" / "nirakh-2005"


def run_demo(out: Path, own: FrictionFit | None = None) -> None:
    """Fit, predict, draw and sum up; everything it finds is written to the folder `out`.

    own: of a robot whose friction is then the simulated treadmill's truth.
    """
    out.mkdir(parents=True, exist_ok=True)
    floor = push_along_floor(out, *run_loop(out, own))
    say("[7/8] a film of a robot of the virtual lab: speed and joints from pixels")
    film = measure_demo_film(out)
    say("[8/8] the session of 2005, as far as the paper gives it")
    session = load_session(session_folder())
    fit = fit_friction(session)
    robot = session.setup.robot
    report.fit(fit)
    with progress(len(GAITS), "predicting speeds") as advance:
        points = predict_all(robot, fit, GAITS, progress=advance)
    _speed_table(points)
    state, run = one_cycle(PATH_ROBOT, PATH_GROUND, PATH_GAIT)
    files = [out / name for name in ("friction.png", "speed.png", "path.png", "demo.json")]
    plot.friction_lines(
        session,
        fit,
        files[0],
        "the readings are regenerated from the two lines that the paper prints: its own are lost",
    )
    plot.speed_against_frequency(
        points, f"2005 robot, α = {ALPHA_DEG:g}°, β = {BETA_DEG:g}° (Fig. 17)", files[1]
    )
    plot.path_and_poses(run, "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s", files[2])
    found = as_json(fit, points, state) | ({} if film is None else {"film": film})
    found |= {} if floor is None else {"floor": floor}
    text = json.dumps(finite(found), indent=2, allow_nan=False)
    write_text(files[3], text + "\n")
    _summary(fit, points, files)


def _speed_table(points: list[SpeedPoint]) -> None:
    rows = [
        [
            f"{p.frequency_hz:.1f}",
            f"{p.explicit_m_s:.4f}",
            f"{p.low_ideal_m_s:.3f} to {p.high_ideal_m_s:.3f}",
            f"{p.low_m_s:#.2g} to {p.high_m_s:#.2g}" if p.follows else "they cannot follow",
            f"{p.implicit_m_s:.4f}",
            f"{100 * (p.implicit_m_s / p.explicit_m_s - 1):+.1f} %",
        ]
        for p in points
    ]
    columns = [
        "frequency (Hz)",
        "ideal joints (m/s)",
        "95 %",
        "95 %, any hobby servo",
        "implicit (m/s)",
        "off by",
    ]
    report.table(f"speed at alpha {ALPHA_DEG:g} deg, beta {BETA_DEG:g} deg", columns, rows)


def _summary(fit: FrictionFit, points: list[SpeedPoint], files: list[Path]) -> None:
    followed = [p for p in points if p.follows]
    at = followed[-1]
    doubt = max(followed, key=lambda p: p.sigma_m_s / p.explicit_m_s)
    off = max(points, key=lambda p: abs(p.implicit_m_s / p.explicit_m_s - 1))
    step = max(points, key=lambda p: p.implicit_error_m_s / p.implicit_m_s)
    cn = fit.parameters["cn"]
    lines = [
        f"At {at.frequency_hz:g} Hz the robot should crawl at about {at.servo_m_s:#.2g} m/s with "
        f"typical hobby servos ({at.low_m_s:#.2g} to {at.high_m_s:#.2g} for 95 % of the frictions "
        f"and servos that the readings allow); ideal joints {at.explicit_m_s:#.2g}. Beyond "
        f"{at.managed_hz:.2g} Hz most hobby servos cannot run this gait.",
        f"Friction and servos leave most open near {doubt.frequency_hz:g} Hz "
        f"(1 sigma: {100 * doubt.sigma_m_s / doubt.explicit_m_s:.0f} %). Of friction, "
        f"across is the weak spot: cn is known to {100 * cn.sigma / cn.value:.0f} % from a 7.5 deg "
        "bend.",
        f"The numerical error of the exact model is below "
        f"{max(p.explicit_error_m_s for p in points):.0e} m/s; wheels stick exactly, no smoothing.",
        f"The paper's implicit model (k = 1000 N/m) is off by up to "
        f"{100 * (off.implicit_m_s / off.explicit_m_s - 1):+.1f} % here, at "
        f"{off.frequency_hz:g} Hz: its joints are springs. That is no error of its time steps, "
        f"which make {100 * step.implicit_error_m_s / step.implicit_m_s:.3f} % at most.",
        "The readings are regenerated from the paper's two published lines, as its own data points "
        "are lost: the intervals come from assumed instrument errors, not from scatter.",
        "Written: " + ", ".join(str(f) for f in files),
        f"The simulated session, its comparison and its report: {files[0].parent}/session, "
        "comparison.png, report.html",
        f"Next, without a robot: {_called()} view virtual. With your own: {_called()} flash; "
        "doctor; trim; calibrate new DIR; fit DIR; then --session DIR gives its friction to any "
        "command.",
    ]
    report.console.print()
    for line in lines:
        report.console.print(line, highlight=False)


def _called() -> str:
    """Return how this program is called: by its path where the shell would not find it."""
    here = Path(sys.argv[0])
    if here.stem == "__main__":
        return "python -m serpenoid"
    return here.name if shutil.which(here.name) else str(here)
