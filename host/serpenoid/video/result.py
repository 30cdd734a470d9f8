"""What a film says of the robot, in numbers with standard deviations; its JSON and its track."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..base.checks import sha256_of
from ..base.files import write_csv
from ..base.rows import Result, Row
from ..model.gait import Gait
from .arrays import Array
from .fitting.bundle import READOUT
from .fitting.chain import joint_angles, mean_heading, wrapped
from .instrument import Measured
from .seeing.watch import Watched


@dataclass(frozen=True)
class Joint:
    """One joint's sine: phi = offset + amplitude sin(w t + phase); joints count from the tail.

    phase_rad: beside the tail joint's. seen: share of the frames whose tags hold the joint.
    """

    joint: int
    amplitude_rad: float
    amplitude_sigma_rad: float
    phase_rad: float
    phase_sigma_rad: float
    offset_rad: float
    offset_sigma_rad: float
    seen: float


@dataclass(frozen=True)
class Remark:
    """One thing to know about a film or the robot in it: a short name, and words."""

    name: str
    text: str


@dataclass(frozen=True)
class FilmedRun(Result):
    """What `serpenoid video` tells.

    Speed, along the mean path; direction of travel from the links' mean heading (0: head first);
    turn; rate; path_m: length of the mean path. joints: from the tail. residual_px:
    root mean square of the corners beside the fitted chain. time_scale: what the file's times were
    multiplied with, for slow motion and the board's time. film, camera: what JSON holds of them.
    scale_sigma: relative, of all lengths, and part of the speed's: how far links and tags disagree.
    """

    speed_m_s: float
    speed_sigma_m_s: float
    direction_rad: float
    direction_sigma_rad: float
    turn_rad_s: float
    turn_sigma_rad_s: float
    omega_rad_s: float
    omega_sigma_rad_s: float
    path_m: float
    periods: float
    joints: tuple[Joint, ...]
    residual_px: float
    time_scale: float
    camera: dict[str, Any]
    film: dict[str, Any]
    scale_sigma: float
    remarks: tuple[Remark, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return asdict(self)

    def in_words(self) -> str:
        """Return the speed along the path."""
        return (
            f"{1e3 * self.speed_m_s:.2f} ± {1e3 * self.speed_sigma_m_s:.2f} mm/s along "
            f"{1e3 * self.path_m:.0f} mm, {self.periods:.2f} periods"
        )

    def rows(self) -> list[Row]:
        """Return direction, turn, rate, and what the file's times were multiplied with."""
        degrees, hertz = 180 / math.pi, 0.5 / math.pi
        direction, turn = degrees * self.direction_rad, degrees * self.turn_rad_s
        direction_sigma = degrees * self.direction_sigma_rad
        rows = [
            Row("direction, from where the links point", "deg", direction, sigma=direction_sigma),
            Row("turn", "deg/s", turn, sigma=degrees * self.turn_sigma_rad_s),
            Row("rate", "Hz", hertz * self.omega_rad_s, sigma=hertz * self.omega_sigma_rad_s),
        ]
        scale = [] if self.time_scale == 1.0 else [Row("time scale", "", self.time_scale)]
        return rows + scale


@dataclass(frozen=True)
class FilmMeasurement:
    """Everything of one film: numbers, what was seen, what was fitted, the commanded gait."""

    run: FilmedRun
    watched: Watched
    measured: Measured
    gait: Gait | None


def filmed_run(watched: Watched, measured: Measured, time_scale: float) -> FilmedRun:
    """Gather the numbers of a measured film, without remarks."""
    m, bundle, film = measured.motion, measured.bundle, watched.film
    rate_sigma, *joint_sigmas, direction_sigma, speed_sigma, turn_sigma = measured.sigmas.tolist()
    span_s, t_s = float(np.ptp(measured.track.t_s)), watched.sightings.t_s
    camera = bundle.camera
    rms_px = float(np.sqrt(np.nanmean(measured.track.rest_px**2)))
    return FilmedRun(
        speed_m_s=m.speed_m_s,
        speed_sigma_m_s=speed_sigma,
        direction_rad=m.direction_rad,
        direction_sigma_rad=direction_sigma,
        turn_rad_s=m.turn_rad_s,
        turn_sigma_rad_s=turn_sigma,
        omega_rad_s=m.omega_rad_s,
        omega_sigma_rad_s=rate_sigma,
        path_m=m.speed_m_s * span_s,
        periods=m.omega_rad_s * span_s / (2 * np.pi),
        joints=_joints(measured, joint_sigmas),
        residual_px=rms_px,
        time_scale=time_scale * film.time_scale,
        camera={
            "focal_px": camera.focal_px,
            "readout_s": float(camera.shared[READOUT]),
            "tag_side_m": camera.side_m,
            "printed_side_m": bundle.side_m,
        },
        film={
            "name": film.path.name,
            "sha256": sha256_of(film.path),
            "width_px": film.width,
            "height_px": film.height,
            "frames": len(t_s),
            "duration_s": float(np.ptp(t_s)),
            "frame_rate_hz": float(1 / np.median(np.diff(t_s))),
            "capture_fps": film.capture and film.capture.taken_hz,
        },
        scale_sigma=bundle.scale_off,
    )


def _joints(measured: Measured, sigmas: list[float]) -> tuple[Joint, ...]:
    """Return the joints' sines; sigmas: of amplitudes, phases but the first, and offsets."""
    m, share_seen = measured.motion, measured.joint_mask.mean(axis=0)
    count = len(share_seen)
    columns = [
        m.amplitude_rad,
        sigmas[:count],
        wrapped(m.phase_rad - m.phase_rad[0]),
        [0.0, *sigmas[count : 2 * count - 1]],
        m.offset_rad,
        sigmas[2 * count - 1 :],
        share_seen,
    ]
    rows = np.array(columns).T.tolist()
    return tuple(Joint(number, *row) for number, row in enumerate(rows, 1))


def track_rows(measured: Measured) -> tuple[list[str], Array]:
    """Return the columns of a track and its rows: time, place, heading, joints."""
    track, phi = measured.track, joint_angles(measured.track.states)
    joints = [f"joint{i + 1}_rad" for i in range(phi.shape[1])]
    angles = np.where(measured.joint_mask, phi, np.nan)
    rows = np.column_stack([track.t_s, track.states[:, :2], mean_heading(track.states), angles])
    return ["t_s", "x_m", "y_m", "heading_rad", *joints], rows


def write_track(measured: Measured, path: Path) -> None:
    """Write the track as CSV; a joint that no tag holds in a frame stays empty."""
    names, rows = track_rows(measured)
    write_csv(path, names, (["" if np.isnan(x) else f"{x:.7g}" for x in row] for row in rows))
