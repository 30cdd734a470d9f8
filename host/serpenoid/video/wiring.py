"""Which servo moves which joint, which way and about which centre: told from the joints' sines."""

from __future__ import annotations

import math

import numpy as np

from ..model.gait import Gait
from ..model.plugs import EXPLAINED_RAD, even_steps, plugs
from .faults import Check, judged
from .result import FilmedRun, Remark

CENTRE_RAD = math.radians(1.0)  # a centre further off is worth a trim
RATE_FLAG = 0.02


def judge(run: FilmedRun, gait: Gait | None) -> list[Remark]:
    """Return what the joints say of the servos: order, sense, centres, rate, amplitude."""
    return judged(RUN, (run, gait))


Ran = tuple[FilmedRun, Gait | None]


def _explained(ran: Ran) -> tuple[list[int], list[int], float]:
    """Return the joints that stand in each other's place, the reversed ones, and the rest, rad."""
    run, gait = ran
    phase = np.array([j.phase_rad for j in run.joints])
    if len(phase) < 3 or not np.isfinite(phase).all():
        return [], [], 0.0
    swap, turned, rest = plugs(phase, gait.beta_rad if gait else None)
    return [k + 1 for k, other in enumerate(swap) if k != other], turned, rest


def _off_centre(ran: Ran) -> list[str]:
    """Return the words on each joint that does not swing about the commanded bend, or else 0."""
    run, gait = ran
    meant = gait.offset_rad if gait else 0.0
    return [
        f"joint {joint.joint} swings about {math.degrees(off):+.1f}° ± "
        f"{math.degrees(joint.offset_sigma_rad):.1f}° off its centre: move its trim by "
        f"{math.degrees(-off):+.1f}°"
        for joint in run.joints
        if abs(off := joint.offset_rad - meant) > max(CENTRE_RAD, 2 * joint.offset_sigma_rad)
    ]


def _rate_off(ran: Ran) -> float:
    """Return how far the rate is off the commanded one, over what is allowed."""
    run, gait = ran
    if gait is None:
        return 0.0
    off = run.omega_rad_s / gait.omega_rad_s - 1
    return abs(off) / max(RATE_FLAG, 4 * run.omega_sigma_rad_s / gait.omega_rad_s)


def _rate_words(ran: Ran, _: float) -> str:
    run, gait = ran
    assert gait is not None
    ratio = gait.omega_rad_s / run.omega_rad_s
    hertz = [omega / (2 * math.pi) for omega in (run.omega_rad_s, gait.omega_rad_s)]
    text = f"the film shows {hertz[0]:.4g} Hz, commanded were {hertz[1]:.4g} Hz"
    if ratio > 1.5:
        return (
            f"{text}: is it slow motion, {ratio:.2g} times? Give the run's recording with "
            "--recording, and the times are put right; speeds are those of the file"
        )
    return f"{text}: the robot did not run that gait, or the file's times are wrong"


RUN: tuple[Check[Ran], ...] = (
    Check(
        "phases",
        lambda ran: _explained(ran)[2],
        lambda ran, rest: (
            f"the joints' phases are no even steps ({math.degrees(rest):.0f}° off): plugs of "
            "several servos may be swapped"
        ),
        EXPLAINED_RAD,
    ),
    Check(
        "plugs",
        lambda ran: len(_explained(ran)[0]),
        lambda ran, _: (
            f"joints {' and '.join(map(str, _explained(ran)[0]))} move as if their plugs were "
            "swapped: swap them back"
        ),
        0.0,
    ),
    Check(
        "sense",
        lambda ran: len(_explained(ran)[1]),
        lambda ran, _: "; ".join(
            f"joint {k + 1} moves the wrong way round: set its trim's sense to the other sign"
            for k in _explained(ran)[1]
        ),
        0.0,
    ),
    Check(
        "centre", lambda ran: len(_off_centre(ran)), lambda ran, _: "; ".join(_off_centre(ran)), 0.0
    ),
    Check("rate", _rate_off, _rate_words, 1.0),
)


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
