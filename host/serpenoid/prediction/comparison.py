"""Compare measured gait runs with the speeds predicted from the session's own friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from ..base.checks import check_kind, check_number, count_text
from ..base.errors import BadInput, NotConverged
from ..base.rows import Plottable
from ..base.vectors import Array, columns
from ..friction.fit import fit_friction
from ..friction.result import FrictionFit
from ..model.drives import ServoKind
from ..model.gait import Gait, gait_name
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import highest_hz, too_fast_text
from ..session.crawls import Crawls, crawls_by_command, driving, mean_speed, same_command
from ..session.gait_run import Crawl
from ..session.session import Session
from ..simulation.steady_springs import steady_springs
from .level import SLOPES, level_run, slope_in_words
from .speeds import (
    AMPLITUDE_SIGMA,
    SAMPLES,
    Progress,
    Samples,
    SpeedBand,
    draw_samples,
    predict,
)
from .verdict import Factor, Predicted, best_factors

MIN_P_VALUE = 0.05  # p-value below which the measured speeds differ from the prediction.


@dataclass(frozen=True, eq=False)
class ComparedGait(SpeedBand):
    """One gait: its band, its measured speed, and the speed by the paper's implicit model.

    level_runs: the measured runs, corrected to level ground by `level_run`.
    slope_shares: (samples,), ratios of the speed on a sampled slope to that on the mean slope.
    runs: numbers of the measured runs in the session.
    measured_m_s, sigma_m_s: mean of the measured speeds, and its standard uncertainty.
    residual_m_s: measured speed less the exact model's.
    implicit_m_s, implicit_error_m_s: the implicit model's speed and its error estimate, for a gait
    that was run; None if its springs do not settle.
    """

    level_runs: tuple[Crawl, ...] = ()
    slope_shares: Array = field(default_factory=lambda: np.ones(1))
    runs: tuple[int, ...] = ()
    measured_m_s: float | None = None
    sigma_m_s: float | None = None
    residual_m_s: float | None = None
    implicit_m_s: float | None = None
    implicit_error_m_s: float | None = None

    @property
    def judged(self) -> bool:
        """Return whether the gait was run and servos can follow it."""
        return bool(self.runs) and not self.too_fast

    def to_dict(self) -> dict[str, Any]:
        """Return the gait's angles and frequency, then its speeds by name, for JSON."""
        angles = {"alpha_rad": self.gait.alpha_rad, "beta_rad": self.gait.beta_rad}
        speeds_m_s = super().to_dict() | {"exact_m_s": self.exact_m_s}
        return angles | {"frequency_hz": self.frequency_hz} | speeds_m_s

    def cells(self) -> list[str]:
        """Return the cells of a comparison's row: the gait, and its speeds in m/s."""
        measured = f"{self.measured_m_s:.4f} ± {self.sigma_m_s:.4f}" if self.runs else "–"
        band_text = "too fast" if self.too_fast else f"{self.low_m_s:.3g} to {self.high_m_s:.3g}"
        implicit = "–" if self.implicit_m_s is None else f"{self.implicit_m_s:.4f}"
        friction = f"{self.low_friction_m_s:.3g} to {self.high_friction_m_s:.3g}"
        speeds = measured, band_text, implicit, f"{self.exact_m_s:.4f}", friction
        return [gait_name(self.gait), *speeds]


