"""The demo's film: a robot of the virtual lab, filmed beforehand and measured now."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from ... import _core
from ...model.errors import BadInput
from ...model.gait import Gait
from ...show.progress import working
from .words import step


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
        step(7, f"The film of a crawl is left out: {error}")
        return None
    from ...show.video.film_figure import film_figure
    from ...video.measure_film import measure_film

    gait = Gait(truth["alpha_rad"], truth["beta_rad"], truth["omega_rad_s"])
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
