"""What measured speeds say: they agree, or friction, the joints' amplitude or neither is to blame.

Whether they agree is told by draws of what fit, amplitude and servos allow as stated. If not, each
cause is let loose alone and solved for; a cause is able if its best speeds then fit, and two able
ones are told apart by their evidence (Laplace's approximation: a cause that could have explained
anything is worth less than one that had to).
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..model.drives import Servo, ServoKind
from ..model.gait import Gait
from .friction_result import FrictionFit, ground_of
from .speed_samples import SpeedSamples, sample_speeds, scaled, speed

Array = NDArray[np.float64]
DOUBTFUL = 0.05  # a verdict's p-value
# What may have happened between treadmill and ground: standard deviation of the logarithm of each
# friction, and of the joints' amplitude, in those stated (who has measured it states a small one).
FREED_FRICTION, FREED_AMPLITUDE = 0.4, 5.0
MODEL_SIGMA = 0.01  # of the predicted speed: what the model itself may be off by
EITHER = "friction or amplitude"
FREED_SERVOS = "hobby"  # what servos may be, where those stated do not explain the speeds
_SERVO_DRAWS = 128
TOLD_APART = math.log(10.0)  # of evidence
_LEAST_PULL = 2e-3  # of the weight: a tenth of a degree
_NOISE_DRAWS = 32
_STEP = 0.05  # of an unknown, in its sigmas, for slopes
_STARTS, _SHARES = 256, 15  # frictions to begin at; shares of the amplitude
_MOST_STEPS = 10


@dataclass(frozen=True)
class Measured:
    """Mean speeds of the gaits that were run, and their standard deviations, m/s."""

    gaits: tuple[Gait, ...]
    speed_m_s: Array
    sigma_m_s: Array


@dataclass(frozen=True)
class Cause:
    """One cause let loose: the chance of what is then left over, its evidence (a logarithm), and
    what it takes: per friction its share of the fitted one, and the joints' of their amplitude."""

    p_value: float
    evidence: float
    frictions: dict[str, float]
    amplitude: float


@dataclass(frozen=True)
class Verdict:
    """word: agrees, neither, or the causes: friction, amplitude, servos, with `or` between them.

    p_value: as stated; friction, amplitude: that cause let loose, looked at only where the speeds
    do not agree.
    """

    word: str
    p_value: float
    friction: Cause | None = None
    amplitude: Cause | None = None
    servos: Cause | None = None


def of_gaits(drawn: SpeedSamples, index: Sequence[int]) -> SpeedSamples:
    """Return the draws of some of the gaits."""
    own = list(index)
    return replace(
        drawn, gaits=tuple(drawn.gaits[j] for j in own),
        friction_m_s=drawn.friction_m_s[:, own], both_m_s=drawn.both_m_s[:, own],
    )  # fmt: skip


class Judge:
    """Judges measured speeds of some gaits; what that takes is solved for once, when it is needed.

    drawn: of these very gaits, as fit, amplitude_sigma and servo allow. servo: the kind of servo
    that moves the joints; None: they follow the gait, and servos are no cause.
    """

    def __init__(
        self,
        fit: FrictionFit,
        drawn: SpeedSamples,
        amplitude_sigma: float,
        seed: int,
        servo: ServoKind | None = None,
    ):
        self._drawn, self._seed, self._fit = drawn, seed, fit
        sigma, freed = max(amplitude_sigma, 1e-6), FREED_AMPLITUDE * max(amplitude_sigma, 1e-6)
        self._amplitude_sigma = sigma
        self._as_stated = _Loose(fit, drawn.gaits, 0.0, sigma, servo)
        self._amplitude = _Loose(fit, drawn.gaits, 0.0, freed, servo)
        self._friction = _Loose(fit, drawn.gaits, FREED_FRICTION, sigma, servo)
        self._servo = servo

    def __call__(self, measured: Measured) -> Verdict:
        """Return the verdict on speeds of the gaits drawn."""
        stated = _chance(self._drawn.both_m_s, measured, np.random.default_rng(self._seed))
        if stated >= DOUBTFUL:
            return Verdict("agrees", stated)
        friction, amplitude = self._friction.cause(measured), self._amplitude.cause(measured)
        servos = None if self._servo is None else self._freed_servos(measured)
        word = _word(friction, amplitude, self._as_stated.cause(measured), servos)
        return Verdict(word, stated, friction, amplitude, servos)

    @cached_property
    def _by_servos_m_s(self) -> Array:
        from ..servos.catalogue import servo

        return sample_speeds(
            self._fit, self._drawn.gaits, amplitude_sigma=self._amplitude_sigma,
            servo=servo(FREED_SERVOS), count=_SERVO_DRAWS, seed=self._seed + 1,
        ).both_m_s  # fmt: skip

    def _freed_servos(self, measured: Measured) -> Cause:
        """Return what any servos can do: their best draw, and the mean likelihood of all."""
        from scipy.special import chdtrc, logsumexp

        speeds = self._by_servos_m_s
        noise = np.hypot(measured.sigma_m_s, MODEL_SIGMA * speeds.mean(axis=0))
        chi2 = np.sum(((speeds - measured.speed_m_s) / noise) ** 2, axis=1)
        evidence = float(np.asarray(logsumexp(-0.5 * chi2))) - math.log(len(chi2))
        return Cause(float(chdtrc(speeds.shape[1], chi2.min())), evidence, {}, 1.0)


