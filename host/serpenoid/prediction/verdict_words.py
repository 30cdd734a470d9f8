"""A verdict in words: what was found, and what to do about it."""

from __future__ import annotations

import math

import numpy as np

from ..calibration.crawls.data import CrawlData
from ..calibration.friction_result import FrictionFit
from ..calibration.speeds import MODEL_SIGMA, Array, speed
from ..model.drives import ServoKind
from .verdict import Cause, Verdict

_LEAST_PULL = 2e-3  # of the weight: a tenth of a degree


def in_words(
    verdict: Verdict,
    measured: CrawlData,
    fit: FrictionFit,
    amplitude_sigma: float,
    weight_n: float,
    servo: ServoKind | None = None,
) -> str:
    """Return what was found and what to do about it."""
    typical = None if servo is None else servo.servo
    best = np.array([speed(fit.robot, fit.ground, g, typical) for g in measured.gaits])
    share = np.divide(measured.speed_m_s, best, out=np.full_like(best, np.inf), where=best > 0.0)
    worst = int(np.argmax(np.abs(share - 1.0)))
    hz = measured.gaits[worst].omega_rad_s / (2 * math.pi)
    joints = "ideal joints" if servo is None else "typical servos"
    off_by = f"off the speed with {joints} by {share[worst] - 1.0:+.1%} at most, at {hz:.3g} Hz"
    if verdict.word == "agrees":
        named = "" if servo is None else f" with servos ({servo.name})"
        how = f"{off_by}; {_p(verdict.p_value)}"
        return f"Agrees: the robot runs as its friction{named} predicts ({how})."
    text = f"Differs: {off_by} ({_p(verdict.p_value)}). " + _blame(verdict, amplitude_sigma)
    if verdict.word == "friction" and verdict.friction is not None:
        text += _slope(verdict.friction, fit.whole_snake["ft0"] / weight_n)
    return text + _common(share, measured, best)


def _blame(verdict: Verdict, amplitude_sigma: float) -> str:
    friction, amplitude = verdict.friction, verdict.amplitude
    if verdict.word == "neither" or friction is None or amplitude is None:
        servos = ", nor the servos" if verdict.servos else ""
        return (
            f"Neither friction nor the joints' amplitude{servos} explains it: look at the surface, "
            "the mass, the frequency, the gait itself."
        )
    if "servos" in verdict.word:
        return _blame_servos(verdict)
    reached = f"{amplitude.amplitude:.0%} of the commanded one"
    if verdict.word == "friction":
        return (
            f"The data say that it is friction, not amplitude: {_friction(friction)}. Take the "
            "friction again, on the surface that the robot crawls on."
        )
    if verdict.word == "amplitude":
        return (
            f"The data say that it is amplitude, not friction: as if the joints reached {reached}. "
            f"Measure them: {amplitude_sigma:.0%} was stated."
        )
    return (
        f"Friction ({_friction(friction)}) or the joints' amplitude ({reached}) may be to blame; "
        "these runs cannot tell which. Measure the joints' amplitude, or run more, at other rates."
    )


def _blame_servos(verdict: Verdict) -> str:
    if verdict.word == "servos":
        return (
            "The data say that it is the servos: others than those stated would run the gait so. "
            "Measure one of them, or give `--servo hobby`."
        )
    others = verdict.word.removesuffix(" or servos")
    return (
        f"The servos or {others} may be to blame; these runs cannot tell which. Measure a servo "
        "first: that is the quickest."
    )


def _p(chance: float) -> str:
    least = 1e-3  # as many draws can tell
    return "p < 0.001" if chance < least else f"p = {chance:.2g}"


def _friction(cause: Cause) -> str:
    """Return the frictions that would do it; speeds tell their sum, hardly each."""
    off = {n: share - 1.0 for n, share in cause.frictions.items() if n in ("ft0", "fn0")}
    return "as with " + ", ".join(f"{name} {by:+.0%}" for name, by in off.items()) + " or the like"


def _slope(cause: Cause, ft0_share: float) -> str:
    """Return the slope that would pull as much as ft0 is off; ft0_share: of the weight."""
    pull = ft0_share * (cause.frictions["ft0"] - 1.0)
    if abs(pull) < _LEAST_PULL:
        return ""
    way = "uphill" if pull > 0.0 else "downhill"
    return f" {math.degrees(abs(pull)):.1f}° {way} would pull as much: level the ground first."


def _common(share: Array, measured: CrawlData, best: Array) -> str:
    """Say so where all speeds are off by one factor, as a tape or a clock makes them."""
    if len(share) < 2 or not np.isfinite(share).all():
        return ""
    weights = (np.hypot(measured.sigma_m_s / best, MODEL_SIGMA)) ** -2.0
    factor = float(weights @ share / weights.sum())
    if float(weights @ (share - factor) ** 2) > 4.0 * (len(share) - 1) or abs(factor - 1.0) < 0.02:
        return ""
    return f" All speeds are {factor - 1.0:+.0%} off: check tape, stopwatch and rate, too."
