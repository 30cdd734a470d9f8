"""The result of a friction fit: values, intervals, covariance, samples, and notes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..base.checks import check_number
from ..base.rows import Plottable, Row, ranged
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.session import NO_BELT
from .parameters import FRICTIONS, Floats

T = TypeVar("T")

UNITS = MappingProxyType({name: "N s/m" if name[0] == "c" else "N" for name in FRICTIONS})
LEVEL = 0.95
METHODS = "joint", "naive"
WHOLE_SUFFIX = "_whole"
NOT_WEIGHED = "The robot was not weighed"
NO_ZERO = "The inclinometer's zero was not measured"
DOUBTFUL = 0.01  # p-value below which readings contradict the stated uncertainties.
KEPT_SAMPLES = 256


def ground_of(links: int, frictions: Sequence[float]) -> Ground:
    """Return the ground on a link from the whole snake's frictions, in the order of FRICTIONS."""
    return Ground.whole_body(links, *frictions)


class Estimate(NamedTuple):
    """A fitted value and its standard deviation, in the same unit."""

    value: float
    sigma: float


@dataclass(frozen=True)
class Influence:
    """The influence of one reading on a fit.

    reading: its number. chi2_without, shift_in_sigmas: chi2 of the fit without it, and the
    difference of its frictions in standard deviations; None if the others do not determine them.
    """

    reading: int
    chi2_without: float | None
    shift_in_sigmas: Mapping[str, float] | None


class WholeSnake(dict[str, T]):
    """Map from ct_whole, cn_whole, ft0_whole, fn0_whole, of the whole snake, to values.

    The names differ from those of `ground`, whose values are per link. The short names (ct, cn,
    ft0, fn0) give the same values.
    """

    @classmethod
    def from_values(cls, values: Iterable[T]) -> Mapping[str, T]:
        """Return a read-only map of values in the order of FRICTIONS."""
        return MappingProxyType(
            cls(zip((n + WHOLE_SUFFIX for n in FRICTIONS), values, strict=True))
        )

    def __missing__(self, name: str) -> T:
        if name not in FRICTIONS:
            raise KeyError(name)
        return self[name + WHOLE_SUFFIX]


