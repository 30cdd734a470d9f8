"""The fit of a bench test: whether the model describes the table, and which servos it leaves.

The likeliest parameters come by least squares from several starts, for each rate at which a loop of
the kind may look. Samples about each maximum have the intervals. Where the model does not describe
the table, the noise is taken as large as what is left.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import BadInput
from ..base.particles import about_a_maximum
from ..model.drives import ServoKind
from .bench_test import NAMES, Array, BenchModel, BenchTest, shown

PARTICLES, MOVES, KEPT = 256, 100, 128
SEARCHED, STARTS = 1024, 8  # servos drawn; the best of them start least squares
PHASES = 8  # of the looks, from which a loop that looks now and then is fitted
WIDE = 1.5  # standard deviations of the priors that the search draws from
LEAST_P = 0.01  # below it the model does not describe the table
BLOCK_ROWS, LEAST_BLOCKS = 8, 5  # rows whose mean residual is tested; blocks beyond the parameters
OPEN = 0.6  # of the sigma before: a value that keeps more is open
FAR = 3.0  # standard deviations of the prior: beyond, a value is named
LEFT_OUT = 8.0  # below the highest log posterior: maxima and rates of the loop beyond are left out
SAME = 0.05  # standard deviations of the priors, between two maxima that are one


class Shown(NamedTuple):
    """The median of a value, its 95 % interval, and what sigma its logarithm had and has.

    A value that may be 0 or below has both sigmas in its own unit.
    """

    value: float
    low: float
    high: float
    before: float
    after: float

    @property
    def told(self) -> bool:
        """Tell whether the test determines it."""
        return self.after < OPEN * self.before


class Verdict(NamedTuple):
    """Whether the model describes a table: p-value, and the rows where residuals are largest.

    scale: the residuals' variance over that of the noise, at least 1; chi2: over the stated noise.
    """

    p_value: float
    worst_s: float
    worst_rad: float
    scale: float
    chi2: float
    noise_rad: float

    @property
    def describes(self) -> bool:
        """Tell whether the p-value is large enough."""
        return self.p_value >= LEAST_P

    @property
    def text(self) -> str:
        """Return the verdict in a sentence."""
        p = f"p {self.p_value:.2g}"
        if self.describes:
            return f"The model of a servo describes the table ({p})."
        return (
            f"The model of a servo does NOT describe the table ({p}): residuals are "
            f"{math.sqrt(self.scale):.2g} times the noise of {math.degrees(self.noise_rad):.2g} "
            f"deg, the largest at {self.worst_s:.3g} s, {math.degrees(self.worst_rad):+.2g} deg."
        )


@dataclass(frozen=True)
class MeasuredServo:
    """What a test leaves of a kind of servo.

    shown: values by name; outside: names of those far from what is usual for the kind, with by how
    many of its standard deviations. kind: with the remark of a test that the model does not
    describe.
    """

    kind: ServoKind
    shown: dict[str, Shown]
    verdict: Verdict
    readings: int
    outside: dict[str, float]

    @property
    def untold(self) -> list[str]:
        """Return the names of what the test leaves open."""
        return [n for n, one in self.shown.items() if one.before > 0 and not one.told]

    @property
    def notes(self) -> list[str]:
        """Return in words what is open, what is far from usual, and what pulls unstated."""
        notes = ["Open: " + ", ".join(self.untold) + "."] if self.untold else []
        if self.outside:
            far = ", ".join(f"{name} ({off:+.1f} sigma)" for name, off in self.outside.items())
            notes.append(f"Far from what is usual: {far}.")
        pull = max(
            (one for name, one in self.shown.items() if name.startswith("load_over") and one.told),
            key=lambda one: abs(one.value) / one.after,
            default=None,
        )
        if pull is not None and abs(pull.value) > FAR * pull.after:
            notes.append(
                f"Something pulls the joint with {abs(pull.value):.2g} of the motor's torque: if a "
                "load hangs on it, give --load KG M, which shows the torque itself."
            )
        if abs(math.log(abs(self.shown["gain"].value))) > FAR * self.shown["gain"].after:
            notes.append(
                f"A degree of the setpoint is {self.shown['gain'].value:.3g} degrees of the table: "
                "one of them is wrong, and the speed has both."
            )
        return notes

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        verdict = self.verdict
        return {
            "describes": verdict.describes,
            "p_value": verdict.p_value,
            "verdict": verdict.text,
            "worst": {"t_s": verdict.worst_s, "residual_rad": verdict.worst_rad},
            "noise_rad": verdict.noise_rad,
            "name": self.kind.name,
            "servo": asdict(self.kind.servo),
            "chi2": verdict.chi2,
            "readings": self.readings,
            "told": {name: one._asdict() for name, one in self.shown.items() if one.told},
            "untold": self.untold,
            "outside": self.outside,
            "notes": self.notes,
        }


@dataclass(frozen=True)
class _Fit:
    """Maxima of a model's posterior, the highest first: centres (M, P), roots of covariances.

    Where a joint with friction comes to rest makes several maxima: their heights (M,) are
    logarithms.
    """

    model: BenchModel
    noise_rad: float
    centres: Array
    roots: Array
    heights: Array

    def residuals(self) -> Array:
        """Return (T,) what the table has above the model, rad."""
        return self.model.test.angle_rad - self.model.angles(self.centres[:1])[0]

    def log_posterior(self, x: Array) -> Array:
        """Return (K,) logarithms of the posterior's density, but for a constant."""
        off = (self.model.angles(x) - self.model.test.angle_rad) / self.noise_rad
        return -0.5 * (np.sum(off**2, axis=1) + np.sum(x**2, axis=1))

    @property
    def determined(self) -> float:
        """Return how many parameters the table determines."""
        return self.centres.shape[1] - float(np.sum(self.roots[0] ** 2))

    @property
    def masses(self) -> Array:
        """Return (M,) logarithms of the mass about each maximum, if it is normal there."""
        return self.heights + np.linalg.slogdet(self.roots)[1]


