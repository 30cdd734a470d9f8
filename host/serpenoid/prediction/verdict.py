"""What measured speeds say: they agree, or friction, the joints' amplitude or neither is to blame.

Draws of what fit, amplitude and servos allow as stated show whether they agree. If not, the crawls
are a reading that was not fitted, beside a fit in which one cause is freed. A cause is able if its
likeliest speeds fit. Two able causes are told apart by evidence: a cause that could have explained
anything is worth less than one that had to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ..calibration.crawls.data import CrawlData, servos_of
from ..calibration.crawls.posterior import Beforehand, CrawlPosterior
from ..calibration.fitting.posterior import Posterior
from ..calibration.friction_result import FrictionFit
from ..calibration.speeds import MODEL_SIGMA, Array, ServoEffects, SpeedModel, SpeedTable
from ..model.drives import ServoKind
from ..servos.catalogue import servo
from .speed_samples import SpeedSamples

DOUBTFUL = 0.05  # a verdict's p-value
_LEAST_SIGMAS = 0.3  # a friction is as if it were so many standard deviations at least
# What may have happened between treadmill and ground: standard deviation of the logarithm of each
# friction, and of the joints' amplitude, in those stated (who has measured it states a small one).
FREED_FRICTION, FREED_AMPLITUDE = 0.4, 5.0
EITHER = "friction or amplitude"
# What servos may be, where those stated do not explain the speeds: any hobby servo, and such as
# lose so many times as much.
FREED_SERVOS, STRANGER = "hobby", 2.0
TOLD_APART = math.log(10.0)  # of evidence
_NOISE_DRAWS, _SERVO_DRAWS = 32, 48
_DRAWS = 512  # of what may be where a cause is let loose
_AMPLITUDES = 0.85, 1.0  # shares of the joints' amplitude, at which servos are looked at
_GRAIN = 0.01  # of the speed: how far servos are apart of which some are drawn


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

    @property
    def causes(self) -> dict[str, Cause | None]:
        """Return the causes by name."""
        names = ("friction", "amplitude", "servos")
        return {name: getattr(self, name) for name in names}


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
        self._amplitude_sigma = max(amplitude_sigma, 1e-6)
        self._servo = servo
        sigma = np.sqrt(np.diag(fit.covariance))
        whole = np.array(list(fit.whole_snake.values()))
        self._whole = np.maximum(whole, np.maximum(_LEAST_SIGMAS * sigma, 1e-9))

    def __call__(self, measured: CrawlData) -> Verdict:
        """Return the verdict on speeds of the gaits drawn."""
        stated = _chance(self._drawn, measured, np.random.default_rng(self._seed))
        if stated >= DOUBTFUL:
            return Verdict("agrees", stated)
        sigma, as_stated = self._amplitude_sigma, self._effects
        nothing = self._cause(measured, 0.0, sigma, as_stated)
        friction = self._cause(measured, FREED_FRICTION, sigma, as_stated)
        amplitude = self._cause(measured, 0.0, FREED_AMPLITUDE * sigma, as_stated)
        servos = self._servo and self._cause(measured, 0.0, sigma, self._freed_effects)
        word = _word(friction, amplitude, nothing, servos)
        return Verdict(word, stated, friction, amplitude, servos)

    def _cause(
        self, measured: CrawlData, freed: float, amplitude_sigma: float, effects: ServoEffects
    ) -> Cause:
        """Return the best that frictions, freed or not, amplitude and servos can do."""
        from scipy.special import chdtrc

        whole = self._whole
        relative = self._fit.covariance / np.outer(whole, whole)
        # of a friction that may be 0 the logarithm scatters less than its share
        shrunk = np.sqrt(np.log1p(np.diag(relative)) / np.maximum(np.diag(relative), 1e-300))
        of_logs = relative * np.outer(shrunk, shrunk)
        root = np.linalg.cholesky(of_logs + freed**2 * np.eye(len(whole)))
        known = Beforehand(np.log(whole), np.asarray(root, dtype=np.float64))
        best_m_s = self._model.ideal(whole[None], np.ones(1))[0] * np.median(effects.share, axis=0)
        sigma = np.hypot(measured.sigma_m_s, math.hypot(MODEL_SIGMA, effects.sigma) * best_m_s)
        # a film's joints count in the gait itself, not once more
        effects = replace(effects, sigma=0.0, amplitude=effects.amplitude[:, :0], amplitude_power=0)
        posterior = CrawlPosterior(
            Posterior((known,)),
            replace(measured, sigma_m_s=sigma),
            SpeedTable(partial(self._model.ideal, unfound_m_s=np.nan)),
            effects,
            amplitude_sigma,
        )
        u = np.random.default_rng(self._seed).normal(size=(_DRAWS, len(whole)))
        drawn = posterior.draw(known.whole(u), self._seed)
        shares = (drawn.best_whole / whole).tolist()
        return Cause(
            float(chdtrc(len(measured), drawn.chi2)),
            drawn.evidence - float(np.log(sigma).sum()),
            dict(zip(self._fit.names, shares, strict=True)),
            drawn.best_amplitude,
        )

    @cached_property
    def _model(self) -> SpeedModel:
        gaits, seen = self._drawn.gaits, self._drawn.seen
        return SpeedModel(self._fit.robot, self._fit.ground, gaits, tuple(map(seen.get, gaits)))

    @cached_property
    def _effects(self) -> ServoEffects:
        """Return what servos as stated do to the speeds, on the fitted ground."""
        return self._model.effects(servos_of(self._servo, _SERVO_DRAWS), _AMPLITUDES)

    @cached_property
    def _freed_effects(self) -> ServoEffects:
        """Return what any hobby servo does to them, and one that loses more."""
        any_kind, kinds = servo(FREED_SERVOS), self._effects
        if self._servo != any_kind:
            kinds = self._model.effects(servos_of(any_kind, _SERVO_DRAWS), _AMPLITUDES)
        lossy = np.asarray(kinds.share_power) * STRANGER
        return kinds.beside(replace(kinds, share=kinds.share**STRANGER, share_power=lossy))


def _word(friction: Cause, amplitude: Cause, as_stated: Cause, servos: Cause | None = None) -> str:
    """Name the cause, all those of which none is better than another or than mere bad luck."""
    able = {"friction": friction, "amplitude": amplitude}
    able |= {"servos": servos} if servos else {}
    able = {name: cause for name, cause in able.items() if cause.p_value >= DOUBTFUL}
    if not able:
        return "neither"
    best = max(cause.evidence for cause in able.values())
    if as_stated.evidence > best - TOLD_APART:
        return EITHER if servos is None else f"{EITHER} or servos"
    return " or ".join(n for n, cause in able.items() if cause.evidence > best - TOLD_APART)


def _chance(drawn: SpeedSamples, measured: CrawlData, rng: np.random.Generator) -> float:
    """Return how often a draw with its measuring noise is as unlikely as what was measured.

    How likely is told by a normal cloud of frictions and amplitude about each drawn servo; how
    often, by the draws themselves, since they are skewed. A draw is judged by the clouds of all
    other servos, as the robot is, whose own servo was not drawn.
    """
    simulated = np.repeat(drawn.both_m_s, _NOISE_DRAWS, axis=0)
    simulated = simulated + measured.sigma_m_s * rng.normal(size=simulated.shape)
    shares, servo = np.unique(drawn.shares, axis=0, return_inverse=True)
    centre, count = drawn.joints_m_s.mean(axis=0), len(drawn.gaits)
    spread = np.cov(drawn.joints_m_s.T).reshape(count, count)
    noise = np.diag(measured.sigma_m_s**2 + (_grain(shares) * centre) ** 2)
    each = shares[:, :, None] * spread * shares[:, None, :] + noise
    inverse, log_volume = np.linalg.inv(each), np.linalg.slogdet(each)[1]
    centres = shares * centre

    def by_servo(v: Array) -> Array:
        off = v[:, None, :] - centres
        return -0.5 * (np.einsum("ski,kij,skj->sk", off, inverse, off) + log_volume)

    likely = by_servo(simulated)
    if len(shares) > 1:
        likely[np.arange(len(simulated)), np.repeat(servo.ravel(), _NOISE_DRAWS)] = -np.inf
        likely -= math.log(len(shares) - 1)
    robot = by_servo(measured.speed_m_s[None]) - math.log(len(shares))
    as_likely = np.logaddexp.reduce(likely, axis=1) <= np.logaddexp.reduce(robot, axis=1)
    return float(np.mean(as_likely))


def _grain(shares: Array) -> float:
    return _GRAIN if len(shares) > 1 else 0.0
