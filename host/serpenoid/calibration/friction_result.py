"""What a friction fit gives back: values, intervals, covariance, and what to know about them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..base.checks import check_number
from ..base.rows import Result, Row, ranged
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.session import NO_BELT, Session, belt_note
from .fitting.shared import FRICTIONS
from .fitting.stations import ZERO_SIGMA_RAD
from .fitting.suspects import Influence

Floats = NDArray[np.float64]
T = TypeVar("T")

UNITS = MappingProxyType({name: "N s/m" if name[0] == "c" else "N" for name in FRICTIONS})
LEVEL = 0.95
METHODS = "joint", "naive"
WHOLE = "_whole"
NOT_WEIGHED = "The robot was not weighed"
NO_ZERO = "The inclinometer's zero was not measured"
SURELY = 2.0  # errors of its difference, beyond which a zero that moved is told
_FEW = 4  # of the draws, one in so many or less
_TAILS = 11  # shares below an interval that are tried
DOUBTFUL = 0.01  # below this p-value the stated uncertainties and the readings do not agree


def whole_ground(whole: Sequence[float]) -> Ground:
    """Return the whole snake's frictions, in the order of FRICTIONS, as a Ground."""
    return Ground(*whole)


def ground_of(links: int, whole: Sequence[float]) -> Ground:
    """Return ground per link from the whole snake's frictions, in the order of FRICTIONS."""
    total = whole_ground(whole)
    return Ground.whole_body(links, total.ct, total.cn, total.ft0, total.fn0)


class Estimate(NamedTuple):
    """A fitted value and its standard deviation, in the same unit."""

    value: float
    sigma: float