def _fitted(model: BenchModel, noise_rad: float, starts: Array) -> _Fit:
    """Return the maxima that least squares reach from starts (S, P)."""
    from scipy.optimize import least_squares

    def residuals(x: Array) -> Array:
        off = (model.angles(np.atleast_2d(x)) - model.test.angle_rad) / noise_rad
        return np.hstack([off, np.atleast_2d(x)])

    steps = model.difference_steps

    def jacobian(x: Array) -> Array:
        moved = residuals(np.vstack([x + np.diag(steps), x - np.diag(steps)]))
        return (moved[: x.size] - moved[x.size :]).T / (2 * steps)

    found = [
        least_squares(lambda x: residuals(x)[0], start, jac=jacobian, max_nfev=60)  # pyright: ignore[reportArgumentType] (SciPy's stubs)
        for start in starts
    ]
    found.sort(key=lambda one: one.cost)
    kept: list[Any] = []
    for one in found:
        near = any(np.abs(one.x - other.x).max() < SAME for other in kept)
        if not near and one.cost < found[0].cost + LEFT_OUT:
            kept.append(one)
    roots = [np.linalg.cholesky(np.linalg.inv(one.jac.T @ one.jac)) for one in kept]
    centres, heights = np.array([one.x for one in kept]), np.array([-one.cost for one in kept])
    return _Fit(model, noise_rad, centres, np.array(roots), heights)


def _drawn(model: BenchModel, rng: np.random.Generator) -> Array:
    """Return parameters (K, P) spread evenly over priors that are somewhat wider; no step late."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    even = qmc.Sobol(len(model.names), seed=rng).random(SEARCHED)  # pyright: ignore[reportCallIssue] (older SciPy)
    drawn = WIDE * ndtri(np.clip(even, 1e-9, 1 - 1e-9))
    drawn[:, model.step_columns] = 0.0
    return drawn


def _best(model: BenchModel, x: Array, count: int) -> Array:
    """Return the parameters whose angles are nearest to the table's, the nearest first."""
    off = np.sum((model.angles(x) - model.test.angle_rad) ** 2, axis=1)
    return x[np.argsort(off)[:count]]


def _searched(model: BenchModel, noise_rad: float, rng: np.random.Generator) -> _Fit:
    """Return the fit of a loop that always looks, from the best of many servos that are drawn."""
    return _fitted(model, noise_rad, _best(model, _drawn(model, rng), STARTS))


