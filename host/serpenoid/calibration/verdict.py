"""What measured speeds say: they agree, or friction, the joints' amplitude or neither is to blame.

Whether they agree is told by draws of what fit, amplitude and servos allow as stated. If not, each
cause is let loose alone and solved for; a cause is able if its best speeds then fit, and two able
ones are told apart by their evidence (Laplace's approximation: a cause that could have explained
anything is worth less than one that had to).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..model.drives import ServoKind
from ..model.gait import Gait
from ..periodic.drawn_states import drawn_speeds
from ..periodic.servo_steady import drawn_ripple_shares, drawn_servo_speeds
from ..periodic.steady import steady_gait
from ..servos.catalogue import servo
from .friction_result import FrictionFit, ground_of
from .speed_samples import SpeedSamples, scaled

Array = NDArray[np.float64]
DOUBTFUL = 0.05  # a verdict's p-value
# What may have happened between treadmill and ground: standard deviation of the logarithm of each
# friction, and of the joints' amplitude, in those stated (who has measured it states a small one).
FREED_FRICTION, FREED_AMPLITUDE = 0.4, 5.0
MODEL_SIGMA = 0.01  # of the predicted speed: what the model itself may be off by
EITHER = "friction or amplitude"
# What servos may be, where those stated do not explain the speeds: any hobby servo, and such as
# lose so many times as much.
FREED_SERVOS, STRANGER, _SERVO_DRAWS = "hobby", 2.0, 48
_LESS, _LEAST_SHARE = 0.85, 1e-3  # amplitude at which shares are looked at once more; a share
_GRAIN = 0.01  # of the speed: how far servos are apart of which some are drawn
TOLD_APART = math.log(10.0)  # of evidence
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
        drawn,
        gaits=tuple(drawn.gaits[j] for j in own),
        friction_m_s=drawn.friction_m_s[:, own],
        joints_m_s=drawn.joints_m_s[:, own],
        both_m_s=drawn.both_m_s[:, own],
    )


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

    def __call__(self, measured: Measured) -> Verdict:
        """Return the verdict on speeds of the gaits drawn."""
        stated = _chance(self._drawn, measured, np.random.default_rng(self._seed))
        if stated >= DOUBTFUL:
            return Verdict("agrees", stated)
        loose = self._loose
        friction, amplitude = (loose[name].cause(measured) for name in ("friction", "amplitude"))
        servos = loose["servos"].cause(measured) if "servos" in loose else None
        word = _word(friction, amplitude, loose["nothing"].cause(measured), servos)
        return Verdict(word, stated, friction, amplitude, servos)

    @cached_property
    def _loose(self) -> dict[str, _Loose]:
        """Return what is solved for where one thing is let loose."""
        fit, sigma = self._fit, self._amplitude_sigma
        gaits, seen = self._drawn.gaits, self._drawn.seen
        stated = self._left_by(self._servo)
        found = {
            "nothing": _Loose(fit, gaits, 0.0, sigma, stated, seen),
            "amplitude": _Loose(fit, gaits, 0.0, FREED_AMPLITUDE * sigma, stated, seen),
            "friction": _Loose(fit, gaits, FREED_FRICTION, sigma, stated, seen),
        }
        if self._servo is not None:
            any_kind = servo(FREED_SERVOS)
            freed = stated if self._servo == any_kind else self._left_by(any_kind)
            found["servos"] = _Loose(fit, gaits, 0.0, sigma, freed.and_stranger(), seen)
        return found

    def _left_by(self, kind: ServoKind | None) -> _Left:
        """Return what servos of a kind leave of the speeds, on the fitted ground."""
        gaits, fit = self._drawn.gaits, self._fit
        if kind is None:
            return _Left(np.ones((1, len(gaits))), np.zeros((1, len(gaits))))
        servos = [kind.servo] if kind.exact else kind.draws(_SERVO_DRAWS)
        shares = [np.empty((len(servos), len(gaits))) for _ in range(2)]
        for j, gait in enumerate(gaits):
            if (command := self._drawn.seen.get(gait)) is not None:
                state = steady_gait(fit.robot, fit.ground, command, rtol=1e-3, powers=False)
                left = drawn_ripple_shares([state] * len(servos), servos)
                shares[0][:, j] = shares[1][:, j] = np.maximum(left, _LEAST_SHARE)
                continue
            for found, amplitude in zip(shares, (1.0, _LESS), strict=True):
                made = scaled(gait, amplitude)
                state = steady_gait(fit.robot, fit.ground, made, rtol=1e-3, powers=False)
                speeds = drawn_servo_speeds([state] * len(servos), servos)
                found[:, j] = np.maximum(speeds / max(state.speed_m_s, 1e-9), _LEAST_SHARE)
        return _Left(shares[0], np.log(shares[1] / shares[0]) / (_LESS - 1.0))


@dataclass(frozen=True)
class _Left:
    """What each of some servos leaves of ideal speeds: shares (K, gaits), and how the logarithm
    of each changes with the joints' amplitude, a share of the commanded one."""

    shares: Array
    by_amplitude: Array

    def at(self, amplitude: float) -> Array:
        return self.shares * np.exp(self.by_amplitude * (amplitude - 1.0))

    def and_stranger(self) -> _Left:
        return _Left(
            np.vstack([self.shares, self.shares**STRANGER]),
            np.vstack([self.by_amplitude, STRANGER * self.by_amplitude]),
        )


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


