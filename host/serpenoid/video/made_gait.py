"""The gait that the joints of a film made: beside the commanded one, and as a session's reading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.errors import BadInput
from ..base.vectors import columns
from ..model.capture_rate import OPTION, played_hz
from ..model.gait import Gait, gait_name
from .arrays import Array
from .result import FilmedRun, FilmMeasurement, track_rows

LEAST_GAIN = 0.5  # Share of the amplitude that every servo keeps.
ALIKE_SHARE = 0.15  # Relative difference of two gaits' amplitudes; phase lags: twice that, rad.
SLOW_MOTION = 1.5  # Commanded rate over the filmed one; no robot lags behind its gait so much.
WHOLE_TOLERANCE = 0.03  # Relative distance of a phone's slow motion from a whole number.


def measured_gait(run: FilmedRun, gait: Gait | None) -> Gait:
    """Return the gait that the joints made: gains and shifts beside the commanded one.

    Without a commanded gait: beside the mean amplitude and the even steps that fit best.
    """
    amplitude, phase, offset = columns(run.joints, "amplitude_rad", "phase_rad", "offset_rad")
    alpha = gait.alpha_rad if gait else float(amplitude.mean())
    steps = np.array([gait.beta_rad]) if gait else np.radians(np.arange(-180.0, 180.0, 0.5))
    phasors = np.exp(1j * (phase - steps[:, None] * np.arange(len(phase))))
    shifts = np.angle(phasors / np.exp(1j * np.angle(phasors.mean(axis=1, keepdims=True))))
    best = int(np.mean(shifts**2, axis=1).argmin())
    return Gait(
        alpha,
        float(steps[best]),
        run.omega_rad_s,
        float(offset.mean()),
        tuple((amplitude / alpha).tolist()),
        tuple(shifts[best].tolist()),
    )


def gait_doubt(run: FilmedRun, stated: Gait | None, planned: Sequence[Gait] = ()) -> str:
    """Return why a film does not show the gait that was stated, or is in slow motion; else "".

    Servos lose amplitude, so less of it is no other gait; more is, and so is less than half.
    """
    filmed = measured_gait(run, None)
    for gait in [stated] if stated else planned:
        ratio = gait.omega_rad_s / run.omega_rad_s
        same_bend = LEAST_GAIN <= filmed.alpha_rad / max(gait.alpha_rad, 1e-9) <= 1.0 + ALIKE_SHARE
        same_lag = abs(math.remainder(filmed.beta_rad - gait.beta_rad, math.tau)) <= 2 * ALIKE_SHARE
        same_rate = abs(ratio - 1.0) <= max(0.02, 4 * run.omega_sigma_rad_s / run.omega_rad_s)
        slow = ratio > SLOW_MOTION and abs(ratio / round(ratio) - 1.0) < WHOLE_TOLERANCE
        words = f"the film shows the gait {gait_name(filmed)}"
        if same_bend and same_lag and slow:
            played = played_hz([0.0, 1.0 / (run.time_scale * run.film["frame_rate_hz"])])
            return (
                f"{words}, and {gait_name(gait)} was meant: is it slow motion, {ratio:.2g} times? "
                f"Then give the camera's pictures a second, some "
                f"{ratio / run.time_scale * played:.0f}, with {OPTION}, or the run's recording "
                "with --recording; speeds are those of the file"
            )
        if stated and not (same_bend and same_lag and same_rate):
            return (
                f"{words}; stated was {gait_name(gait)}. Leave the gait's options out to keep it "
                "as a reading of the gait that it shows"
            )
    return ""


def film_cells(film: FilmMeasurement, planned: Sequence[Gait] = ()) -> tuple[dict[str, Any], Array]:
    """Return the cells of a `video` reading, and the samples of its track.

    planned: the session's gaits. Raises BadInput: the film shows slow motion, or another gait than
    was stated.
    """
    run = film.run
    if words := gait_doubt(run, film.gait, planned):
        raise BadInput(f"{run.film['name']}: {words}")
    gait = measured_gait(run, film.gait)
    (sigma,) = columns(run.joints, "amplitude_sigma_rad")
    cells = {
        "alpha_deg": math.degrees(gait.alpha_rad),
        "beta_deg": math.degrees(gait.beta_rad),
        "omega_rad_s": gait.omega_rad_s,
        "offset_deg": math.degrees(gait.offset_rad),
        "speed_m_s": run.speed_m_s,
        "speed_sigma_m_s": run.speed_sigma_m_s,
        "gain_sigma": float(np.mean(sigma / gait.alpha_rad)),
        "gains": ",".join(f"{gain:.5f}" for gain in gait.joint_gain),
        "shifts_deg": ",".join(f"{math.degrees(s):.3f}" for s in gait.joint_shift_rad),
        "film_sha256": run.film["sha256"],
    }
    return cells, track_rows(film.measured)[1]
