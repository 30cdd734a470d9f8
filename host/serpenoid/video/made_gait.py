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
    least_gain, largest_gain = 0.5, 1.15
    largest_lag_rad = 0.3  # Difference of the phase lags of one gait, stated and filmed.
    # Ratio of rates from which a film may be slow motion: no robot lags behind its gait so much.
    # A phone's slow motion is a whole number, to a relative error.
    least_ratio, whole_error = 1.5, 0.03
    for gait in [stated] if stated else planned:
        ratio = gait.omega_rad_s / run.omega_rad_s
        same_bend = least_gain <= filmed.alpha_rad / max(gait.alpha_rad, 1e-9) <= largest_gain
        lag_rad = math.remainder(filmed.beta_rad - gait.beta_rad, math.tau)
        same_lag = abs(lag_rad) <= largest_lag_rad
        same_rate = abs(ratio - 1.0) <= max(0.02, 4 * run.omega_sigma_rad_s / run.omega_rad_s)
        slow = ratio > least_ratio and abs(ratio / round(ratio) - 1.0) < whole_error
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