def _held(model: BenchModel, free: _Fit, rng: np.random.Generator) -> _Fit:
    """Return the fit of a loop that looks now and then, from that of one that always looks.

    Which look hears a setpoint first makes the angles jump with delays and with the looks' phase.
    So a loop whose setpoints are blended is fitted first, which has no jumps. Then each delay is
    moved by whole looks as long as that helps.
    """
    from scipy.special import ndtri

    names, look_s = model.names, 1 / model.update_hz
    known = dict(zip(free.model.names, free.centres[0], strict=True))
    columns = [names.index("delay"), *model.step_columns]
    starts = np.vstack([_drawn(model, rng), [[known.get(name, 0.0) for name in names]] * PHASES])
    starts[-PHASES:, names.index("look")] = ndtri((np.arange(PHASES) + 0.5) / PHASES)
    for name in ("zero", "gain", "start", *(names[k] for k in columns)):
        starts[:, names.index(name)] = known[name]
    starts[:, columns[0]] -= 0.5 * look_s / model.prior.delay_s
    smooth = replace(model, blend=True)
    starts = np.vstack([_best(smooth, starts[:-PHASES], STARTS), starts[-PHASES:]])
    starts = _fitted(smooth, free.noise_rad, starts).centres[:STARTS]
    shifts = np.zeros((2 * len(columns) + 3, len(names)))
    for k, at in enumerate(columns):
        own = model.prior.delay_s if k == 0 else model.prior.step_delay_s
        shifts[2 * k + 1, at] = look_s / own
        shifts[2 * k + 2, at] = -look_s / own
    shifts[-2:, names.index("look")] = 0.1, -0.1

    def moved(x: Array) -> Array:
        for _ in range(4 * len(columns)):
            better = _best(model, x + shifts, 1)[0]
            if (better == x).all():
                break
            x = better
        return x

    first = _fitted(model, free.noise_rad, np.array([moved(x) for x in starts]))
    again = [moved(centre) for centre in first.centres]
    return _fitted(model, free.noise_rad, np.array(again))


def _highest(fit: _Fit) -> float:
    return float(fit.heights[0])