def _chance(drawn: SpeedSamples, measured: Measured, rng: np.random.Generator) -> float:
    """Return how often a draw with its measuring noise is as unlikely as what was measured.

    How likely is told by a normal cloud of frictions and amplitude about each drawn servo; how
    often, by the draws themselves, since they are skewed. A draw is judged by the clouds of all
    other servos, as the robot is, whose own servo was not drawn.
    """
    from scipy.special import logsumexp

    seen = np.repeat(drawn.both_m_s, _NOISE_DRAWS, axis=0)
    seen = seen + measured.sigma_m_s * rng.normal(size=seen.shape)
    shares, own = np.unique(drawn.shares, axis=0, return_inverse=True)
    centre, count = drawn.joints_m_s.mean(axis=0), len(drawn.gaits)
    spread = np.cov(drawn.joints_m_s.T).reshape(count, count)
    noise = np.diag(measured.sigma_m_s**2 + (_grain(shares) * centre) ** 2)
    each = shares[:, :, None] * spread * shares[:, None, :] + noise
    inverse, log_volume = np.linalg.inv(each), np.linalg.slogdet(each)[1]
    centres = shares * centre

    def by_servo(v: Array) -> Array:
        off = v[:, None, :] - centres
        return -0.5 * (np.einsum("ski,kij,skj->sk", off, inverse, off) + log_volume)

    likely = by_servo(seen)
    if len(shares) > 1:
        likely[np.arange(len(seen)), np.repeat(own.ravel(), _NOISE_DRAWS)] = -np.inf
        likely -= math.log(len(shares) - 1)
    robot = by_servo(measured.speed_m_s[None]) - math.log(len(shares))
    return float(np.mean(logsumexp(likely, axis=1) <= logsumexp(robot)))


def _grain(shares: Array) -> float:
    return _GRAIN if len(shares) > 1 else 0.0


