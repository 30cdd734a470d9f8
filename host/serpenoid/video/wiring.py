"""Which servo moves which joint, which way and about which centre: told from the joints' sines."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from ..model.capture_rate import OPTION, played_hz
from ..model.gait import Gait
from ..model.plugs import EXPLAINED_RAD, even_steps, plugs
from .result import FilmedRun, Remark

CENTRE_RAD = math.radians(1.0)  # a centre further off is worth a trim
RATE_FLAG = 0.02
ALIKE = 0.15  # of two gaits: amplitudes, relative, and phase lags, rad
SLOW_MOTION = 1.5  # commanded rate over the filmed one: no robot lags behind its gait so much


def servo_faults(run: FilmedRun, gait: Gait | None) -> Iterator[Remark]:
    """Yield what the joints say of the servos: order, sense, centres, and the gait's rate."""
    phase = np.array([j.phase_rad for j in run.joints])
    unplugged = swapped_joints(run, gait)
    if len(phase) > 2 and np.isfinite(phase).all():
        _, turned, rest = plugs(phase, gait.beta_rad if gait else None)
        if rest > EXPLAINED_RAD:
            yield Remark(
                "phases",
                f"the joints' phases are no even steps ({math.degrees(rest):.0f}° off): plugs of "
                "several servos may be swapped",
            )
        if unplugged:
            yield Remark(
                "plugs",
                f"joints {' and '.join(map(str, unplugged))} move as if their plugs were swapped: "
                "swap them back, and film again. Which way round their servos turn, their trims, "
                "gains and lags are unknown until then",
            )
        words = "moves the wrong way round: set its trim's sense to the other sign"
        if reversed_joints := [k + 1 for k in turned if k + 1 not in unplugged]:
            yield Remark("sense", "; ".join(f"joint {k} {words}" for k in reversed_joints))
    off = {j: j.offset_rad - (gait.offset_rad if gait else 0.0) for j in run.joints}
    ends = run.joints[0], run.joints[-1]
    centres = [
        f"joint {j.joint} swings about {math.degrees(off[j]):+.1f}° ± "
        f"{math.degrees(j.offset_sigma_rad):.1f}° off its centre: move its trim by "
        f"{math.degrees(-off[j]):+.1f}°"
        + (", unless the tag at that end is glued on askew" if j in ends else "")
        for j in run.joints
        if j.joint not in unplugged and abs(off[j]) > max(CENTRE_RAD, 2 * j.offset_sigma_rad)
    ]
    if centres:
        yield Remark("centre", "; ".join(centres))
    if gait is not None:
        ratio, sigma = run.omega_rad_s / gait.omega_rad_s, run.omega_sigma_rad_s / gait.omega_rad_s
        if abs(ratio - 1) > max(RATE_FLAG, 4 * sigma):
            yield Remark("rate", _rate_words(run, gait))


def swapped_joints(run: FilmedRun, gait: Gait | None) -> list[int]:
    """Return the numbers of two joints that move as if their plugs were swapped; none if all fit.

    Nothing is told of the servo that moves them: it is not known which one that is.
    """
    phase = np.array([j.phase_rad for j in run.joints])
    if len(phase) <= 2 or not np.isfinite(phase).all():
        return []
    order = plugs(phase, gait.beta_rad if gait else None)[0]
    return [k + 1 for k, other in enumerate(order) if k != other]


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
