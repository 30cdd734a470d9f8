"""The friction of a bent robot, and the errors of bends that readings share.

A link at an angle delta to its path slips across it, however slowly, so that dry friction across
adds the drag fn0 / n |sin delta|, which is of first order in delta. If the joints have independent
errors of sigma, the links' angles are sums of these; steering removes the mean heading and the
mean curvature. The remaining angles have the covariance S. The mean of |delta| over the links has
the expectation a sigma and the standard deviation b sigma:

    a = sqrt(2/pi) mean(s_i),   b^2 = (2/pi) / n^2 sum s_i s_j (sqrt(1 - rho^2) + rho asin rho - 1),

with s_i^2 = S_ii and rho = S_ij / (s_i s_j). Of bent links, those bent to one side gain the drag
that those bent to the other side lose, so that to first order their dry friction does not depend on
delta. So only the straight links count. Steering aligns two of them with the path exactly, so that
a and b are 0 unless there are three or more. The mean |delta| of the straight links, times their
share of all links, is called the stray angle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..session.push import Push
from ..session.session import Session
from ..session.station import Reading
from .parameters import FRICTIONS, Floats, Integers, Parameter, Values

# Assumed correlation between the setting errors of two bends, which are set separately, but with
# the same protractor and servos. With 0, cn's 95 % interval covers 90 % if the errors are in fact
# equal; with 0.5, 90 % if they are independent. With 0.25 it covers 93 to 97 % in both cases.
CORRELATION = 0.25
BEND_ERROR, COMMON_ERROR = "lambda_offset_rad_at_", "common error of bends"
STRAIGHTNESS = "straight links' mean angle"
STEERED_LINKS = 2  # Straight links that steering aligns with the path exactly.


@dataclass(frozen=True)
class Bends:
    """The bends of N readings.

    lambda_rad: (N,). share: share of the links that are bent, (N,). posture: index of each
    reading's bend, -1 if straight, (N,). stray_rad: mean and standard deviation of the stray
    angle, (2, N). angle_rad: the angle of each bend. errors: the parameter of each bend's error,
    rad.
    """

    lambda_rad: Floats
    share: Floats
    posture: Integers
    stray_rad: Floats
    angle_rad: tuple[float, ...]
    errors: tuple[Parameter, ...]

    @classmethod
    def from_session(
        cls, session: Session, readings: Sequence[Reading | Push], where: str = ""
    ) -> Bends:
        """Return the bends of readings of a session; where: suffix of the names of their errors."""
        instruments, links = session.setup.instruments, session.setup.robot.links
        share = np.array([session.bent_share(r) for r in readings], dtype=float)
        bent = np.round(share * links).astype(int).tolist()
        factors = np.array([straightness_factors(links, b) for b in bent]).reshape(-1, 2).T
        stray_rad = instruments.joint_sigma_rad * (1.0 - share) * factors
        posture, angles = _postures(session, readings, instruments.lambda_sigma_rad)
        errors: dict[str, Parameter] = {}
        for angle in angles:
            name = f"{BEND_ERROR}{math.degrees(angle):.4g}_deg{where}"
            while name in errors:
                name += "_again"
            errors[name] = Parameter(name, sigma=instruments.lambda_sigma_rad)
        lambda_rad = np.array([r.lambda_rad for r in readings], dtype=float)
        return cls(lambda_rad, share, posture, stray_rad, angles, tuple(errors.values()))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Return the parameters of the bends' errors, their common part, and the stray angle."""
        common = (Parameter(COMMON_ERROR, sigma=1.0),) if len(self.errors) > 1 else ()
        mean, sigma = self.stray_rad
        unsure = sigma > 0.0
        if not unsure.any():
            return (*common, *self.errors)
        # No stray angle is negative.
        low = float((-mean[unsure] / sigma[unsure]).max())
        return (*common, *self.errors, Parameter(STRAIGHTNESS, sigma=1.0, low=low))

    def stray_angles_rad(self, values: Values) -> Floats:
        """Return the stray angle of each reading, (K or 1, N)."""
        mean, sigma = self.stray_rad
        return (
            mean + sigma * values[STRAIGHTNESS][:, None] if STRAIGHTNESS in values else mean[None]
        )

    def angles_rad(self, values: Values) -> Floats:
        """Return the true bend of each reading, (K, N)."""
        if not self.errors:
            return self.lambda_rad[None]
        errors = [values[error.name] for error in self.errors]
        errors.append(np.zeros_like(errors[0]))  # Straight readings, of posture -1, have no error.
        return np.asarray(self.lambda_rad + np.stack(errors, axis=1)[:, self.posture])


