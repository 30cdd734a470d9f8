"""Which servo moves which joint, which way and about which centre: told from the joints' sines."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ..model.capture_rate import OPTION, played_hz
from ..model.gait import Gait
from ..model.plugs import even_steps, plugs
from .arrays import Array
from .checks import NEVER, Check
from .result import FilmedRun

CENTRE_RAD = math.radians(1.0)  # a centre further off is worth a trim
RATE_FLAG = 0.02
ALIKE = 0.15  # of two gaits: amplitudes, relative, and phase lags, rad
SLOW_MOTION = 1.5  # commanded rate over the filmed one: no robot lags behind its gait so much

Filmed = tuple[FilmedRun, Gait | None]  # what was measured, and the commanded gait


def _wiring(filmed: Filmed) -> tuple[list[int], list[int]]:
    """Return swapped joints, and joints that turn the wrong way."""
    run, gait = filmed
    phase = np.array([joint.phase_rad for joint in run.joints])
    if len(phase) <= 2:
        return [], []
    order, turned, _ = plugs(phase, gait.beta_rad if gait else None)
    swapped = [k + 1 for k, other in enumerate(order) if k != other]
    return swapped, [k + 1 for k in turned if k + 1 not in swapped]


def swapped_joints(run: FilmedRun, gait: Gait | None) -> list[int]:
    """Return the numbers of two joints that move as if their plugs were swapped; none if all fit.

    Nothing is told of the servo that moves them: it is not known which one that is.
    """
    return _wiring((run, gait))[0]


def _centres_off(filmed: Filmed) -> Array:
    """Return by how much each joint's centre is off, rad; 0 where a trim is not worth it."""
    run, gait = filmed
    commanded = gait.offset_rad if gait else 0.0
    off = np.array([joint.offset_rad - commanded for joint in run.joints])
    sigma = np.array([joint.offset_sigma_rad for joint in run.joints])
    known = np.abs(off) > np.maximum(CENTRE_RAD, 2 * sigma)
    known[[k - 1 for k in swapped_joints(run, gait)]] = False
    return np.where(known, off, 0.0)


def _centre_words(filmed: Filmed, _: float) -> str:
    run, off_deg = filmed[0], np.degrees(_centres_off(filmed))
    ends = run.joints[0], run.joints[-1]
    return "; ".join(
        f"joint {joint.joint} swings about {off:+.1f}° ± "
        f"{math.degrees(joint.offset_sigma_rad):.1f}° off its centre: move its trim by {-off:+.1f}°"
        + (", unless the tag at that end is glued on askew" if joint in ends else "")
        for joint, off in zip(run.joints, off_deg, strict=True)
        if off
    )


def _rate_off(filmed: Filmed) -> float:
    """Return by how much the rate differs from the commanded one, relative; 0 within its sigma."""
    run, gait = filmed
    if gait is None:
        return 0.0
    off = abs(run.omega_rad_s / gait.omega_rad_s - 1)
    return off if off > 4 * run.omega_sigma_rad_s / gait.omega_rad_s else 0.0


def _plug_words(filmed: Filmed, _: float) -> str:
    return (
        f"joints {' and '.join(map(str, _wiring(filmed)[0]))} move as if their plugs were swapped: "
        "swap them back, and film again. Which way round their servos turn, their trims, gains "
        "and lags are unknown until then"
    )


def _sense_words(filmed: Filmed, _: float) -> str:
    words = "moves the wrong way round: set its trim's sense to the other sign"
    return "; ".join(f"joint {k} {words}" for k in _wiring(filmed)[1])


SERVOS = (
    Check("plugs", lambda filmed: len(_wiring(filmed)[0]), 0, NEVER, _plug_words),
    Check("sense", lambda filmed: len(_wiring(filmed)[1]), 0, NEVER, _sense_words),
    Check("centre", lambda filmed: np.abs(_centres_off(filmed)).max(), 0, NEVER, _centre_words),
    Check("rate", _rate_off, RATE_FLAG, NEVER, lambda filmed, _: _rate_words(*filmed)),
)  # fmt: skip


def _rate_words(run: FilmedRun, gait: Gait) -> str:
    text = (
        f"the film shows {run.omega_rad_s / math.tau:.4g} Hz, commanded were "
        f"{gait.omega_rad_s / math.tau:.4g} Hz"
    )
    ratio = gait.omega_rad_s / run.omega_rad_s
    if ratio < SLOW_MOTION:
        return f"{text}: the robot did not run that gait, or the file's times are wrong"
    scale = run.time_scale
    taken_hz = ratio / scale * played_hz([0.0, 1.0 / (scale * run.film["frame_rate_hz"])])
    return (
        f"{text}: is it slow motion, {ratio:.2g} times? Then give the camera's pictures a second, "
        f"some {taken_hz:.0f}, with {OPTION}, or the run's recording with --recording; speeds are "
        "those of the file"
    )


def slow_motion_words(run: FilmedRun, made: Gait, gaits: Iterable[Gait]) -> str:
    """Return what is to be done if the joints made one of the gaits, but in slow motion; else "".

    made: the gait that the joints made. Slow motion is a whole number of times slower.
    """
    for gait in gaits:
        ratio = gait.omega_rad_s / run.omega_rad_s
        bent = abs(made.alpha_rad / max(gait.alpha_rad, 1e-9) - 1.0) < ALIKE
        apart = abs(math.remainder(made.beta_rad - gait.beta_rad, math.tau)) < ALIKE
        if ratio > SLOW_MOTION and abs(ratio / round(ratio) - 1.0) < ALIKE / 5 and bent and apart:
            return _rate_words(run, gait)
    return ""


def another_gait(run: FilmedRun, stated: Gait | None) -> Gait | None:
    """Return the gait of a film if it is not the one that was stated; None if it is, or none was.

    Servos lose amplitude, so less of it is no other gait; more is, and so is less than half.
    """
    if stated is None:
        return None
    made = measured_gait(run, None)
    rate = abs(run.omega_rad_s / stated.omega_rad_s - 1.0)
    same_rate = rate <= max(RATE_FLAG, 4 * run.omega_sigma_rad_s / stated.omega_rad_s)
    same_bend = 0.5 <= made.alpha_rad / max(stated.alpha_rad, 1e-9) <= 1.0 + ALIKE
    same_lag = abs(math.remainder(made.beta_rad - stated.beta_rad, math.tau)) <= 2 * ALIKE
    return None if same_rate and same_bend and same_lag else made


def measured_gait(run: FilmedRun, gait: Gait | None) -> Gait:
    """Return the gait that the joints made: gains and shifts beside the commanded one.

    Without a commanded gait: beside the mean amplitude and the even steps that fit best.
    """
    amplitude = np.array([j.amplitude_rad for j in run.joints])
    phase = np.array([j.phase_rad for j in run.joints])
    offset = float(np.mean([j.offset_rad for j in run.joints]))
    beta = gait.beta_rad if gait else even_steps(phase, None)[0]
    alpha = gait.alpha_rad if gait else float(amplitude.mean())
    off = np.exp(1j * (phase - beta * np.arange(len(phase))))
    shift = np.angle(off / (off.mean() / abs(off.mean())))
    return Gait(
        alpha,
        beta,
        run.omega_rad_s,
        offset,
        tuple((amplitude / alpha).tolist()),
        tuple(shift.tolist()),
    )
