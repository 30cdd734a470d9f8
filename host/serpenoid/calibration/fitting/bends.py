"""How readings were bent: which of them share a bend's error, and what a bend does to friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...session.push import Push
from ...session.session import Session
from ...session.station import Reading
from .shared import FRICTIONS, straightness_factors
from .unknowns import Floats, Unknown, Values, Whole

# Assumed correlation between the setting errors of two bends. They are set one by one, but by the
# same protractor and servos. Taken for independent (0), cn's interval covers 90 % if they are all
# the same; taken for half the same, 90 % if they are independent. 0.25 covers 93 to 97 % of either.
CORRELATION = 0.25
_SAME_RAD = math.radians(1e-3)  # a bend written down with four decimals
_COMMON = "bends"


@dataclass(frozen=True)
class Bends:
    """The bends of N readings.

    lambda_rad, share (of the links that are bent, 0 where straight), posture (which of the bends,
    -1: straight): (N,). off_rad: mean and standard deviation of the straight links' mean |angle| to
    the path, times their share of all links, (2, N). angle_rad, sigma_rad: of each bend, as set,
    and its error. where: names them.
    """

    lambda_rad: Floats
    share: Floats
    posture: Whole
    off_rad: Floats
    angle_rad: Floats
    sigma_rad: Floats
    where: str = ""

    @classmethod
    def of(cls, session: Session, readings: Sequence[Reading | Push], where: str = "") -> Bends:
        """Take the bends of some of a session's readings."""
        given, links = session.setup.instruments, session.setup.robot.links
        lambda_rad = np.array([r.lambda_rad for r in readings], dtype=float)
        sigma_rad = np.full(len(readings), given.lambda_sigma_rad)
        share = np.array([session.bent_share(r) for r in readings], dtype=float)
        bent = np.round(share * links).astype(int).tolist()
        factors = np.array([straightness_factors(links, b) for b in bent]).reshape(-1, 2).T
        off_rad = given.joint_sigma_rad * (1.0 - share) * factors
        posture, angles, sigmas = postures(lambda_rad, sigma_rad, _settings(session, readings))
        return cls(lambda_rad, share, posture, off_rad, angles, sigmas, where)

    def some(self, index: slice | Whole | NDArray[np.bool_]) -> Bends:
        """Return those of some of the readings."""
        return replace(
            self,
            lambda_rad=self.lambda_rad[index],
            share=self.share[index],
            posture=self.posture[index],
            off_rad=self.off_rad[:, index],
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Return the name of each bend's unknown."""
        return tuple(f"bend {k}{self.where}" for k in range(len(self.angle_rad)))

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return each bend's error, and what is common to all, where there are more than one."""
        common = (_COMMON,) if len(self.angle_rad) > 1 else ()
        return tuple(map(Unknown, (*common, *self.names)))

    @property
    def straightness(self) -> tuple[Unknown, ...]:
        """Return what straight links have in common, where it has a doubt: their mean |angle|."""
        mean, sigma = self.off_rad
        doubtful = sigma > 0.0
        least = (-mean[doubtful] / sigma[doubtful]).max(initial=-np.inf)
        return (Unknown("astray", float(least)),) if doubtful.any() else ()

    def astray_rad(self, values: Values) -> Floats:
        """Return the straight links' mean |angle| to the path, times their share, (K or 1, N)."""
        mean, sigma = self.off_rad
        return mean + sigma * values["astray"][:, None] if "astray" in values else mean[None]

    def errors_rad(self, values: Values) -> list[Floats]:
        """Return each bend's error (K,)."""
        own, common = 1.0, 0.0
        if len(self.angle_rad) > 1:
            own, common = math.sqrt(1.0 - CORRELATION), math.sqrt(CORRELATION) * values[_COMMON]
        return [
            s * (own * values[n] + common) for n, s in zip(self.names, self.sigma_rad, strict=True)
        ]

    def angles_rad(self, values: Values) -> Floats:
        """Return the true bend of each reading, (K, N)."""
        errors = self.errors_rad(values)
        if not errors:
            return self.lambda_rad[None]
        padded = np.stack([*errors, np.zeros_like(errors[0])], axis=1)  # -1: straight, no error
        return np.asarray(self.lambda_rad + padded[:, self.posture])

    def nuisances(self, values: Values) -> dict[str, Floats]:
        """Return each bend's error by the name that a fit gives it, rad."""
        out: dict[str, Floats] = {}
        for angle, error in zip(self.angle_rad, self.errors_rad(values), strict=True):
            name = f"lambda_offset_rad_at_{math.degrees(angle):.4g}_deg"
            again = sum(n == name or n.startswith(name + "_again") for n in out)
            out[name + (f"_again_{again}" if again else "")] = error
        return out


def projections(
    bent_share: Floats | float, angle_rad: Floats | float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return what ct, cn, ft0 and fn0 count in A and B, where friction along the belt is A v + B.

    With a share q of the links bent by lambda and the rest straight,
    A = ct (1 - q sin^2) + cn q sin^2 and B = ft0 (1 - q + q cos) + fn0 q sin.
    """
    q, cos, sin = np.asarray(bent_share, dtype=float), np.cos(angle_rad), np.sin(angle_rad)
    return 1.0 - q * sin**2, q * sin**2, 1.0 - q + q * cos, q * sin


def resistance(
    whole: Floats,
    bent_share: Floats | float,
    angle_rad: Floats | float,
    astray_rad: Floats | float = 0.0,
) -> tuple[Floats, Floats]:
    """Return A, N s/m, and B, N, of friction A v + B along the way, whole snake, each (..., N).

    whole: (..., 4) frictions in the order of FRICTIONS. astray_rad: the straight links' mean
    |angle| to the way, times their share.
    """
    ct, cn, ft0, fn0 = np.moveaxis(whole, -1, 0)[..., None]
    by_ct, by_cn, by_ft0, by_fn0 = projections(bent_share, angle_rad)
    return ct * by_ct + cn * by_cn, ft0 * by_ft0 + fn0 * (by_fn0 + astray_rad)


def frictions_in(values: Values) -> Floats:
    """Return the frictions (K, 4) among values by name, in the order of FRICTIONS."""
    return np.stack([values[name] for name in FRICTIONS], axis=-1)


def _settings(session: Session, readings: Sequence[Reading | Push]) -> Whole:
    """Return per reading which protractor check its bend was set by; -1 where none tells."""
    checks = [b for b in session.bends if not b.voided]

    def of(reading: Reading | Push) -> int:
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
    known: list[tuple[float, float, int]] = []
    for k in np.lexsort((lambda_rad, by)):
        angle, sigma, check = float(lambda_rad[k]), float(sigma_rad[k]), int(by[k])
        if angle <= 0.0:
            continue
        same = [
            p
            for p, (first, width, by_check) in enumerate(known)
            if by_check == check and angle - first <= max(width, 1e-9)
        ]
        if not same:
            known.append((angle, sigma, check))
        index[k] = same[-1] if same else len(known) - 1
    angles, sigmas, _ = zip(*known, strict=True) if known else ((), (), ())
    return index, np.array(angles), np.array(sigmas)