def projections(
    bent_share: Floats | float, angle_rad: Floats | float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the factors of ct and cn in A, and of ft0 and fn0 in B.

    A v + B is the friction along the belt. With a share q of the links bent by lambda and the rest
    straight,
    A = ct (1 - q sin^2) + cn q sin^2 and B = ft0 (1 - q + q cos) + fn0 q sin.
    """
    q, cos, sin = np.asarray(bent_share, dtype=float), np.cos(angle_rad), np.sin(angle_rad)
    return 1.0 - q * sin**2, q * sin**2, 1.0 - q + q * cos, q * sin


def frictions_in(values: Values) -> Floats:
    """Return the four frictions among values, (K, 4), in the order of FRICTIONS."""
    return np.stack([values[name] for name in FRICTIONS], axis=-1)


def resistance(
    frictions: Floats,
    bent_share: Floats | float,
    angle_rad: Floats | float,
    stray_rad: Floats | float = 0.0,
) -> tuple[Floats, Floats]:
    """Return A, N s/m, and B, N, of the whole snake's friction A v + B along its path, (..., N).

    frictions: (..., 4), in the order of FRICTIONS. stray_rad: stray angle.
    """
    ct, cn, ft0, fn0 = np.moveaxis(frictions, -1, 0)[..., None]
    by_ct, by_cn, by_ft0, by_fn0 = projections(bent_share, angle_rad)
    return ct * by_ct + cn * by_cn, ft0 * by_ft0 + fn0 * (by_fn0 + stray_rad)


def straightness_factors(links: int, bent: int = 0) -> tuple[float, float]:
    """Return a and b, mean and standard deviation of the straight links' mean |delta| in sigmas.

    links: number of links. bent: number of bent links, half of them at each end.
    """
    straight = links - bent
    if straight <= STEERED_LINKS:
        return 0.0, 0.0
    position = bent / 2 + np.arange(straight, dtype=float)
    joints_before = np.minimum.outer(position, position)
    steered = np.column_stack([np.ones(straight), position])
    residual_maker = np.eye(straight) - steered @ np.linalg.pinv(steered)
    covariance = residual_maker @ joints_before @ residual_maker.T
    s = np.sqrt(np.diag(covariance))
    rho = np.clip(covariance / np.outer(s, s), -1.0, 1.0)
    shape = np.sqrt(1.0 - rho**2) + rho * np.arcsin(rho) - 1.0
    scatter = math.sqrt(2 / math.pi * float(s @ shape @ s)) / straight
    return math.sqrt(2 / math.pi) * float(s.mean()), scatter


def _postures(
    session: Session, readings: Sequence[Reading | Push], sigma_rad: float
) -> tuple[Integers, tuple[float, ...]]:
    """Return the index of each reading's posture (-1: straight), and the postures' angles, rad.

    A posture is a bend that was set once, so that its readings share the error. Bends set by one
    protractor check are one posture, and so are bends without a check that differ by less than
    sigma_rad.
    """
    checks = session.kept_of("bend")

    def check_of(reading: Reading | Push) -> int:
        """Return the index of the last check of this bend before the reading; -1 if none."""
        matching = [
            k
            for k, check in enumerate(checks)
            if check.number < reading.number
            and math.isclose(check.found_rad, reading.lambda_rad, abs_tol=2e-5)
        ]
        return matching[-1] if matching else -1

    index = np.full(len(readings), -1, dtype=np.intp)
    postures: list[tuple[int, float]] = []
    bent = [(check_of(r), r.lambda_rad, k) for k, r in enumerate(readings) if r.lambda_rad > 0.0]
    for check, angle, k in sorted(bent):
        latest = postures[-1] if postures else (check, -math.inf)
        if latest[0] != check or angle - latest[1] > max(sigma_rad, 1e-9):
            postures.append((check, angle))
        index[k] = len(postures) - 1
    return index, tuple(angle for _, angle in postures)
