"""A measured film as a reading of a session, and its joints as a gait."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from ..base.errors import BadInput
from ..model.gait import Gait
from .arrays import Array
from .measure_film import FilmMeasurement
from .result import track_rows
from .wiring import measured_gait, slow_motion_words


def film_cells(film: FilmMeasurement, gaits: Iterable[Gait] = ()) -> tuple[dict[str, Any], Array]:
    """Return the cells of a `video` reading, and the samples of its track.

    gaits: of the session. Raises BadInput where the gait that was driven shows slow motion.
    """
    run = film.run
    gait = measured_gait(run, film.gait)
    if words := slow_motion_words(run, gait, [film.gait] if film.gait else gaits):
        raise BadInput(f"{run.film['name']}: {words}")
    spread = [joint.amplitude_sigma_rad / gait.alpha_rad for joint in run.joints]
    cells = {
        "alpha_deg": math.degrees(gait.alpha_rad),
        "beta_deg": math.degrees(gait.beta_rad),
        "omega_rad_s": gait.omega_rad_s,
        "offset_deg": math.degrees(gait.offset_rad),
        "speed_m_s": run.speed_m_s,
        "speed_sigma_m_s": run.speed_sigma_m_s,
        "gain_sigma": float(np.mean(spread)),
        "gains": ",".join(f"{gain:.5f}" for gain in gait.joint_gain),
        "shifts_deg": ",".join(f"{math.degrees(s):.3f}" for s in gait.joint_shift_rad),
        "film_sha256": run.film["sha256"],
    }
    _, rows = track_rows(film.measured)
    return cells, rows