def _word(friction: Cause, amplitude: Cause, as_stated: Cause, servos: Cause | None = None) -> str:
    """Name the cause, all those of which none is better than another or than mere bad luck."""
    able = {"friction": friction, "amplitude": amplitude}
    able |= {"servos": servos} if servos else {}
    able = {name: cause for name, cause in able.items() if cause.p_value >= DOUBTFUL}
    if not able:
        return "neither"
    best = max(cause.evidence for cause in able.values())
    if as_stated.evidence > best - TOLD_APART:
        return EITHER
    return " or ".join(n for n, cause in able.items() if cause.evidence > best - TOLD_APART)


def _chance(speeds: Array, measured: Measured, rng: np.random.Generator) -> float:
    """Return how often a draw with its measuring noise lies as far out as what was measured.

    How far is told by the draws' own covariance; how often, by the draws themselves, since they
    are skewed.
    """
    seen = np.repeat(speeds, _NOISE_DRAWS, axis=0)
    seen = seen + measured.sigma_m_s * rng.normal(size=seen.shape)
    centre, count = seen.mean(axis=0), seen.shape[1]
    inverse = np.linalg.inv(np.cov(seen.T).reshape(count, count))

    def out(v: Array) -> Array:
        return np.einsum("...i,ij,...j->...", v - centre, inverse, v - centre)

    return float(np.mean(out(seen) >= out(measured.speed_m_s)))


