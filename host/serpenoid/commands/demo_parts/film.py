"""The demo's film: a robot of the virtual lab, filmed beforehand and measured now."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from ... import _core
from ...model.errors import BadInput
from ...model.gait import Gait
from ...show import report
from .loop import say


def measure_demo_film(out: Path) -> dict[str, Any] | None:
    """Measure the film that is installed with the package, beside what the lab knows.

    The film is made by studies/demo_film.py: rendering takes longer than the demo may, and needs
    the tests' renderer. Returns None where the extra [video] is missing, and says so.
    """
    from ...video.seeing.extra import need_extra

    folder = Path(_core.__file__).parent / "calibration_data" / "demo-film"
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    try:
        need_extra()
    except BadInput as error:
        say(f"      left out: {error}")
        return None
    from ...show.video.film_figure import film_figure
    from ...video.measure_film import measure_film

    gait = Gait(truth["alpha_rad"], truth["beta_rad"], truth["omega_rad_s"])
    with report.busy("watching the film"):
        found = measure_film(folder / "film.mp4", truth["links"], truth["link_length_m"], gait=gait)
    film_figure(found, out / "film.png")
    run = found.run
    _show(run, truth)
    say(
        f"      path, joints and residuals: {out / 'film.png'}. With your own robot: serpenoid "
        "video tags, then serpenoid video FILE"
    )
    return run.to_dict() | {"truth": truth}


def _show(run: Any, truth: dict[str, Any]) -> None:
    """Print what the film shows beside the truth."""
    rows = [_row("speed (mm/s)", run.speed_m_s, run.speed_sigma_m_s, truth["speed_m_s"], 1e3)]
    for joint in run.joints:
        k = joint.joint - 1
        rows.append(
            _row(
                f"joint {joint.joint}, amplitude (°)",
                joint.amplitude_rad,
                joint.amplitude_sigma_rad,
                truth["amplitude_rad"][k],
            )
        )
        if k:
            true = joint.phase_rad + math.remainder(
                truth["phase_rad"][k] - joint.phase_rad, math.tau
            )
            rows.append(
                _row(
                    f"joint {joint.joint}, phase (°)", joint.phase_rad, joint.phase_sigma_rad, true
                )
            )
    report.table("a film of 2.6 s", ["number", "measured", "truth", "off, in σ"], rows)


def _row(
    name: str, value: float, sigma: float, true: float, unit: float = 180 / math.pi
) -> list[str]:
    off = (value - true) / sigma
    return [name, f"{unit * value:.2f} ± {unit * sigma:.2f}", f"{unit * true:.2f}", f"{off:+.1f}"]