def _verdict(fit: _Fit) -> Verdict:
    """Return whether residuals are as large as the noise, and have no pattern.

    Two tests: the sum of squares over the noise that was stated; and means of neighbouring rows,
    which scatter as their rows do if errors of rows are independent.
    """
    from scipy.special import chdtrc, fdtrc

    test, residual = fit.model.test, fit.residuals()
    chi2 = float(np.sum((residual / fit.noise_rad) ** 2))
    freedom = residual.size - fit.determined
    blocks = np.array_split(residual, max(residual.size // BLOCK_ROWS, 1))
    means = np.array([block.mean() * math.sqrt(block.size) for block in blocks])
    within = sum(float(np.sum((block - block.mean()) ** 2)) for block in blocks)
    within /= residual.size - len(blocks)
    ps, scale = [], chi2 / max(freedom, 1.0)
    if test.sigma_rad is not None:
        ps.append(float(chdtrc(max(freedom, 1.0), chi2)))
    between = len(blocks) - fit.determined
    if between >= LEAST_BLOCKS:
        floor = _resolution(test) ** 2 / 12
        ratio = float(np.sum(means**2)) / between / max(within, floor, 1e-18)
        ps.append(float(fdtrc(between, residual.size - len(blocks), ratio)))
        scale = max(scale, float(np.sum(means**2)) / between / fit.noise_rad**2)
    elif not ps:
        ps.append(float(chdtrc(max(freedom, 1.0), chi2)))
    worst = int(np.argmax(np.abs(means)))
    row = sum(block.size for block in blocks[:worst]) + blocks[worst].size // 2
    return Verdict(
        min(1.0, len(ps) * min(ps)),
        float(test.t_s[row]),
        float(blocks[worst].mean()),
        max(scale, 1.0),
        chi2,
        fit.noise_rad,
    )


def _resolution(test: BenchTest) -> float:
    """Return the smallest difference between two angles of the table, rad."""
    steps = np.diff(np.unique(np.round(test.angle_rad, 9)))
    return float(steps.min()) if steps.size else 0.0


def _sampled(fits: list[_Fit], rng: np.random.Generator) -> list[tuple[_Fit, Array]]:
    """Return samples (K, P) for each rate of the loop, by the mass about its maxima."""
    masses = np.concatenate([fit.masses for fit in fits])
    share = np.cumsum(np.exp(masses - masses.max()))
    counts = iter(np.diff(np.round(PARTICLES * share / share[-1]), prepend=0.0).astype(int))
    samples = []
    for fit in fits:
        clouds = [
            about_a_maximum(centre, root, fit.log_posterior, count, MOVES, int(rng.integers(2**31)))
            for centre, root, count in zip(fit.centres, fit.roots, counts, strict=False)
            if count
        ]
        if clouds:
            samples.append((fit, np.vstack(clouds)))
    return samples


def servo_of_test(
    test: BenchTest, like: ServoKind, *, name: str = "measured", seed: int = 0
) -> MeasuredServo:
    """Return what a test of one joint leaves of a kind of servo. Raises BadInput."""
    if like.exact or like.drawn:
        raise BadInput(
            f"servo {like.name!r} has no uncertainty to fit; take `hobby`, or a data sheet's"
        )
    rng, noise = np.random.default_rng(seed), test.noise_rad
    free = _searched(BenchModel(test, like, 0.0), noise, rng)
    rates = {*(like.updates_hz or (like.servo.update_hz,))} - {0.0}
    fits = [free, *(_held(BenchModel(test, like, hz), free, rng) for hz in sorted(rates))]
    best = max(fits, key=_highest)
    if not _verdict(best).describes:  # loops that look now and then have many maxima: once more
        again = [_held(fit.model, best, rng) for fit in fits[1:]]
        fits[1:] = [max(pair, key=_highest) for pair in zip(fits[1:], again, strict=True)]
        best = max(fits, key=_highest)
    verdict = _verdict(best)
    if not verdict.describes:
        noise *= math.sqrt(verdict.scale)
        fits = [_fitted(fit.model, noise, fit.centres) for fit in fits]
    least = max(map(_highest, fits)) - LEFT_OUT
    fits = [fit for fit in fits if _highest(fit) > least]
    samples = _sampled(fits, rng)
    servos = [one for fit, x in samples for one in fit.model.servos(x, rng)]
    typical = best.model.servos(best.centres[:1], rng)[0]
    order = rng.permutation(len(servos))[:KEPT]
    kept = tuple(servos[k] for k in order)
    source = f"a bench test of one joint, from {like.name}"
    remark = "" if verdict.describes else verdict.text
    kind = ServoKind(name, typical, {}, (), source, kept, remark)
    return MeasuredServo(kind, _shown(samples, rng), verdict, test.t_s.size, _outside(samples))


def _quantities(parts: list[tuple[_Fit, Array]], rng: np.random.Generator) -> dict[str, Array]:
    """Return each value that a test may show, of all samples."""
    columns: dict[str, list[Array]] = {}
    for fit, x in parts:
        servos = [shown(servo) for servo in fit.model.servos(x, rng)]
        rows = {name: np.array([one[name] for one in servos]) for name in servos[0]}
        for name, values in (rows | fit.model.beside(x)).items():
            columns.setdefault(name, []).append(values)
    return {name: np.concatenate(parts) for name, parts in columns.items()}


def _shown(samples: list[tuple[_Fit, Array]], rng: np.random.Generator) -> dict[str, Shown]:
    """Return the values with their intervals, and what was known of them before."""
    fit = samples[0][0]
    before = _quantities([(fit, rng.normal(size=(512, fit.centres.shape[1])))], rng)
    values = {}
    for name, after in _quantities(samples, rng).items():
        middle, low, high = np.quantile(after, (0.5, 0.025, 0.975)).tolist()
        pair = before[name], after
        if min(before[name].min(), after.min()) > 0:
            pair = np.log(pair[0]), np.log(pair[1])
        values[name] = Shown(middle, low, high, float(pair[0].std()), float(pair[1].std()))
    return values


def _outside(samples: list[tuple[_Fit, Array]]) -> dict[str, float]:
    """Return the parameters that lie far from what is usual, and by how many sigma."""
    fit, x = max(samples, key=lambda part: len(part[1]))
    middle = np.median(x, axis=0).tolist()
    far = {name: off for name, off in zip(fit.model.names, middle, strict=True) if abs(off) > FAR}
    return {NAMES.get(name, name): off for name, off in far.items()}