@dataclass(frozen=True, eq=False, repr=False)
class FrictionFit(Plottable):
    """The friction fitted to one session; print() shows a report.

    Attributes
    ----------
    method
        "joint" or "naive".
    robot
        The robot measured.
    values : (4,)
        ct, cn, N s/m, ft0, fn0, N, of the whole snake.
    covariance : (4, 4)
        Of the values.
    ends : (4, 2)
        Of the values' 95 % intervals, none below 0.
    samples : (N, 4)
        Samples of the values, each as likely as any other.
    chi2
        Sum of squared residuals of readings and priors under the stated uncertainties.
    dof
        Degrees of freedom of chi2.
    nuisances
        name -> (value, sigma): what the readings share, errors of bends and of the inclinometer's
        zero, slopes of a floor; none for "naive".
    residuals
        One for each kept reading, in standard deviations; of a filmed push the root mean square.
    influence
        One for each kept reading; none for "naive".
    notes
        Remarks in words.
    alarms
        Those notes that forbid to trust a prediction.
    session_name
        Name of the session fitted.
    session_sha256
        Hash of what the fit rests on.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> fit = sn.fit_friction(session)
    >>> round(fit.parameters["cn_whole"].value, 2)  # of the whole snake, N s/m
    1.2
    """

    method: str
    robot: Robot
    values: Floats
    covariance: Floats
    ends: Floats
    samples: Floats
    chi2: float = 0.0
    dof: int = 0
    nuisances: Mapping[str, Estimate] = field(default_factory=dict[str, Estimate])
    residuals: tuple[float, ...] = ()
    influence: tuple[Influence, ...] = ()
    notes: tuple[str, ...] = ()
    alarms: tuple[str, ...] = ()
    session_name: str = ""
    session_sha256: str = ""

    def __post_init__(self) -> None:
        shapes = {"values": (4,), "covariance": (4, 4), "ends": (4, 2), "samples": (-1, 4)}
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), dtype=np.float64).reshape(shape)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def sigma(self) -> str:
        """Return how sigma was found: "absolute", or "rescaled" by the scatter (naive)."""
        return "rescaled" if self.method == "naive" else "absolute"

    @property
    def parameters(self) -> Mapping[str, Estimate]:
        """Return name -> (value, sigma): ct_whole, cn_whole, N s/m, ft0_whole, fn0_whole, N."""
        sigmas = np.sqrt(np.maximum(np.diag(self.covariance), 0.0)).tolist()
        return WholeSnake.from_values(map(Estimate, self.values.tolist(), sigmas))

    @property
    def intervals(self) -> Mapping[str, tuple[float, float]]:
        """Return name -> (low, high), the 95 % interval, in the units of parameters."""
        return WholeSnake.from_values((low, high) for low, high in self.ends.tolist())

    @property
    def ground(self) -> Ground:
        """Return the fitted friction on a link, for simulations."""
        return ground_of(self.robot.links, self.values.tolist())

    @property
    def unmeasured(self) -> list[str]:
        """Return the notes on quantities that were not measured and keep their prior."""
        return [note for note in self.notes if note.startswith((NOT_WEIGHED, NO_ZERO, NO_BELT))]

    @property
    def whole_snake(self) -> dict[str, float]:
        """Return ct, cn (N s/m), ft0, fn0 (N) of the whole snake."""
        return dict(zip(FRICTIONS, self.values.tolist(), strict=True))

    def sample_whole(self, count: int = 64, seed: int = 2005) -> Floats:
        """Return samples of the whole snake's frictions from the posterior, never below 0.

        Parameters
        ----------
        count, seed
            Number of samples, and the seed. The fit's samples are divided into as many parts, and
            one is picked from each.

        Returns
        -------
        (count, 4) array
            N s/m and N, in the order of parameters.
        """
        check_number("count", count, 1, 2**20)
        rng = np.random.default_rng(seed)
        places = (np.arange(count) + rng.random(count)) / count * len(self.samples)
        return self.samples[rng.permutation(places.astype(np.intp))]

    def sample(self, count: int = 64, seed: int = 2005) -> tuple[Ground, ...]:
        """Return samples of the friction on a link from the posterior, for simulations.

        Parameters
        ----------
        count, seed
            As for `sample_whole`: the same samples.

        Returns
        -------
        tuple of Ground
            `count` grounds.
        """
        samples = self.sample_whole(count, seed).tolist()
        return tuple(ground_of(self.robot.links, sample) for sample in samples)

    def __repr__(self) -> str:
        values = ", ".join(f"{r.name} {r.cells[1]} {r.unit}" for r in self.rows())
        return f"<FrictionFit {self.session_name!r}, {self.method}: {values}>"

    def in_words(self) -> str:
        """Return along and across the snake what resists, each with its 95 % interval."""
        ct, cn, ft0, fn0 = (ranged(r.value, r.unit, r.low, r.high) for r in self.rows())
        return f"Along, the snake resists with {ft0} and {ct}; across, with {fn0} and {cn}."

    @property
    def remarks(self) -> list[str]:
        """Return friction of one link, whether the readings agree, and the notes."""
        links = self.robot.links
        parts = [f"{r.name} {r.value / links:.4g} {r.unit}" for r in self.rows()]
        text = ", ".join(parts).replace(WHOLE_SUFFIX, "")
        notes = [f"note: {note}" for note in self.notes]
        agree = f"{self.session_name}, {self.method} fit: {self.chi2_in_words}"
        return [f"each of {links} links: {text}", agree, *notes]

    def __str__(self) -> str:
        return "\n".join([super().__str__(), *self.remarks])

    @property
    def chi2_in_words(self) -> str:
        """Return chi2, its degrees of freedom and its p-value in words."""
        chance = "" if self.p_value is None else f" (p = {self.p_value:.2g})"
        return f"chi2 = {self.chi2:.3g} for {self.dof} degrees of freedom{chance}"

    @property
    def p_value(self) -> float | None:
        """Return the probability of so large a chi2 if model and uncertainties hold."""
        from scipy.special import chdtrc

        return float(chdtrc(self.dof, self.chi2)) if self.dof > 0 else None

    def rows(self) -> list[Row]:
        """Return a row for each parameter of the whole snake."""
        return [
            Row(name, UNITS[name.removesuffix(WHOLE_SUFFIX)], value, *self.intervals[name], sigma)
            for name, (value, sigma) in self.parameters.items()
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return plain lists, numbers and text, fit for JSON."""
        parameters = {
            row.name: {
                "unit": row.unit,
                "value": row.value,
                "sigma": row.sigma,
                "interval": [row.low, row.high],
            }
            for row in self.rows()
        }
        return {
            "session": {"name": self.session_name, "sha256": self.session_sha256},
            "method": self.method,
            "sigma": self.sigma,
            "interval_level": LEVEL,
            "parameters": parameters,
            "covariance": {"order": list(parameters), "values": self.covariance.tolist()},
            "robot": {
                "links": self.robot.links,
                "link_mass_kg": self.robot.link_mass_kg,
                "link_length_m": self.robot.link_length_m,
                "link_inertia_kg_m2": self.robot.inertia_kg_m2,
            },
            "ground_per_link": {name: getattr(self.ground, name) for name in FRICTIONS},
            **{name: getattr(self, name) for name in ("chi2", "dof", "p_value")},
            "nuisances": {name: e._asdict() for name, e in self.nuisances.items()},
            "residuals": list(self.residuals),
            "influence": [vars(i) for i in self.influence],
            **{name: list(getattr(self, name)) for name in ("alarms", "notes")},
            "draws": {"order": list(FRICTIONS), "values": self.samples.tolist()},
        }

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> FrictionFit:
        """Return the fit of a dict from `to_dict`; in format 2 samples have more columns."""
        parts = content["parameters"].values()
        nuisances = {name: Estimate(**part) for name, part in content["nuisances"].items()}
        without = ("reading", "chi2_without", "shift_in_sigmas")
        return cls(
            robot=Robot(**content["robot"]),
            values=np.array([part["value"] for part in parts]),
            covariance=np.array(content["covariance"]["values"]),
            ends=np.array([part["interval"] for part in parts]),
            samples=np.array([row[:4] for row in content["draws"]["values"]]),
            nuisances=MappingProxyType(nuisances),
            influence=tuple(Influence(*map(e.get, without)) for e in content["influence"]),
            **{name: content[name] for name in ("method", "chi2", "dof")},
            **{name: tuple(content[name]) for name in ("residuals", "notes", "alarms")},
            **{"session_" + key: text for key, text in content["session"].items()},
        )


def narrowest(x: Floats, weight: Floats, value: float) -> tuple[float, float]:
    """Return the narrowest interval that contains LEVEL of weighted samples (N,), and value.

    It begins at 0 if 0 is as likely as other values; an interval with equal tails would never
    contain 0. The smallest width is that of a parabola through the widths, because single widths
    scatter with the samples.
    """
    order = np.argsort(x)
    share = np.cumsum(weight[order]) - weight[order] / 2
    tails = np.linspace(0.1, 0.9, 33) * (1.0 - LEVEL)  # Shares below the interval.
    low, high = (np.interp(tails + more, share, x[order]) for more in (0.0, LEVEL))
    curve, slope, _ = np.polyfit(tails, high - low, 2)
    tail = float(np.clip(-slope / (2.0 * curve), 0.0, tails[-1])) if curve > 0.0 else 0.0
    first, last = np.interp([tail, tail + LEVEL], share, x[order]).tolist()
    first = first if tail > tails[0] else 0.0
    return max(min(first, value), 0.0), max(last, value)


def spread_samples(x: Floats, weight: Floats, seed: int) -> Floats:
    """Return KEPT_SAMPLES equally likely samples of weighted samples (N, P).

    Samples are halved by weight along one axis, each half along the next, and so on. In this order
    they are resampled systematically. So means of the kept samples, and of evenly picked ones of
    them, scatter less than those of independent samples.
    """
    parts, axis = [np.flatnonzero(weight)], 0
    while len(parts) < KEPT_SAMPLES:
        halves = []
        for part in parts:
            order = part[np.argsort(x[part, axis % x.shape[1]], kind="stable")]
            share = np.cumsum(weight[order])
            middle = int(np.searchsorted(share, share[-1:].sum() / 2))
            halves += [order[:middle], order[middle:]]
        parts, axis = halves, axis + 1
    order = np.concatenate(parts)
    steps = (np.arange(KEPT_SAMPLES) + np.random.default_rng(seed).random()) / KEPT_SAMPLES
    share = np.cumsum(weight[order])
    picked = order[np.searchsorted(share, steps * share[-1])]
    return np.round(x[picked], 7)  # N s/m and N, as in files
