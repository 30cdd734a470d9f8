"""The kept readings of a session as arrays, with the errors that they have alone and in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..kinds.coast import Coast
from ..kinds.slide import Slide
from ..kinds.station import Reading
from ..session import Session
from .rounding import DRAWS, Drift, drifting_rounding, shared_rounding
from .shared import rolling_share, straightness_factors
from .tracks import Tracks

Floats = NDArray[np.float64]
Whole = NDArray[np.intp]

# Taken where a set-up claims a zero without error: an undeclared 0.1 degrees would leave ft0's 95 %
# interval with 17 % coverage, so that the prior is never absent.
ZERO_SIGMA_RAD = math.radians(0.1)
# How far the errors of two bends go together. They are set one by one, but by the same protractor
# and servos. Taken for independent (0), cn's interval covers 90 % if they are all the same; taken
# for half the same, 90 % if they are independent; with a quarter it covers 93 to 97 % either way.
TOGETHER = 0.25
_SAME_RAD = math.radians(1e-3)  # a bend written down with four decimals


@dataclass(frozen=True)
class FitData:
    """The kept readings, and which of them share an error.

    lambda_rad, bent_share (of the links, 0 where straight), incline_rad (as shown, less the zero
    where that was measured), slip_m_s, incline_sigma_rad (what is a reading's own),
    speed_sigma_m_s: per reading. posture: per reading, which of posture_sigma_rad's bends it was
    taken at; -1 when straight. rounding: per reading, which of rounding_sigma_rad's errors its
    incline has; -1 where that is its own. rounding_draws: (draws, errors) of these, in sigmas.
    zero_sigma_rad: per reading, of what is left of the inclinometer's zero, common to all. back:
    whether a reading's wheels rolled backwards, the snake facing up the belt. ratchet: there are
    readings of both ways, or were before some were left out. astray_rad, astray_sigma_rad: per
    reading, mean and standard deviation of the straight links' mean |angle| to the path, times
    their share. belt_sigma,
    mass_sigma: relative, of their scales. tracks: places of short readings, whose slip_m_s is the
    mean. inertia_n, inertia_sigma_n: per reading, the force that changes its speed, roughly, and
    its standard deviation; 0 where it was held.
    """

    lambda_rad: Floats
    bent_share: Floats
    incline_rad: Floats
    slip_m_s: Floats
    incline_sigma_rad: Floats
    speed_sigma_m_s: Floats
    posture: Whole
    back: NDArray[np.bool_]
    posture_lambda_rad: Floats
    posture_sigma_rad: Floats
    rounding: Whole
    rounding_sigma_rad: Floats
    rounding_draws: Floats
    weight_n: float
    zero_sigma_rad: Floats
    astray_rad: Floats
    astray_sigma_rad: Floats
    tracks: Tracks
    inertia_n: Floats
    inertia_sigma_n: Floats
    ratchet: bool = False
    belt_sigma: float = 0.0
    mass_sigma: float = 0.0

    @classmethod
    def of(cls, session: Session) -> FitData:
        """Take a session's kept readings."""
        kept = session.kept
        belt, belt_sigma = session.belt_scale
        given = [session.uncertainty_of(r) for r in kept]
        lambda_rad = np.array([r.lambda_rad for r in kept], dtype=float)
        lambda_sigma_rad = np.array([g.lambda_sigma_rad for g in given], dtype=float)
        posture, angles, sigmas = postures(lambda_rad, lambda_sigma_rad, settings(session, kept))
        steps = np.array([session.grade_step_of(r) for r in kept], dtype=float)
        zero_sigma_rad = np.array(session.zero_sigmas_rad(kept), dtype=float)
        shown_rad = np.array([r.incline_rad for r in kept], dtype=float)
        incline_sigma_rad = np.array([g.incline_sigma_rad for g in given], dtype=float)
        zeros_rad = np.array(session.zeros_rad(kept))
        share = np.array([session.bent_share(r) for r in kept], dtype=float)
        astray_rad, astray_sigma_rad = _astray(session, share)
        drift = Drift(zeros_rad, session.zero_drift_sigma_rad) if session.zero_drifts else None
        tracks = _tracks(session)
        inertia_n, inertia_sigma_n = tracks.inertia()
        rounding, sigma_rad, draws = roundings(shown_rad, incline_sigma_rad, steps, drift)
        return cls(
            lambda_rad=lambda_rad,
            bent_share=share,
            incline_rad=shown_rad - zeros_rad,
            slip_m_s=np.array([belt * r.belt_speed_m_s - r.drift_m_s for r in kept], dtype=float),
            incline_sigma_rad=np.where(rounding < 0, incline_sigma_rad, 0.0),
            speed_sigma_m_s=np.array([g.belt_speed_sigma_m_s for g in given], dtype=float),
            posture=posture,
            back=np.array([r.facing == "up" for r in kept], dtype=bool),
            posture_lambda_rad=angles,
            posture_sigma_rad=sigmas,
            rounding=rounding,
            rounding_sigma_rad=sigma_rad,
            rounding_draws=draws,
            weight_n=session.setup.weight_n,
            zero_sigma_rad=np.where(zero_sigma_rad > 0.0, zero_sigma_rad, ZERO_SIGMA_RAD),
            tracks=tracks,
            inertia_n=inertia_n,
            inertia_sigma_n=inertia_sigma_n,
            ratchet=any(r.facing == "up" for r in kept),
            astray_rad=astray_rad,
            astray_sigma_rad=astray_sigma_rad,
            belt_sigma=belt_sigma,
            mass_sigma=session.mass_sigma,
        )

    def __len__(self) -> int:
        return len(self.lambda_rad)

    @property
    def bent(self) -> NDArray[np.bool_]:
        """Tell which readings were taken with the robot bent."""
        return self.posture >= 0

    @property
    def parameters(self) -> int:
        """Return how many frictions there are to fit: ct, cn, ft0, fn0 (and ct, ft0 backwards).

        They come first among the unknowns.
        """
        return 6 if self.ratchet else 4

    def along(self, values: Floats) -> tuple[Floats, Floats]:
        """Return each reading's ct and ft0, of the way that its wheels roll."""
        if len(values) < 6 or not self.back.any():
            return np.full(len(self), values[0]), np.full(len(self), values[2])
        return np.where(self.back, values[4], values[0]), np.where(self.back, values[5], values[2])

    @property
    def straights(self) -> int:
        """Return how many unknowns there are for a robot that is not quite straight: 0 or 1."""
        return int(self.astray_sigma_rad.max(initial=0.0) > 0.0)

    @property
    def first_posture(self) -> int:
        """Return the index of the first bend's offset; frictions and straightness come before."""
        return self.parameters + self.straights

    @property
    def first_rounding(self) -> int:
        """Return the index of the first shared rounding error; the zero comes last."""
        return self.first_posture + len(self.posture_sigma_rad)

    @property
    def nuisances(self) -> int:
        """Return how many unknowns there are besides the frictions."""
        return self.first_rounding + len(self.rounding_sigma_rad) + 1 - self.parameters

    @cached_property
    def whitening(self) -> Floats:
        """Return W that makes nuisances x, in sigmas of their priors, independent: W x."""
        first, last = self.straights, self.first_rounding - self.parameters
        correlation = np.eye(self.nuisances)
        correlation[first:last, first:last] += TOGETHER * (1.0 - np.eye(last - first))
        correlation[last:-1, last:-1] = self.rounding_correlation
        return np.asarray(np.linalg.inv(np.linalg.cholesky(correlation)), dtype=np.float64)

    @cached_property
    def rounding_correlation(self) -> Floats:
        """Return how far the shared rounding errors go together, (errors, errors)."""
        draws = self.rounding_draws
        together = draws.T @ draws / max(len(draws), 1)
        # less than a ten thousandth of it is a set point's own, or many points had no inverse
        return together + 1e-4 * np.eye(len(together))

    @property
    def alone(self) -> FitData:
        """Return the same readings with every incline's error taken for its own."""
        shared = np.append(self.rounding_sigma_rad, 0.0)[self.rounding]
        return replace(
            self,
            incline_sigma_rad=np.hypot(self.incline_sigma_rad, shared),
            rounding=np.full(len(self), -1, dtype=np.intp),
            rounding_sigma_rad=np.empty(0),
            rounding_draws=np.empty((len(self.rounding_draws), 0)),
        )

    def picked(self, index: Whole | NDArray[np.bool_]) -> FitData:
        """Return some of the readings, with the postures as they are."""
        names = (
            "lambda_rad",
            "bent_share",
            "incline_rad",
            "slip_m_s",
            "incline_sigma_rad",
            "speed_sigma_m_s",
            "zero_sigma_rad",
            "posture",
            "rounding",
            "back",
            "astray_rad",
            "astray_sigma_rad",
            "inertia_n",
            "inertia_sigma_n",
        )
        own = {name: getattr(self, name)[index] for name in names}
        return replace(self, tracks=self.tracks.picked(index), **own)

    def without(self, index: int) -> FitData:
        """Return all readings but one."""
        return self.picked(np.delete(np.arange(len(self)), index))


def _tracks(session: Session) -> Tracks:
    setup, kept = session.setup, session.kept
    mass_kg = setup.robot.links * setup.robot.link_mass_kg
    return Tracks.of(
        [r.places for r in kept],
        [r.watch or setup.stopwatch for r in kept],
        mass_kg,
        rolling_share(setup.floor.wheels_kg, mass_kg),
    )


def _astray(session: Session, bent_share: Floats) -> tuple[Floats, Floats]:
    """Return each reading's mean and sigma of how far straight links are off, times their share."""
    links = session.setup.robot.links
    off = np.array([session.uncertainty_of(r).joint_sigma_rad for r in session.kept], dtype=float)
    bent = np.round(bent_share * links).astype(int)
    factors = {n: straightness_factors(links, n) for n in set(bent.tolist())}
    found = np.array([factors[n] for n in bent.tolist()]).reshape(-1, 2)
    found *= (off * (1.0 - bent_share))[:, None]
    return found[:, 0], found[:, 1]


def projections(
    bent_share: Floats | float, angle_rad: Floats | float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return what ct, cn, ft0 and fn0 count in A and B, where friction along the belt is A v + B.

    With a share q of the links bent by lambda and the rest straight,
    A = ct (1 - q sin^2) + cn q sin^2 and B = ft0 (1 - q + q cos) + fn0 q sin.
    """
    q, cos, sin = np.asarray(bent_share, dtype=float), np.cos(angle_rad), np.sin(angle_rad)
    return 1.0 - q * sin**2, q * sin**2, 1.0 - q + q * cos, q * sin


def settings(session: Session, readings: Sequence[Reading | Coast | Slide]) -> Whole:
    """Return per reading which protractor check its bend was set by; -1 where none tells."""
    checks = [b for b in session.bends if not b.voided]

    def of(reading: Reading | Coast | Slide) -> int:
        earlier = [
            k
            for k, b in enumerate(checks)
            if b.number < reading.number and abs(b.found_rad - reading.lambda_rad) < _SAME_RAD
        ]
        return earlier[-1] if earlier else -1

    return np.array([of(r) for r in readings], dtype=np.intp)


def postures(
    lambda_rad: Floats, sigma_rad: Floats, setting: Whole | None = None
) -> tuple[Whole, Floats, Floats]:
    """Return which posture each reading was taken in (-1: straight), their angles and sigmas.

    setting: which protractor check a bend was set by, -1 where none tells: each is a posture of its
    own. Bends without one that differ by less than a standard deviation of the bend are one
    posture: they were set once, and share its error.
    """
    index = np.full(len(lambda_rad), -1, dtype=np.intp)
    by = np.full(len(lambda_rad), -1, dtype=np.intp) if setting is None else setting
    found: list[tuple[float, float, int]] = []
    for k in np.lexsort((lambda_rad, by)):
        angle, sigma, check = float(lambda_rad[k]), float(sigma_rad[k]), int(by[k])
        if angle <= 0.0:
            continue
        old = [
            p
            for p, (at, width, by_check) in enumerate(found)
            if by_check == check and angle - at <= max(width, 1e-9)
        ]
        if not old:
            found.append((angle, sigma, check))
        index[k] = old[-1] if old else len(found) - 1
    angles, sigmas, _ = zip(*found, strict=True) if found else ((), (), ())
    return index, np.array(angles), np.array(sigmas)


def roundings(
    shown_rad: Floats, sigma_rad: Floats, grade_step: Floats | float, drift: Drift | None = None
) -> tuple[Whole, Floats, Floats]:
    """Return which shared rounding error each reading has (-1: none), their sigmas, draws.

    Readings of inclinometers that err differently share nothing, nor do those of treadmills with
    other steps.
    """
    steps = np.broadcast_to(np.asarray(grade_step, dtype=float), np.shape(sigma_rad))
    index = np.full(len(shown_rad), -1, dtype=np.intp)
    sigmas: list[float] = []
    draws = np.empty((DRAWS, 0))
    for sigma, step in np.unique(np.column_stack([sigma_rad, steps]), axis=0).tolist():
        own = np.flatnonzero((sigma_rad == sigma) & (steps == step))
        if drift is None:
            found = shared_rounding(shown_rad[own], sigma, step)
            widths = [sigma] * (0 if found is None else found[1].shape[1])
        else:
            found = drifting_rounding(shown_rad[own], sigma, step, drift.of(own))
            widths = [] if found is None else found[1].std(axis=0).tolist()
            found = found and (found[0], found[1] / widths)
        if found is not None:
            index[own] = len(sigmas) + found[0]
            # another inclinometer's phase is another's: shuffled
            shuffle = np.random.default_rng(len(sigmas)).permutation(DRAWS)
            draws = np.column_stack([draws, found[1][shuffle]])
            sigmas += widths
    return index, np.array(sigmas), draws
