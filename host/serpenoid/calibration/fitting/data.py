"""The kept readings of a session as arrays, with the errors that they have alone and in common."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..session import Session

Floats = NDArray[np.float64]
Whole = NDArray[np.intp]

# Taken where a set-up claims a zero without error: an undeclared 0.1 degrees would leave ft0's 95 %
# interval with 17 % coverage, so that the prior is never absent.
ZERO_SIGMA_RAD = math.radians(0.1)
# How far the errors of two bends go together. They are set one by one, but by the same protractor
# and servos. Taken for independent (0), cn's interval covers 90 % if they are all the same; taken
# for half the same, 90 % if they are independent; with a quarter it covers 93 to 97 % either way.
TOGETHER = 0.25


@dataclass(frozen=True)
class FitData:
    """The kept readings, and which of them share an error.

    lambda_rad, incline_rad (as shown, less the zero where that was measured), slip_m_s,
    incline_sigma_rad, speed_sigma_m_s: per reading. posture: per reading, which of
    posture_sigma_rad's bends it was taken at; -1 when straight. zero_sigma_rad: of what is left of
    the inclinometer's zero, common to all. zero_assumed: it is ours, since the set-up claimed 0.
    """

    lambda_rad: Floats
    incline_rad: Floats
    slip_m_s: Floats
    incline_sigma_rad: Floats
    speed_sigma_m_s: Floats
    posture: Whole
    posture_lambda_rad: Floats
    posture_sigma_rad: Floats
    weight_n: float
    zero_sigma_rad: float
    zero_assumed: bool

    @classmethod
    def of(cls, session: Session) -> FitData:
        """Take a session's kept readings."""
        kept, zero = session.kept, session.zero
        given = [session.uncertainty_of(r) for r in kept]
        lambda_rad = np.array([r.lambda_rad for r in kept], dtype=float)
        lambda_sigma_rad = np.array([g.lambda_sigma_rad for g in given], dtype=float)
        posture, angles, sigmas = postures(lambda_rad, lambda_sigma_rad)
        return cls(
            lambda_rad=lambda_rad,
            incline_rad=np.array([r.incline_rad for r in kept], dtype=float) - zero.value_rad,
            slip_m_s=np.array([r.slip_speed_m_s for r in kept], dtype=float),
            incline_sigma_rad=np.array([g.incline_sigma_rad for g in given], dtype=float),
            speed_sigma_m_s=np.array([g.belt_speed_sigma_m_s for g in given], dtype=float),
            posture=posture,
            posture_lambda_rad=angles,
            posture_sigma_rad=sigmas,
            weight_n=session.setup.weight_n,
            zero_sigma_rad=zero.sigma_rad or ZERO_SIGMA_RAD,
            zero_assumed=not zero.sigma_rad,
        )

    def __len__(self) -> int:
        return len(self.lambda_rad)

    @property
    def bent(self) -> NDArray[np.bool_]:
        """Tell which readings were taken with the robot bent."""
        return self.posture >= 0

    @property
    def nuisances(self) -> int:
        """Return how many unknowns there are besides the four parameters."""
        return len(self.posture_sigma_rad) + 1

    @cached_property
    def whitening(self) -> Floats:
        """Return W that makes nuisances x, in sigmas of their priors, independent: W x."""
        bends = self.nuisances - 1
        correlation = np.eye(self.nuisances)
        correlation[:bends, :bends] += TOGETHER * (1.0 - np.eye(bends))
        return np.asarray(np.linalg.inv(np.linalg.cholesky(correlation)), dtype=np.float64)

    def picked(self, index: Whole | NDArray[np.bool_]) -> FitData:
        """Return some of the readings, with the postures as they are."""
        names = ("lambda_rad", "incline_rad", "slip_m_s", "incline_sigma_rad", "speed_sigma_m_s",
                 "posture")  # fmt: skip
        return replace(self, **{name: getattr(self, name)[index] for name in names})

    def without(self, index: int) -> FitData:
        """Return all readings but one."""
        return self.picked(np.delete(np.arange(len(self)), index))


def postures(lambda_rad: Floats, sigma_rad: Floats) -> tuple[Whole, Floats, Floats]:
    """Return which posture each reading was taken in (-1: straight), their angles and sigmas.

    Bends that differ by less than a standard deviation of the bend are one posture: they were set
    once, and share its error.
    """
    index = np.full(len(lambda_rad), -1, dtype=np.intp)
    found: list[tuple[float, float]] = []
    for k in np.argsort(lambda_rad, kind="stable"):
        angle, sigma = float(lambda_rad[k]), float(sigma_rad[k])
        if angle <= 0.0:
            continue
        if not found or angle - found[-1][0] > max(found[-1][1], 1e-9):
            found.append((angle, sigma))
        index[k] = len(found) - 1
    angles, sigmas = zip(*found, strict=True) if found else ((), ())
    return index, np.array(angles), np.array(sigmas)