class _Loose:
    """Speeds over whitened unknowns, the logarithms of all frictions and the amplitude last.

    servos: what each of some leaves of them; one of these servos it is.
    """

    def __init__(
        self,
        fit: FrictionFit,
        gaits: tuple[Gait, ...],
        freed: float,
        amplitude_sigma: float,
        servos: _Left,
        seen: Collection[Gait] = (),
    ):
        self._fit, self._gaits, self._freed, self._seen = fit, gaits, freed, seen
        self._servos = servos
        self._amplitude_sigma = amplitude_sigma
        self._whole = np.maximum(list(fit.whole_snake.values()), 1e-9)
        relative = fit.covariance / np.outer(self._whole, self._whole)
        self._root = np.linalg.cholesky(relative + freed**2 * np.eye(len(relative)))

    @cached_property
    def _starts(self) -> tuple[Array, Array]:
        """Return unknowns all over, and the ideal speeds there; the nearest one is begun at.

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
        return units, self._ideals(units, rough=True)

    @cached_property
    def _best_m_s(self) -> Array:
        ideal = self._ideal(np.zeros(len(self._whole) + 1))
        return ideal * np.median(self._servos.shares, axis=0)

    def cause(self, measured: Measured) -> Cause:
        """Return the best that these unknowns can do."""
        from scipy.special import chdtrc

        error = math.hypot(MODEL_SIGMA, _grain(self._servos.shares))
        noise = np.hypot(measured.sigma_m_s, error * self._best_m_s)
        units, speeds = self._starts
        left = np.array([self._servos.at(self._amplitude(x)) for x in units]).swapaxes(0, 1)
        off = (left * speeds - measured.speed_m_s) / noise
        far = np.sum(off**2, axis=2) + np.sum(units**2, axis=1)
        one, begin = np.unravel_index(int(np.argmin(far)), far.shape)
        found, chi2, at = self._closest(measured, noise, int(one), units[begin])
        likely = self._likely(measured, noise, found, at)
        if (other := int(np.argmax(likely))) != one:
            again = self._closest(measured, noise, other, found)
            if again[1] < chi2:
                found, chi2, at = again
                likely = self._likely(measured, noise, found, at)
        shares = np.exp(self._root @ found[:-1]).tolist()
        return Cause(
            float(chdtrc(len(self._gaits), chi2)),
            _mean_of_logs(likely),
            dict(zip(self._fit.names, shares, strict=True)),
            self._amplitude(found),
        )

    def _closest(
        self, measured: Measured, noise: Array, one: int, begin: Array
    ) -> tuple[Array, float, Array]:
        """Return the best unknowns with one of the servos, chi2, and the ideal speeds' slopes."""
        from scipy.optimize import least_squares

        def all_left(units: Array) -> Array:
            shares = np.array([self._servos.at(self._amplitude(x))[one] for x in units])
            off = (shares * self._ideals(units) - measured.speed_m_s) / noise
            return np.hstack([off, units])

        def left(x: Array) -> Array:
            return all_left(x[None])[0]

        def slopes(x: Array) -> Array:
            here, *moved = all_left(x + _STEP * np.eye(len(x) + 1, len(x), -1))
            return (np.array(moved) - here).T / _STEP

        found = least_squares(
            left,
            begin,
            ftol=1e-2,
            xtol=1e-2,
            max_nfev=_MOST_STEPS,
            jac=slopes,  # pyright: ignore[reportArgumentType]
        )
        x = found.x
        share, bends = self._servos.at(self._amplitude(x))[one], self._servos.by_amplitude[one]
        at = found.jac[: len(noise)] * (noise / share)[:, None]  # of the ideal speeds
        at[:, -1] -= self._ideal(x) * bends * self._amplitude_sigma
        return x, 2.0 * float(found.cost), at

    def _likely(self, measured: Measured, noise: Array, x: Array, slopes: Array) -> Array:
        """Return the logarithm of each servo's likelihood, all unknowns integrated out.

        Speeds are linear about x; likelihoods are over that of no residual without unknowns.
        """
        here, share = self._ideal(x), self._servos.at(self._amplitude(x))
        own = np.repeat(slopes[None], len(share), axis=0)
        own[:, :, -1] += here * self._servos.by_amplitude * self._amplitude_sigma
        own *= share[:, :, None]
        each = own @ own.swapaxes(1, 2) + np.diag(noise**2)
        off = measured.speed_m_s - share * here + own @ x
        out = np.einsum("ki,kij,kj->k", off, np.linalg.inv(each), off)
        return -0.5 * (out + np.linalg.slogdet(each)[1] - np.log(noise**2).sum())

    def _amplitude(self, x: Array) -> float:
        return float(np.clip(1.0 + self._amplitude_sigma * x[-1], 0.05, 1.5))

    def _ideal(self, x: Array) -> Array:
        return self._ideals(x[None])[0]

    def _ideals(self, units: Array, rough: bool = False) -> Array:
        """Return the speeds of all gaits at some unknowns, (K, gaits), m/s."""
        whole = self._whole * np.exp(np.clip(units[:, :-1] @ self._root.T, -3.0, 3.0))
        robot, shares = self._fit.robot, [self._amplitude(x) for x in units]
        grounds = [ground_of(robot.links, row) for row in whole.tolist()]

        def of(gait: Gait) -> Array:
            made = [gait if gait in self._seen else scaled(gait, share) for share in shares]
            draws = list(zip(grounds, made, strict=True))
            return drawn_speeds(robot, draws[0], draws, rough)

        return np.array([of(gait) for gait in self._gaits]).T


def _mean_of_logs(likely: Array) -> float:
    from scipy.special import logsumexp

    return float(np.asarray(logsumexp(likely))) - math.log(len(likely))
