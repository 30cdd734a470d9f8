"""The result of measuring a film: numbers with standard uncertainties, JSON, and a track as CSV."""

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
from .fitting.chain import joint_angles, mean_heading, wrapped
from .instrument import Measured
from .seeing.watch import Watched


@dataclass(frozen=True)
class Joint:
    """One joint's motion: phi = offset + amplitude sin(omega t + phase).

    joint: its number, from 1 at the tail. phase_rad: relative to the joint at the tail. seen: share
    of the frames in which both of its links are known from tags, 0 to 1.
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
    """A remark on a film or the robot in it: a short name for JSON, and a sentence."""

    name: str
    text: str


@dataclass(frozen=True)
class FilmedRun(Result):
    """The robot's motion in a film, as `serpenoid video` prints it.

    speed_m_s: speed along the mean path. direction_rad: direction of travel relative to the links'
    mean heading; 0 is head first. turn_rad_s: rate at which the path turns. omega_rad_s: angular
    rate of the gait. path_m: length of the mean path. periods: number of filmed periods.
    joints: from the tail. residual_px: root mean square distance between the tags' corners and the
    fitted chain. time_scale: factor by which the file's times were multiplied, for slow motion and
    for the board's clock. camera, film: their parameters for JSON. scale_sigma: relative standard
    uncertainty of all lengths, from the disagreement of links and tags; the speed's includes it.
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
        """Return the fields by name, for JSON."""
        return asdict(self)

    def in_words(self) -> str:
        """Return the speed along the path, in mm/s, with the path's length."""
        return (
            f"{1e3 * self.speed_m_s:.2f} ± {1e3 * self.speed_sigma_m_s:.2f} mm/s along "
            f"{1e3 * self.path_m:.0f} mm, {self.periods:.2f} periods"
        )

    def rows(self) -> list[Row]:
        """Return direction, deg, turn, deg/s, rate, Hz, and the time scale unless it is 1."""
        degrees, hertz = 180 / math.pi, 0.5 / math.pi
        direction, turn = degrees * self.direction_rad, degrees * self.turn_rad_s
        direction_sigma = degrees * self.direction_sigma_rad
        rows = [
            Row("direction, from where the links point", "deg", direction, sigma=direction_sigma),
            Row("turn", "deg/s", turn, sigma=degrees * self.turn_sigma_rad_s),
            Row("rate", "Hz", hertz * self.omega_rad_s, sigma=hertz * self.omega_sigma_rad_s),
        ]
        if self.time_scale != 1.0:
            rows.append(Row("time scale", "", self.time_scale))
        return rows


@dataclass(frozen=True)
class FilmMeasurement:
    """A measured film: the result, the detected tags, the fitted motion, and the commanded gait."""

    run: FilmedRun
    watched: Watched
    measured: Measured
    gait: Gait | None


def filmed_run(watched: Watched, measured: Measured, time_scale: float) -> FilmedRun:
    """Return the result of a measured film, without remarks.

    time_scale: factor of the times, in addition to the factor of the film's slow motion.
    """
    motion, bundle, film = measured.motion, measured.bundle, watched.film
    rate_sigma, *joint_sigmas, direction_sigma, speed_sigma, turn_sigma = measured.sigmas.tolist()
    span_s, t_s = float(np.ptp(measured.track.t_s)), watched.sightings.t_s
    camera, frame_s = bundle.camera, float(np.median(np.diff(t_s)))
    return FilmedRun(
        speed_m_s=motion.speed_m_s,
        speed_sigma_m_s=speed_sigma,
        direction_rad=motion.direction_rad,
        direction_sigma_rad=direction_sigma,
        turn_rad_s=motion.turn_rad_s,
        turn_sigma_rad_s=turn_sigma,
        omega_rad_s=motion.omega_rad_s,
        omega_sigma_rad_s=rate_sigma,
        path_m=motion.speed_m_s * span_s,
        periods=motion.omega_rad_s * span_s / (2 * np.pi),
        joints=_joints(measured, joint_sigmas),
        residual_px=float(np.nanmean(measured.track.rest_px**2)) ** 0.5,
        time_scale=time_scale * film.time_scale,
        camera={
            "focal_px": camera.focal_px,
            "readout_s": float(camera.readout_s),
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
            "frame_rate_hz": 1 / frame_s,
            "capture_fps": film.capture and film.capture.taken_hz,
        },
        scale_sigma=bundle.scale_off,
    )


def _joints(measured: Measured, sigmas: list[float]) -> tuple[Joint, ...]:
    """Return the joints' motions.

    sigmas: standard uncertainties of all amplitudes, of all phases but the first, which is the
    reference, and of all offsets.
    """
    motion, share_seen = measured.motion, measured.joint_mask.mean(axis=0)
    count = len(share_seen)
    columns = [
        motion.amplitude_rad,
        sigmas[:count],
        wrapped(motion.phase_rad - motion.phase_rad[0]),
        [0.0, *sigmas[count : 2 * count - 1]],
        motion.offset_rad,
        sigmas[2 * count - 1 :],
        share_seen,
    ]
    rows = np.array(columns).T.tolist()
    return tuple(Joint(number, *row) for number, row in enumerate(rows, 1))


def track_rows(measured: Measured) -> tuple[list[str], Array]:
    """Return the names of a track's columns and its rows, (frames, 4 + joints), in SI.

    The columns are time, mean position of the links, mean heading and the joints' angles from
    the tail; an angle is NaN where tags do not show the joint.
    """
    track, phi = measured.track, joint_angles(measured.track.states)
    count = phi.shape[1]
    joints = [f"joint{number}_rad" for number in range(1, count + 1)]
    angles = np.where(measured.joint_mask, phi, np.nan)
    position_m, heading_rad = track.states[:, :2], mean_heading(track.states)
    rows = np.column_stack([track.t_s, position_m, heading_rad, angles])
    return ["t_s", "x_m", "y_m", "heading_rad", *joints], rows


def write_track(measured: Measured, path: Path) -> None:
    """Write the track as CSV; the cell of a joint that tags do not show stays empty."""
    names, rows = track_rows(measured)
    lines = list[list[str]]()
    for row in rows:
        lines.append(["" if np.isnan(value) else f"{value:.7g}" for value in row])
    write_csv(path, names, lines)