class _Loose:
    """Speeds over whitened unknowns: the logarithms of all frictions, and the amplitude last."""

    def __init__(
        self, fit: FrictionFit, gaits: tuple[Gait, ...], freed: float, amplitude_sigma: float,
        servo: ServoKind | None = None,
    ):  # fmt: skip
        self._fit, self._gaits, self._freed = fit, gaits, freed
        self._servo = servo
        self._amplitude_sigma = amplitude_sigma
        self._whole = np.maximum(list(fit.whole_snake.values()), 1e-9)
        relative = fit.covariance / np.outer(self._whole, self._whole)
        self._root = np.linalg.cholesky(relative + freed**2 * np.eye(len(relative)))

    @cached_property
    def _starts(self) -> tuple[Array, Array]:
        """Return unknowns all over, and the speeds there; the one that is nearest is begun at.

        Speeds end in a cliff, from whose foot nothing leads back.
        """
        from scipy.special import ndtri
        from scipy.stats import qmc

        if self._freed:
            sobol = qmc.Sobol(len(self._whole) + 1, seed=7)  # pyright: ignore[reportCallIssue]
            units = ndtri(sobol.random(_STARTS))
        else:
            units = np.zeros((_SHARES, len(self._whole) + 1))
            units[:, -1] = np.linspace(-2.5, 2.0, _SHARES)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return units, np.array(list(pool.map(self._speeds, units)))

    @cached_property
    def _best_m_s(self) -> Array:
        return self._speeds(np.zeros(len(self._whole) + 1))

    def cause(self, measured: Measured) -> Cause:
        """Return the best that these unknowns can do."""
        from scipy.optimize import least_squares
        from scipy.special import chdtrc

        model = np.hypot(MODEL_SIGMA, self._left_by_servos[1]) * self._best_m_s
        noise, count = np.hypot(measured.sigma_m_s, model), len(self._gaits)

        def left(x: Array) -> Array:
            return np.append((self._speeds(x) - measured.speed_m_s) / noise, x)

        def slopes(x: Array) -> Array:
            here = left(x)
            return np.array([left(x + s) - here for s in _STEP * np.eye(len(x))]).T / _STEP

        units, speeds = self._starts
        off = np.sum(((speeds - measured.speed_m_s) / noise) ** 2, axis=1)
        begin = units[int(np.argmin(off + np.sum(units**2, axis=1)))]
        found = least_squares(
            left, begin, ftol=1e-2, xtol=1e-2, max_nfev=_MOST_STEPS,
            jac=slopes,  # pyright: ignore[reportArgumentType]
        )  # fmt: skip
        best, chi2, at = found.x, 2.0 * float(found.cost), found.jac[:count]
        log_spread = float(np.linalg.slogdet(np.eye(count) + at @ at.T)[1])
        shares = np.exp(self._root @ best[:-1]).tolist()
        return Cause(
            float(chdtrc(count, chi2)), -0.5 * (chi2 + log_spread),
            dict(zip(self._fit.names, shares, strict=True)), self._amplitude(best),
        )  # fmt: skip

    def _amplitude(self, x: Array) -> float:
        return float(np.clip(1.0 + self._amplitude_sigma * x[-1], 0.05, 1.5))

    def _speeds(self, x: Array) -> Array:
        whole = (self._whole * np.exp(np.clip(self._root @ x[:-1], -3.0, 3.0))).tolist()
        robot, share = self._fit.robot, self._amplitude(x)
        ground = ground_of(robot.links, whole)
        ideal = np.array([speed(robot, ground, scaled(g, share)) for g in self._gaits])
        return ideal * self._left_by_servos[0]

    @cached_property
    def _left_by_servos(self) -> tuple[Array, Array]:
        """Return the share of each ideal speed that servos leave, and its relative sigma."""
        count = len(self._gaits)
        if self._servo is None:
            return np.ones(count), np.zeros(count)
        servos = [self._servo.servo, *self._servo.draws(_SERVO_DRAWS // 4)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            found = np.array(list(pool.map(self._shares, servos)))
        return found[0], found[1:].std(axis=0) / np.maximum(found[1:].mean(axis=0), 1e-3)

    def _shares(self, servo: Servo) -> list[float]:
        robot, ground = self._fit.robot, self._fit.ground
        pairs = [(speed(robot, ground, g, servo), speed(robot, ground, g)) for g in self._gaits]
        return [moved / max(ideal, 1e-9) for moved, ideal in pairs]


def in_words(
    verdict: Verdict, measured: Measured, fit: FrictionFit, amplitude_sigma: float, weight_n: float,
    servo: ServoKind | None = None,
) -> str:  # fmt: skip
    """Return what was found and what to do about it."""
    typical = None if servo is None else servo.servo
    best = np.array([speed(fit.robot, fit.ground, g, typical) for g in measured.gaits])
    share = np.divide(measured.speed_m_s, best, out=np.full_like(best, np.inf), where=best > 0.0)
    worst = int(np.argmax(np.abs(share - 1.0)))
    hz = measured.gaits[worst].omega_rad_s / (2 * math.pi)
    seen = f"at most {share[worst] - 1.0:+.1%} of the predicted speed, at {hz:.3g} Hz"
    if verdict.word == "agrees":
        named = "" if servo is None else f" with servos ({servo.name})"
        how = f"{seen}; {_p(verdict.p_value)}"
        return f"Agrees: the robot runs as its friction{named} predicts ({how})."
    told = f"Differs: {seen} ({_p(verdict.p_value)}). " + _blame(verdict, amplitude_sigma)
    if verdict.word == "friction" and verdict.friction is not None:
        told += _slope(verdict.friction, fit.whole_snake["ft0"] / weight_n)
    return told + _common(share, measured, best)


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
        "first: it is the quickest of the two."
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


def _common(share: Array, measured: Measured, best: Array) -> str:
    """Say so where all speeds are off by one factor, as a tape or a clock makes them."""
    if len(share) < 2 or not np.isfinite(share).all():
        return ""
    weights = (np.hypot(measured.sigma_m_s / best, MODEL_SIGMA)) ** -2.0
    factor = float(weights @ share / weights.sum())
    if float(weights @ (share - factor) ** 2) > 4.0 * (len(share) - 1) or abs(factor - 1.0) < 0.02:
        return ""
    return f" All speeds are {factor - 1.0:+.0%} off: check tape, stopwatch and rate, too."
