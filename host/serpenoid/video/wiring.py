"""Which servo moves which joint, which way and about which centre: told from the joints' sines."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..model.gait import Gait
from ..model.plugs import EXPLAINED_RAD, even_steps, plugs
from .result import FilmedRun, Remark

CENTRE_RAD = math.radians(1.0)  # a centre further off is worth a trim
RATE_FLAG = 0.02


def servo_faults(run: FilmedRun, gait: Gait | None) -> Iterator[Remark]:
    """Yield what the joints say of the servos: order, sense, centres, and the gait's rate."""
    phase = np.array([j.phase_rad for j in run.joints])
    if len(phase) > 2 and np.isfinite(phase).all():
        swap, turned, rest = plugs(phase, gait.beta_rad if gait else None)
        if rest > EXPLAINED_RAD:
            yield Remark(
                "phases",
                f"the joints' phases are no even steps ({math.degrees(rest):.0f}° off): plugs of "
                "several servos may be swapped",
            )
        if swapped := [str(k + 1) for k, other in enumerate(swap) if k != other]:
            yield Remark(
                "plugs",
                f"joints {' and '.join(swapped)} move as if their plugs were swapped: swap them "
                "back",
            )
        if turned:
            words = "moves the wrong way round: set its trim's sense to the other sign"
            yield Remark("sense", "; ".join(f"joint {k + 1} {words}" for k in turned))
    off = {j: j.offset_rad - (gait.offset_rad if gait else 0.0) for j in run.joints}
    ends = run.joints[0], run.joints[-1]
    centres = [
        f"joint {j.joint} swings about {math.degrees(off[j]):+.1f}° ± "
        f"{math.degrees(j.offset_sigma_rad):.1f}° off its centre: move its trim by "
        f"{math.degrees(-off[j]):+.1f}°"
        + (", unless the tag at that end is glued on askew" if j in ends else "")
        for j in run.joints
        if abs(off[j]) > max(CENTRE_RAD, 2 * j.offset_sigma_rad)
    ]
    if centres:
        yield Remark("centre", "; ".join(centres))
    if gait is not None:
        ratio, sigma = run.omega_rad_s / gait.omega_rad_s, run.omega_sigma_rad_s / gait.omega_rad_s
        if abs(ratio - 1) > max(RATE_FLAG, 4 * sigma):
            yield Remark("rate", _rate_words(run.omega_rad_s, gait.omega_rad_s))


def _rate_words(filmed_rad_s: float, commanded_rad_s: float) -> str:
    text = (
        f"the film shows {filmed_rad_s / math.tau:.4g} Hz, commanded were "
        f"{commanded_rad_s / math.tau:.4g} Hz"
    )
    ratio = commanded_rad_s / filmed_rad_s
    if ratio > 1.5:
        return (
            f"{text}: is it slow motion, {ratio:.2g} times? Give the run's recording with "
            "--recording, and the times are put right; speeds are those of the file"
        )
    return f"{text}: the robot did not run that gait, or the file's times are wrong"


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