class WholeSnake(Mapping[str, T]):
    """Map ct_whole, cn_whole, ft0_whole, fn0_whole to what is known of them, whole snake.

    Iterates under these names, so that none is mistaken for `ground`'s per-link values; the short
    ones (ct, cn, ft0, fn0), whole snake too, still find their value.
    """

    def __init__(self, values: Mapping[str, T]) -> None:
        self._values = {name.removesuffix(WHOLE): value for name, value in values.items()}

    def __getitem__(self, name: str) -> T:
        return self._values[name.removesuffix(WHOLE)]

    def __iter__(self) -> Iterator[str]:
        return (name + WHOLE for name in self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"WholeSnake({dict(self)})"


def narrowest(drawn: Floats, weight: Floats, value: float) -> tuple[float, float]:
    """Return the narrowest interval that holds LEVEL of weighted draws (N,), and value.

    It ends at 0 where a friction of 0 is as likely as any; one that cut off the same share at
    either end would never hold it.
    """
    order = np.argsort(drawn)
    share = np.cumsum(weight[order]) - weight[order] / 2
    tail = np.linspace(0.0, 1.0 - LEVEL, _TAILS)
    first, last = (np.interp(tail + more, share, drawn[order]) for more in (0.0, LEVEL))
    best = int(np.argmin(last - first))
    low = float(first[best]) if best else 0.0
    return max(min(low, value), 0.0), max(float(last[best]), value)


@dataclass(frozen=True, eq=False)
class FitDraws:
    """Draws of what a fit tells, each as likely as any other.

    names: frictions of the whole snake; in files of format 2 also what readings share. rows: (N,
    names), to six digits, as a file keeps them.
    """

    names: tuple[str, ...]
    rows: Floats

    def __post_init__(self) -> None:
        rows = [[float(f"{value:.6g}") for value in row] for row in self.rows.tolist()]
        shape = len(rows), len(self.names)
        object.__setattr__(self, "rows", np.array(rows, dtype=np.float64).reshape(shape))

    def __contains__(self, name: str) -> bool:
        return name in self.names

    def __getitem__(self, name: str) -> Floats:
        return self.rows[:, self.names.index(name)]  # type: ignore[no-any-return]

    def __len__(self) -> int:
        return len(self.rows)

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return {"order": list(self.names), "values": self.rows.tolist()}


@dataclass(frozen=True, eq=False, repr=False)
class FrictionFit(Result):
    """Hold the friction fitted to one session; print() gives a report of it.

    Attributes
    ----------
    method
        "joint" or "naive".
    sigma
        "absolute": from the stated uncertainties of the instruments. "rescaled": from the scatter.
    parameters
        name -> (value, sigma): ct_whole, cn_whole, N s/m, ft0_whole, fn0_whole, N, of the whole
        snake.
    intervals
        name -> (low, high) at 95 %, none below 0.
    covariance : (P, P)
        Of the whole snake's values, in the order of parameters.
    robot
        The robot measured.
    ground
        The fitted friction per link, as simulations take it.
    chi2, dof
        Of readings and priors under the stated uncertainties.
    nuisances
        name -> (value, sigma): lambda_offset_rad_at_..._deg of each bend and incline_zero_rad; none
        for "naive".
    residuals
        One for each kept reading, in standard deviations.
    influence
        One for each kept reading; none for "naive".
    notes, alarms
        Remarks in words; alarms are those notes that forbid to trust a prediction.
    session_name, session_sha256
        The session fitted, and the hash of what the fit rests on.
    draws
        Draws of the frictions, whole snake.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> fit = sn.fit_friction(session)
    >>> round(fit.parameters["cn_whole"].value, 2)  # of the whole snake, N s/m
    1.2
    """

    method: str
    sigma: str
    parameters: Mapping[str, Estimate]
    intervals: Mapping[str, tuple[float, float]]
    covariance: Floats
    robot: Robot
    ground: Ground
    chi2: float = 0.0
    dof: int = 0
    nuisances: Mapping[str, Estimate] = field(default_factory=dict[str, Estimate])
    residuals: tuple[float, ...] = ()
    influence: tuple[Influence, ...] = ()
    notes: tuple[str, ...] = ()
    alarms: tuple[str, ...] = ()
    session_name: str = ""
    session_sha256: str = ""
    draws: FitDraws = field(default_factory=lambda: FitDraws((), np.empty((0, 0))))

    @property
    def unmeasured(self) -> list[str]:
        """Return the notes on what nobody measured: every prediction rests on its prior."""
        return [note for note in self.notes if note.startswith((NOT_WEIGHED, NO_ZERO, NO_BELT))]

    @property
    def names(self) -> tuple[str, ...]:
        """Return the short names of what was fitted, in the order of the covariance."""
        return FRICTIONS

    @property
    def whole_snake(self) -> dict[str, float]:
        """Return ct, cn (N s/m), ft0, fn0 (N) of the whole snake."""
        return {name: self.parameters[name].value for name in self.names}

    def sample_whole(self, count: int = 64, seed: int = 2005) -> Floats:
        """Return draws of the whole snake's frictions that the readings allow, never below 0.

        Parameters
        ----------
        count, seed
            Number of draws, and the seed by which they are picked from the fit's.

        Returns
        -------
        (count, P) array
            N s/m and N, in the order of parameters.
        """
        return np.asarray(self.draws.rows[self._picked(count, seed), : len(self.names)])

    def _picked(self, count: int, seed: int) -> NDArray[np.intp]:
        """Return which of the draws stand for all.

        A few are those next to as many even points (Sobol), so that they are spread as all are:
        along each axis of the frictions' covariance draws are ranked, and ranks made normal.
        """
        check_number("count", count, 1, 2**20)
        whole = self.draws.rows[:, : len(self.names)]
        if count == len(whole):
            return np.arange(count)
        if _FEW * count > len(whole):
            return np.resize(np.random.default_rng(seed).permutation(len(whole)), count)
        from scipy.optimize import linear_sum_assignment
        from scipy.special import ndtri
        from scipy.stats import qmc

        spread = np.maximum(whole.std(axis=0), 1e-300)
        axes = np.linalg.svd((whole - whole.mean(axis=0)) / spread, full_matrices=False)[0]
        ranked = ndtri((axes.argsort(axis=0).argsort(axis=0) + 0.5) / len(whole))
        sobol = qmc.Sobol(whole.shape[1], seed=seed)  # pyright: ignore[reportCallIssue] (older SciPy)
        even = ndtri(sobol.random(1 << (count - 1).bit_length()))[:count]
        distance = np.sum((even[:, None] - ranked) ** 2, axis=2)
        return np.asarray(linear_sum_assignment(distance)[1])

    def sample(self, count: int = 64, seed: int = 2005) -> tuple[Ground, ...]:
        """Draw frictions per link that the readings allow, as simulations take them.

        Parameters
        ----------
        count, seed
            Number of draws and their seed, as for `sample_whole`: the same draws.

        Returns
        -------
        tuple of Ground
            `count` grounds.
        """
        draws = self.sample_whole(count, seed).tolist()
        return tuple(ground_of(self.robot.links, draw) for draw in draws)

    def __repr__(self) -> str:
        values = ", ".join(f"{r.name} {r.value:.4g} ± {r.sigma:.2g} {r.unit}" for r in self.rows())
        return f"<FrictionFit {self.session_name!r}, {self.method}: {values}>"

    def in_words(self) -> str:
        """Return along and across the snake what resists, each with its 95 % interval."""
        ct, cn, ft0, fn0 = (ranged(r.value, r.unit, r.low, r.high) for r in self.rows()[:4])
        return f"Along, the snake resists with {ft0} and {ct}; across, with {fn0} and {cn}."

    @property
    def remarks(self) -> list[str]:
        """Return friction of one link, whether the readings agree, and the notes."""
        links = self.robot.links
        parts = [f"{r.name} {r.value / links:.4g} {r.unit}" for r in self.rows()]
        text = ", ".join(parts).replace(WHOLE, "")
        notes = [f"note: {note}" for note in self.notes]
        agree = f"{self.session_name}, {self.method} fit: {self.chi2_in_words}"
        return [f"each of {links} links: {text}", agree, *notes]

    def __str__(self) -> str:
        return "\n".join([super().__str__(), *self.remarks])

    @property
    def chi2_in_words(self) -> str:
        """Return chi2, its degrees of freedom and its chance."""
        chance = "" if self.p_value is None else f" (p = {self.p_value:.2g})"
        return f"chi2 = {self.chi2:.3g} for {self.dof} degrees of freedom{chance}"

    @property
    def p_value(self) -> float | None:
        """Return p_value, the chance of so large a chi2 if model and uncertainties hold."""
        from scipy.special import chdtrc

        return float(chdtrc(self.dof, self.chi2)) if self.dof > 0 else None

    def rows(self) -> list[Row]:
        """Return a table's lines, one a parameter of the whole snake."""
        ends = self.intervals
        return [
            Row(name + WHOLE, UNITS[name], part.value, *ends[name], part.sigma)
            for name in self.names
            for part in (self.parameters[name],)
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return plain lists, numbers and text, fit for JSON."""
        return {
            "session": {"name": self.session_name, "sha256": self.session_sha256},
            "method": self.method,
            "sigma": self.sigma,
            "interval_level": LEVEL,
            "parameters": {
                row.name: {
                    "unit": row.unit,
                    "value": row.value,
                    "sigma": row.sigma,
                    "interval": [row.low, row.high],
                }
                for row in self.rows()
            },
            "covariance": {"order": list(self.parameters), "values": self.covariance.tolist()},
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
            "influence": [i.to_dict() for i in self.influence],
            **{name: list(getattr(self, name)) for name in ("alarms", "notes")},
            "draws": self.draws.to_dict(),
        }


def normal_draws(
    values: Floats, covariance: Floats, ends: Floats, count: int = 1024, seed: int = 2005
) -> Floats:
    """Return draws (count, P) of a fit that is known by values, covariance and intervals alone.

    Each parameter alone is normal on either side of its value, scaled by its interval on that side,
    or by the other side where the interval ends at 0. None is below 0.
    """
    sigma = np.sqrt(np.diag(covariance))
    sides = np.abs(ends.T - values)
    below, above = np.where(ends[:, 0] == 0.0, sigma, 2.0 * sigma * sides / sides.sum(axis=0))
    correlation = covariance / np.outer(sigma, sigma)
    rng = np.random.default_rng(seed)
    units = rng.multivariate_normal(np.zeros(len(values)), correlation, 64 * count)
    drawn = values + units * np.where(units < 0.0, below, above)
    inside_first = np.argsort((drawn < 0.0).any(axis=1), kind="stable")[:count]
    return np.maximum(drawn[inside_first], 0.0)


def fit_of(
    robot: Robot, values: Floats, covariance: Floats, ends: Floats, **more: Any
) -> FrictionFit:
    """Return a fit that has values, covariance and intervals; more: of its other fields."""
    covariance = covariance.copy()
    covariance.flags.writeable = False
    sigmas = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    pairs = zip(values.tolist(), sigmas.tolist(), strict=True)
    return FrictionFit(
        parameters=WholeSnake(dict(zip(FRICTIONS, (Estimate(*p) for p in pairs), strict=True))),
        intervals=WholeSnake(dict(zip(FRICTIONS, map(tuple, ends.tolist()), strict=True))),
        covariance=covariance,
        robot=robot,
        ground=ground_of(robot.links, values.tolist()),
        **more,
    )


def with_values(
    session: Session, values: Floats, covariance: Floats, ends: Floats, **more: Any
) -> FrictionFit:
    """Return a session's fit that has values, covariance and intervals; more: its other fields."""
    named = {"session_name": session.setup.name, "session_sha256": session.sha256}
    named |= {"method": "joint", "sigma": "absolute"} | more
    return fit_of(session.setup.robot, values, covariance, ends, **named)


def notes_on(fit: FrictionFit, session: Session) -> tuple[str, ...]:
    """Return what a reader of the numbers should know, in words."""
    notes = []
    if session.setup.provenance.kind == "regenerated":
        notes.append(
            "The readings are regenerated from published fits, not measured, and show no scatter; "
            "a joint fit's intervals come from assumed instrument uncertainties."
        )
    robot = session.setup.robot_table
    if not robot.weighs:
        notes.append(
            f"{NOT_WEIGHED}, and one per cent of mass is one per cent of friction: "
            f"weigh it, and write mass_kg = 0.48, say, into session.toml."
        )
    measured = session.setup.provenance.kind != "regenerated"
    if session.kept and not session.zero.readings and measured:
        sigma_rad = session.zero.sigma_rad or ZERO_SIGMA_RAD
        notes.append(
            f"{NO_ZERO}: 0 ± {np.degrees(sigma_rad):.2g} degrees are assumed, which is "
            f"± {sigma_rad * session.setup.weight_n:.2g} N of ft0. Read it both ways round; that "
            "takes a minute: `serpenoid calibrate add DIR zero incline_deg=0.1 reversed_deg=0`."
        )
    if session.zero_moved_sigmas > SURELY:
        notes.append(
            "The inclinometer's zero moved between before and after by more than its readings' "
            "errors: half of that is in the zero's uncertainty. Let it warm up, and measure again."
        )
    if any(r.lambda_rad and r.bend == "zigzag" for r in session.kept):
        notes.append(
            "The bent readings are of zigzags, every link at lambda (Eq. 60). A robot let go in "
            "one turns within a second, and is then not held by this law. Was it guided? If not, "
            "take them again in the balanced bend."
        )
    voided = len(session.readings) - len(session.kept)
    if voided:
        notes.append(f"{voided} voided reading(s) left out.")
    if fit.method == "naive":
        notes.append(
            "Naive intervals leave out the errors that readings share (bend, inclinometer zero, "
            "tangential friction in Eq. 61) and are too narrow."
        )
    if belt := belt_note(session):
        notes.append(belt)
    return (*weak_notes(fit), *notes)


def weak_notes(fit: FrictionFit) -> list[str]:
    """Return which frictions are known only roughly, in words."""
    notes, weak = [], []
    for name in fit.names:
        value, sigma = fit.parameters[name]
        if value == 0.0:
            notes.append(f"{name} ends at its limit of 0: only an upper end is known.")
        elif sigma > 0.25 * value:
            weak.append(f"{name} to {sigma / value:.0%}")
    if weak:
        notes.append(
            f"Known only roughly: {', '.join(weak)}. `serpenoid advise DIR` names the reading that "
            "makes speeds surer."
        )
    return notes