@dataclass(frozen=True, eq=False)
class Comparison(Plottable):
    """Hold the predicted and the measured speeds of a session, and the verdict.

    Attributes
    ----------
    session
        Name of the session.
    amplitude_sigma
        Relative standard deviation of the joints' amplitude, as given.
    gaits
        The gaits that were run, or the planned ones if none was. Gaits that the servos cannot
        follow come last, without a band, and do not count for the verdict.
    p_value
        Probability of speeds at least as far from the prediction if model, fit and stated errors
        hold; None if no gait counts.
    friction
        Factor on all friction that would explain the speeds best, with its p-value; None if the
        speeds agree.
    amplitude
        Factor on the joints' amplitude that would explain the speeds best, with its p-value; None
        if the speeds agree.
    verdict
        "agrees", "differs", "not measured", or "not judged".
    verdict_text
        The verdict in words.
    servo
        The kind of servo; None for joints that follow the gait.
    fit
        The friction fit behind the predictions.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> compared = sn.compare(session, gaits=[gait], servo=None, samples=16)
    >>> compared.gaits[0].low_m_s < compared.gaits[0].high_m_s
    True
    """

    session: str
    amplitude_sigma: float
    gaits: tuple[ComparedGait, ...]
    p_value: float | None
    friction: Factor | None
    amplitude: Factor | None
    verdict: str
    verdict_text: str
    servo: ServoKind | None = None
    fit: FrictionFit | None = None

    def in_words(self) -> str:
        """Return the verdict."""
        return self.verdict_text

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return heads and rows, a row for each gait; verbose adds the band from friction alone.

        Measured speeds are shown if there are any, else only the predicted ones.
        """
        servos = "" if self.servo is None else f", {self.servo.name} servos"
        heads = ["gait", "measured, m/s", f"95 %{servos}, m/s", "implicit\nmodel", "ideal\njoints"]
        lines = [[*heads, "95 % friction"], *(gait.cells() for gait in self.gaits)]
        first = 1 if any(gait.runs for gait in self.gaits) else 2
        last = None if verbose else 5
        heads, *cells = [[line[0], *line[first:last]] for line in lines]
        return heads, cells

    def to_dict(self) -> dict[str, Any]:
        """Return the attributes by name for JSON; fit_alarms only if there are any."""
        values: dict[str, Any] = vars(self).copy()
        values["gaits"] = [gait.to_dict() for gait in self.gaits]
        for name in ("friction", "amplitude"):
            values[name] = values[name] and asdict(values[name])
        values["servo"] = self.servo and self.servo.name
        fit = values.pop("fit")
        return values | ({"fit_alarms": fit.alarms} if fit and fit.alarms else {})


def compare(
    session: Session,
    fit: FrictionFit | None = None,
    *,
    gaits: Sequence[Gait] = (),
    amplitude_sigma: float = AMPLITUDE_SIGMA,
    servo: ServoKind | None = HOBBY,
    samples: int = SAMPLES,
    seed: int = 2005,
    progress: Progress | None = None,
) -> Comparison:
    """Compare a session's gait runs with the speeds predicted from its friction.

    The bands come from samples, because the distribution of speed is skewed if wheels stick.

    Parameters
    ----------
    session
        The session with the gait runs.
    fit
        The friction: the session's own joint fit unless given.
    gaits
        Further gaits to predict.
    amplitude_sigma
        Standard deviation of the ratio of true to commanded amplitude, common to all gaits.
    servo
        The kind of servo that moves the joints, an unknown hobby servo unless given. None: the
        joints follow the gait.
    samples
        Number of samples of friction, amplitude and servo.
    seed
        Seed of the random samples.
    progress
        Function called with the share of the gaits done, 0 to 1.

    Returns
    -------
    Comparison
        Speeds, bands, the p-value and the verdict.

    Raises
    ------
    BadInput
        If no gait was run, planned or given.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> compared = sn.compare(session, gaits=[gait], servo=None, samples=16)
    >>> len(compared.gaits)
    1
    """
    check_kind("session", session, Session)
    check_number("amplitude_sigma", amplitude_sigma, 0.0, 0.5)
    fit = fit or fit_friction(session)
    asked_gaits = compared_gaits(session, gaits)
    if not asked_gaits:
        raise BadInput(
            f"{session.where}: no gait was run and none is planned; give one, or take a run with "
            "`serpenoid calibrate`"
        )
    servo = servo and driving(session.setup, servo)
    crawls = {crawl.gait: crawl for crawl in crawls_by_command(session)}
    drawn = draw_samples(fit, servo, amplitude_sigma, samples, seed)
    rows = []
    for count, gait in enumerate(asked_gaits, 1):
        rows.append(_compared_gait(session, drawn, gait, crawls.get(gait), seed))
        if progress is not None:
            progress(count / len(asked_gaits))
    rows.sort(key=lambda row: bool(row.too_fast))
    judged = [row for row in rows if row.judged]
    p_value, friction, amplitude = None, None, None
    if judged:
        predicted = _predicted(judged)
        p_value = predicted.p_value(seed)
        if p_value < MIN_P_VALUE:
            commands = [row.level_runs[0].commanded if row.filmed else None for row in judged]
            judged_gaits = [row.gait for row in judged]
            pairs = list(zip(judged_gaits, commands, strict=True))
            friction, amplitude = best_factors(predicted, fit, pairs, servo, seed)
    verdict, text = _verdict(rows, judged, p_value, servo)
    too_fast = [too_fast_text(row.gait, servo, gait_name(row.gait)) for row in rows if row.too_fast]
    words = [text, _explained(friction, amplitude), servo.remark if servo else "", *too_fast]
    words += [*map(_joints_as_filmed, crawls.values()), slope_in_words(session, fit)]
    return Comparison(
        session.setup.name,
        amplitude_sigma,
        tuple(rows),
        p_value,
        friction,
        amplitude,
        verdict,
        " ".join(filter(None, words)),
        servo=servo,
        fit=fit,
    )


def _predicted(judged: Sequence[ComparedGait]) -> Predicted:
    """Return the sampled and the measured speeds of the judged gaits."""
    drawn_m_s = np.stack([row.samples_m_s for row in judged], axis=2)
    servo_shares = drawn_m_s[2] / np.maximum(drawn_m_s[1], 1e-9)
    slopes = np.stack([row.slope_shares for row in judged], axis=1)
    measured = np.array([mean_speed(row.level_runs) for row in judged])
    return Predicted(drawn_m_s[1], servo_shares, slopes, *measured.T)


def compared_gaits(session: Session, more: Sequence[Gait] = ()) -> list[Gait]:
    """Return the gaits that were run, or the planned ones if none was, and further ones."""
    crawls = crawls_by_command(session)
    commands = [crawl.commanded for crawl in crawls] or list(session.setup.plan.gaits)
    gaits = [crawl.gait for crawl in crawls] or commands
    return gaits + [g for g in more if not any(same_command(command, g) for command in commands)]


def _joints_as_filmed(crawl: Crawls) -> str:
    """Return the amplitude that films of a gait show, in words; "" if it was not filmed."""
    if not crawl.films:
        return ""
    numbers = " and ".join(f"film {film.number}" for film in crawl.films)
    gain = float(np.mean([film.gait.joint_gain for film in crawl.films]))
    sigma = math.hypot(*(film.gain_sigma for film in crawl.films)) / len(crawl.films)
    return (
        f"Joints in {numbers} reach {gain:.1%} ± {sigma:.1%} of the commanded amplitude; the "
        "prediction uses this."
    )


def _compared_gait(
    session: Session, samples: Samples, gait: Gait, crawl: Crawls | None, seed: int
) -> ComparedGait:
    """Return the row of one gait; crawl: its runs, None if it was not run."""
    band = predict(samples, gait, crawl.commanded if crawl and crawl.films else None)
    if crawl is None:
        return ComparedGait(**vars(band))
    servo = samples.kind and samples.kind.servo
    pairs = [level_run(session, samples.fit, crawl, run, servo, seed) for run in crawl.runs]
    runs, shares = zip(*pairs, strict=True)
    slope_shares = np.mean(shares, axis=0)
    slope_sigma = 0.0 if crawl.runs[0].way == "level" else float(slope_shares.std())
    measured_m_s, sigma_m_s = mean_speed(runs)
    springs = None
    with suppress(NotConverged):  # Heavy links swing on the paper's springs.
        springs = steady_springs(samples.fit.robot, samples.fit.ground, gait, rtol=1e-3)
    return ComparedGait(
        **vars(band),
        level_runs=runs,
        slope_shares=slope_shares,
        runs=tuple(run.number for run in runs),
        measured_m_s=measured_m_s,
        sigma_m_s=math.hypot(sigma_m_s, slope_sigma * measured_m_s),
        residual_m_s=measured_m_s - band.exact_m_s,
        implicit_m_s=springs and springs.speed_m_s,
        implicit_error_m_s=springs and springs.error_estimate * springs.speed_m_s,
    )


def _verdict(
    rows: Sequence[ComparedGait],
    judged: Sequence[ComparedGait],
    p_value: float | None,
    servo: ServoKind | None,
) -> tuple[str, str]:
    """Return the verdict as a key of JSON has it, and as a sentence."""
    if not any(row.runs for row in rows):
        text = "No gait was run yet: these are predictions. Run one, and compare again."
        return "not measured", text
    if p_value is None:
        return "not judged", "Not judged: the servos cannot follow any gait that was run."
    measured, predicted = columns(judged, "measured_m_s", "speed_m_s")
    differences = measured / np.maximum(predicted, 1e-9) - 1.0
    worst = int(np.abs(differences).argmax())
    joints = "ideal joints" if servo is None else f"servos ({servo.name})"
    count = count_text(len(judged), "gait")
    largest = (
        f"the largest difference from the prediction with {joints} is {differences[worst]:+.1%}, "
        f"at {judged[worst].frequency_hz:.3g} Hz"
    )
    chance = f"p = {p_value:.2g}" if p_value else f"p < {1 / SLOPES:.1g}"
    if p_value < MIN_P_VALUE:
        return "differs", f"Differs: {largest} ({chance}, {count})."
    what = f"speed of {count} is" if len(judged) == 1 else f"speeds of {count} are"
    allowed = f"likely enough by what friction, joints and servos allow ({chance}; {largest})"
    return "agrees", f"Agrees: the {what} {allowed}."


def _explained(friction: Factor | None, amplitude: Factor | None) -> str:
    """Return in words which of the two factors would explain the speeds; "" without factors."""
    if not friction or not amplitude:
        return ""
    causes = {
        f"all friction times {friction.factor:.2g}": friction.p_value,
        f"joints that reach {amplitude.factor:.0%} of the amplitude": amplitude.p_value,
    }
    likely = [f"{words} (p = {p:.2g})" for words, p in causes.items() if p >= MIN_P_VALUE]
    if likely:
        return f"It would be explained by {' or by '.join(likely)}. Measure that first."
    return (
        "No one factor on friction or on amplitude explains it: check the ground's slope, the "
        "surface, the tape and the watch, the frequency, and the gait itself."
    )


@lru_cache(maxsize=1)  # the picture and the page of a comparison share it
def speed_curves(compared: Comparison) -> dict[tuple[float, float], list[SpeedBand]]:
    """Return bands at rising frequencies that servos can follow, by amplitude and phase lag."""
    fit, servo = compared.fit, compared.servo
    if fit is None:
        return {}
    samples = draw_samples(fit, servo, compared.amplitude_sigma)
    rates_hz = [row.frequency_hz for row in compared.gaits]
    first_hz, max_hz = 0.6 * min(rates_hz), 1.3 * max(rates_hz)
    curves = {}
    for shape in dict.fromkeys((row.gait.alpha_rad, row.gait.beta_rad) for row in compared.gaits):
        last_hz = min(max_hz, highest_hz(Gait(*shape, math.tau), servo)) if servo else max_hz
        # A band's ends scatter by more than the error of straight lines between 12 points.
        frequency_hz = np.linspace(min(first_hz, 0.6 * last_hz), last_hz, 12).tolist()
        curves[shape] = [predict(samples, Gait(*shape, math.tau * hz)) for hz in frequency_hz]
    return curves
