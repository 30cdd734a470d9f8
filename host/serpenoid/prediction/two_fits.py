"""Two fits of one robot, as from a treadmill and from a floor: do they agree, and what differs.

The differences of the frictions are held against both covariances. Where they do not agree, each
cause is let loose alone: what all frictions, or the viscous ones, or an incline, or a bend have in
common, or one friction. Named are those that explain the rest best.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..calibration.fitting.shared import FRICTIONS
from ..calibration.friction_fit import fit_friction
from ..calibration.friction_result import UNITS, Floats, FrictionFit
from ..calibration.session import Session
from ..model.errors import BadInput

DOUBTFUL = 0.05
_AS_GOOD = 4.0  # of chi2: no worse than the best cause
_MOST_CAUSES = 3
_BEND_RAD = math.radians(30.0)  # about: how much of an incline's error a bent reading gives to fn0
WORDS = {
    "mass": "all four frictions differ by one factor: was one session's mass mistyped, or did the "
    "robot carry something?",
    "speed": "ct and cn differ by one factor: is the belt's speed or the film's scale off?",
    "incline": "dry friction differs as by one incline: look at the inclinometer's zero, and "
    "whether pushes went both ways",
    "bend": "cn and fn0 differ by one factor: was the bend as the protractor showed it?",
    "ct": "ct alone differs: viscous friction along the wheels, as of other grease, or dust",
    "cn": "cn alone differs: viscous friction across the wheels, a matter of the surface",
    "ft0": "ft0 alone differs: wheels roll harder on one surface (a carpet is no belt), or one of "
    "the inclines is off",
    "fn0": "fn0 alone differs: wheels grip one surface better (a carpet is no belt)",
    "ct_back": "ct backwards alone differs: ratchets that turn in other grease, or dust",
    "ft0_back": "ft0 backwards alone differs: ratchets that hold less, or another surface",
}
AGREE = "The two agree within their intervals."
OTHER = (
    "They differ in more than one way: the surfaces are not alike (a carpet is no belt). Predict "
    "a crawl from the session of the surface that it is on."
)


@dataclass(frozen=True)
class Difference:
    """One friction of the whole snake in both sessions; sigmas: of the difference, in its error."""

    name: str
    unit: str
    first: float
    second: float
    sigmas: float


@dataclass(frozen=True)
class TwoFits:
    """What two fits have in common.

    p_value: the chance of differences as large if both tell the same frictions. causes: keys of
    WORDS that explain them best, where they do not agree; verdict says it in words.
    """

    first: str
    second: str
    rows: tuple[Difference, ...]
    p_value: float
    causes: tuple[str, ...]
    verdict: str

    def table(self) -> tuple[list[str], list[list[str]]]:
        """Return heads and cells of a table of both sessions' frictions."""
        cells = [
            [r.name, r.unit, f"{r.first:.4g}", f"{r.second:.4g}", f"{r.sigmas:+.1f}"]
            for r in self.rows
        ]
        return ["whole snake", "unit", self.first, self.second, "differs by (sigmas)"], cells

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return asdict(self)


def two_sessions(first: Session, second: Session) -> TwoFits:
    """Compare the fits of two sessions with one robot. Raises BadInput as fits do."""
    same = first.setup.robot.link_mass_kg == second.setup.robot.link_mass_kg
    sigma = min(first.mass_sigma, second.mass_sigma) if same else 0.0
    return two_fits(fit_friction(first), fit_friction(second), sigma)


def two_fits(first: FrictionFit, second: FrictionFit, mass_sigma: float = 0.0) -> TwoFits:
    """Compare two fits of one robot; mass_sigma: relative error of the mass that both rest on.

    Frictions backwards are compared where both fits have them. Raises BadInput where robots differ.
    """
    for name in ("links", "link_length_m"):
        values = [getattr(fit.robot, name) for fit in (first, second)]
        if abs(values[0] - values[1]) > 1e-3 * abs(values[0]):
            raise BadInput(
                f"{name} is {values[0]:g} in {first.session_name!r} and {values[1]:g} in "
                f"{second.session_name!r}; give two sessions of one robot"
            )
    from scipy.special import chdtrc

    common = min(len(first.names), len(second.names))
    values = [np.array(list(fit.whole_snake.values()))[:common] for fit in (first, second)]
    off = values[1] - values[0]
    covariance = first.covariance[:common, :common] + second.covariance[:common, :common]
    # a mass that was weighed once errs in both alike
    apart = sum(np.outer(v, v) for v in values)
    covariance = covariance - mass_sigma**2 * (apart - np.outer(off, off))
    inverse = np.asarray(np.linalg.inv(covariance), dtype=np.float64)
    p_value = float(chdtrc(len(off), off @ inverse @ off))
    causes = () if p_value >= DOUBTFUL else _causes(off, inverse, (values[0] + values[1]) / 2)
    sigmas = off / np.sqrt(np.diag(covariance))
    rows = [
        Difference(name, UNITS[name], *map(float, row))
        for name, *row in zip(FRICTIONS[:common], *values, sigmas, strict=True)
    ]
    return TwoFits(
        first.session_name,
        second.session_name,
        tuple(rows),
        p_value,
        causes,
        " ".join([_verdict(p_value, causes), *_alarms(first, second)]),
    )


def _alarms(*fits: FrictionFit) -> list[str]:
    """Say whose errors are not to be trusted, on which all of this rests, and why."""
    return [
        f"But the fit of {fit.session_name} is not to be trusted. {' '.join(fit.alarms)}"
        for fit in fits
        if fit.alarms
    ]


def _causes(off: Floats, inverse: Floats, values: Floats) -> tuple[str, ...]:
    """Return the causes that leave the least, those that then agree."""
    from scipy.special import chdtrc

    names = FRICTIONS[: len(values)]
    dry = {"ft0": 1.0, "fn0": math.tan(_BEND_RAD / 2), "ft0_back": 1.0}
    ways = {
        "mass": values,
        "speed": values * [name.startswith("c") for name in names],
        "incline": np.array([dry.get(name, 0.0) for name in names]),
        "bend": values * [name in ("cn", "fn0") for name in names],
        **dict(zip(names, np.eye(len(names)), strict=True)),
    }
    whole = off @ inverse @ off
    left = {
        name: max(whole - (way @ inverse @ off) ** 2 / (way @ inverse @ way), 0.0)
        for name, way in ways.items()
    }
    most = min(left.values()) + _AS_GOOD
    able = [n for n in left if left[n] <= most and chdtrc(len(off) - 1, left[n]) >= DOUBTFUL]
    return tuple(sorted(able, key=left.__getitem__)[:_MOST_CAUSES])


def _verdict(p_value: float, causes: tuple[str, ...]) -> str:
    if p_value >= DOUBTFUL:
        return AGREE
    if not causes:
        return OTHER
    either = "They do not agree. " + ("One of these explains it. " if len(causes) > 1 else "")
    words = "; or ".join(WORDS[cause] for cause in causes)
    return f"{either}{words[0].upper()}{words[1:]}."
