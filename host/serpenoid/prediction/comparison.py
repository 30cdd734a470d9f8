"""Measured gait runs beside the speeds that the session's own friction predicts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import check_kind, check_number, count_text
from ..base.errors import BadInput, NotConverged
from ..base.rows import Plottable
from ..base.vectors import Array
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
from .band import SpeedBand, predict
from .level import level_session
from .speeds import AMPLITUDE_SIGMA, SAMPLES, Progress, draw_samples
from .verdict import SIMULATED, Factor, Predicted, best_factors

DOUBTFUL = 0.05  # p-value below which speeds differ from the prediction
NORMAL_95 = 1.96  # standard deviations within which 95 % of normal errors lie
SPRINGS_RTOL = 1e-3
NO_GAIT = "no gait run and no gait planned; give one, or take a run with `serpenoid calibrate`"
NOT_MEASURED = "No gait was run yet: these are predictions. Run one, and compare again."


@dataclass(frozen=True)
class ComparedGait:
    """One gait: predicted by exact and implicit model, with its 95 % bands, and measured.

    exact_m_s: of joints that follow the gait. typical_m_s: with the typical servo. low_m_s,
    high_m_s: of the frictions that the fit allows. low_all_m_s, high_all_m_s: with the joints'
    amplitude and the servos besides; None where the gait is too fast for them, and is not judged.
    runs: numbers of the measured runs; measured_m_s, sigma_m_s: their mean and its standard
    deviation; none if not measured. residual_m_s: measured less exact. implicit_m_s,
    implicit_error_m_s: of the paper's springs, for a gait that was run; None where they never
    settle.
    """

    alpha_rad: float
    beta_rad: float
    frequency_hz: float
    exact_m_s: float
    typical_m_s: float
    low_m_s: float
    high_m_s: float
    low_all_m_s: float | None
    high_all_m_s: float | None
    implicit_m_s: float | None = None
    implicit_error_m_s: float | None = None
    runs: tuple[int, ...] = ()
    measured_m_s: float | None = None
    sigma_m_s: float | None = None
    residual_m_s: float | None = None

    @property
    def judged(self) -> bool:
        """Return whether the gait was run and servos can follow it."""
        return bool(self.runs) and self.low_all_m_s is not None

    @property
    def outside(self) -> bool:
        """Return whether a judged speed is outside its band, by more than its own error."""
        low, high, measured = self.low_all_m_s, self.high_all_m_s, self.measured_m_s
        if low is None or high is None or measured is None:
            return False
        error = NORMAL_95 * (self.sigma_m_s or 0.0)
        return not low - error <= measured <= high + error

    @property
    def name(self) -> str:
        """Return the gait's angles and frequency."""
        return gait_name(Gait(self.alpha_rad, self.beta_rad, math.tau * self.frequency_hz))

    def cells(self) -> list[str]:
        """Return the gait and its speeds, m/s, as in the heads of a comparison."""
        measured = f"{self.measured_m_s:.4f} ± {self.sigma_m_s:.4f}" if self.runs else "–"
        band_text, implicit = "too fast", "–"
        if self.low_all_m_s is not None:
            band_text = f"{self.low_all_m_s:.3g} to {self.high_all_m_s:.3g}"
        if self.implicit_m_s is not None:
            implicit = f"{self.implicit_m_s:.4f} ± {self.implicit_error_m_s:.1g}"
        friction = f"{self.low_m_s:.3g} to {self.high_m_s:.3g}"
        return [self.name, measured, band_text, implicit, f"{self.exact_m_s:.4f}", friction]


@dataclass(frozen=True, eq=False)
class Comparison(Plottable):
    """Hold the predicted and the measured speeds of a session, and the verdict.

    Attributes
    ----------
    session
        Name of the session.
    amplitude_sigma
        Stated standard deviation of the joints' amplitude, relative.
    gaits
        The gaits that were run; the planned ones if none was. Those that the servos cannot follow
        come last, without a band, and are not judged.
    measured
        All runs that were kept; those along a floor's slope as they would be on level ground.
    p_value
        The chance of speeds so far from the predicted ones if model, fit and stated errors hold;
        None if no gait was judged.
    friction
        The one factor on all friction that would explain the speeds best, with its p-value; None
        where the speeds agree.
    amplitude
        The one factor on the joints' amplitude that would, with its p-value; None where they agree.
    verdict
        "agrees", "differs", "not measured", or "not judged".
    verdict_text
        The verdict in words.
    servo
        The kind of servo; None for joints that follow the gait.
    fit
        The friction that the predictions rest on.
    highest_hz
        Frequency up to which the first gait is not too fast for such servos, Hz; None without.

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
    measured: tuple[Crawl, ...]
    p_value: float | None
    friction: Factor | None
    amplitude: Factor | None
    verdict: str
    verdict_text: str
    servo: ServoKind | None = None
    fit: FrictionFit | None = None
    highest_hz: float | None = None

    def in_words(self) -> str:
        """Return the verdict."""
        return self.verdict_text

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return one line for each gait, m/s: measured, with joints and servos, implicit, ideal."""
        servos = "" if self.servo is None else f" and servos ({self.servo.name})"
        heads = ["gait", "measured, m/s", f"95 % with joints{servos}, m/s", "implicit\nmodel"]
        heads += ["ideal\njoints", "95 % friction"]
        lines = [heads, *(gait.cells() for gait in self.gaits)]
        first = 1 if self.measured else 2
        last = None if verbose else 5
        heads, *cells = [[line[0], *line[first:last]] for line in lines]
        return heads, cells

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name; fit_alarms only where there are any."""
        numbers = [run.number for run in self.measured]
        values = asdict(replace(self, servo=None, fit=None, measured=numbers))
        values["servo"] = self.servo and self.servo.name
        del values["fit"]
        alarms = self.fit and self.fit.alarms
        return values | {"fit_alarms": alarms} if alarms else values


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
    """Compare a session's gait runs with the speeds that its friction predicts.

    Frictions are sampled, because the distribution of speed is skewed where wheels stick.

    Parameters
    ----------
    session
        The session with the gait runs.
    fit
        The friction: the session's own joint fit unless given.
    gaits
        Further gaits to predict.
    amplitude_sigma
        Standard deviation of true over commanded amplitude, common to all gaits.
    servo
        The kind that moves the joints, any hobby servo unless given. None: they follow the gait.
    samples
        Number of frictions drawn.
    seed
        Seed of the draw.
    progress
        Called with the share of the gaits done, 0 to 1.

    Returns
    -------
    Comparison
        Speeds, bands, the p-value and the verdict.

    Raises
    ------
    BadInput
        If there is neither a run nor a gait.

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
        raise BadInput(f"{session.where}: {NO_GAIT}")
    servo = servo and driving(session.setup, servo)
    level, slope_doubts, slope_text = level_session(session, fit, servo and servo.servo, seed)
    crawls = {crawl.gait: crawl for crawl in crawls_by_command(level)}
    commands = {gait: crawl.commanded for gait, crawl in crawls.items() if crawl.films}
    unfilmed = [gait for gait in asked_gaits if gait not in commands]
    too_fast = {gait: too_fast_text(gait, servo, gait_name(gait)) for gait in unfilmed}
    asked_gaits.sort(key=lambda gait: bool(too_fast.get(gait)))
    drawn = draw_samples(fit, servo, amplitude_sigma, samples, seed)
    bands: dict[Gait, SpeedBand] = {}
    for gait in asked_gaits:
        bands[gait] = predict(drawn, gait, commands.get(gait))
        if progress is not None:
            progress(len(bands) / len(asked_gaits))
    slope_shares = {
        g: np.mean([slope_doubts[r.number] for r in c.runs], axis=0) for g, c in crawls.items()
    }
    sigmas = {gait: float(share.std()) for gait, share in slope_shares.items() if slope_text}
    shown = [_compared(fit, g, bands[g], crawls.get(g), sigmas.get(g, 0.0)) for g in asked_gaits]
    judged = [gait for gait, row in zip(asked_gaits, shown, strict=True) if row.judged]
    p_value, friction, amplitude = None, None, None
    if judged:
        pairs = [(gait, commands.get(gait)) for gait in judged]
        predicted = _predicted(judged, bands, crawls, slope_shares)
        p_value, friction, amplitude = _tested(predicted, pairs, fit, servo, seed)
    verdict, text = _verdict(shown, p_value, servo)
    text += _explained(friction, amplitude)
    text = f"{text} {servo.remark}".rstrip() if servo else text
    words = [text, *too_fast.values(), *map(_joints_as_filmed, crawls.values()), slope_text]
    return Comparison(
        session.setup.name,
        amplitude_sigma,
        tuple(shown),
        level.kept_crawls,
        p_value,
        friction,
        amplitude,
        verdict,
        " ".join(filter(None, words)),
        servo=servo,
        fit=fit,
        highest_hz=servo and highest_hz(asked_gaits[0], servo),
    )


def _predicted(
    judged: list[Gait],
    bands: dict[Gait, SpeedBand],
    crawls: dict[Gait, Crawls],
    slope_shares: dict[Gait, Array],
) -> Predicted:
    """Return the samples of the judged gaits' speeds beside what was measured of them."""
    drawn_m_s = np.stack([bands[gait].samples_m_s for gait in judged], axis=2)
    servo_shares = drawn_m_s[2] / np.maximum(drawn_m_s[1], 1e-9)
    measured = np.array([mean_speed(crawls[gait].runs) for gait in judged])
    slopes = np.stack([slope_shares[gait] for gait in judged], axis=1)
    return Predicted(drawn_m_s[1], servo_shares, slopes, *measured.T)


def _tested(
    predicted: Predicted,
    pairs: list[tuple[Gait, Gait | None]],
    fit: FrictionFit,
    servo: ServoKind | None,
    seed: int,
) -> tuple[float, Factor | None, Factor | None]:
    """Return the p-value of the judged gaits, and the factors that explain a small one."""
    p_value = predicted.p_value(seed)
    if p_value >= DOUBTFUL:
        return p_value, None, None
    return p_value, *best_factors(predicted, fit, pairs, servo and servo.servo, seed)


def compared_gaits(session: Session, more: Sequence[Gait] = ()) -> list[Gait]:
    """Return the gaits run, or planned where none was, and further ones."""
    crawls = crawls_by_command(session)
    commands = [crawl.commanded for crawl in crawls] or list(session.setup.plan.gaits)
    gaits = [crawl.gait for crawl in crawls] or commands
    return gaits + [g for g in more if not any(same_command(command, g) for command in commands)]


def _joints_as_filmed(crawl: Crawls) -> str:
    """Return how far the joints of a filmed gait moved, which its prediction takes."""
    if not crawl.films:
        return ""
    numbers = " and ".join(str(film.number) for film in crawl.films)
    gain = float(np.mean([film.mean_gain for film in crawl.films]))
    sigma = math.hypot(*(film.gain_sigma for film in crawl.films)) / len(crawl.films)
    return (
        f"Joints in film {numbers} reach {gain:.1%} ± {sigma:.1%} of the commanded amplitude; the "
        "prediction takes them as filmed."
    )


def _compared(
    fit: FrictionFit, gait: Gait, band: SpeedBand, crawl: Crawls | None, slope_sigma: float
) -> ComparedGait:
    """Return a row; slope_sigma: relative error of the measured speed by a slope that was told."""
    ends = (None, None) if band.too_fast else (band.low_m_s, band.high_m_s)
    measured: dict[str, Any] = {}
    if crawl:
        measured_m_s, sigma_m_s = mean_speed(crawl.runs)
        measured = {
            "runs": tuple(run.number for run in crawl.runs),
            "measured_m_s": measured_m_s,
            "sigma_m_s": math.hypot(sigma_m_s, slope_sigma * measured_m_s),
            "residual_m_s": measured_m_s - band.exact_m_s,
        } | _by_springs(fit, gait)
    return ComparedGait(
        gait.alpha_rad,
        gait.beta_rad,
        gait.omega_rad_s / math.tau,
        band.exact_m_s,
        band.speed_m_s,
        band.low_friction_m_s,
        band.high_friction_m_s,
        *ends,
        **measured,
    )


def _by_springs(fit: FrictionFit, gait: Gait) -> dict[str, float]:
    """Return the implicit model's speed and its error; nothing where its springs never settle."""
    try:
        springs = steady_springs(fit.robot, fit.ground, gait, rtol=SPRINGS_RTOL)
    except NotConverged:  # heavy links on the paper's springs
        return {}
    error = springs.error_estimate * springs.speed_m_s
    return {"implicit_m_s": springs.speed_m_s, "implicit_error_m_s": error}


def _verdict(
    shown: Sequence[ComparedGait], p_value: float | None, servo: ServoKind | None
) -> tuple[str, str]:
    """Return the verdict as one word, and as a sentence."""
    if not any(gait.runs for gait in shown):
        return "not measured", NOT_MEASURED
    judged = [gait for gait in shown if gait.judged]
    if p_value is None or not judged:
        return "not judged", "Not judged: the servos cannot follow any gait that was run."
    differences = [(g.measured_m_s or 0.0) / max(g.typical_m_s, 1e-9) - 1.0 for g in judged]
    worst = int(np.argmax(np.abs(differences)))
    widths = [((g.high_all_m_s or 0.0) - (g.low_all_m_s or 0.0)) / 2 for g in judged]
    width = max(w / max(g.typical_m_s, 1e-9) for w, g in zip(widths, judged, strict=True))
    joints = "ideal joints" if servo is None else f"servos ({servo.name})"
    count = count_text(len(judged), "gait")
    largest = (
        f"the largest difference from the prediction with {joints} is {differences[worst]:+.1%}, "
        f"at {judged[worst].frequency_hz:.3g} Hz"
    )
    chance = f"p = {p_value:.2g}" if p_value else f"p < {1 / SIMULATED:.1g}"
    if p_value >= DOUBTFUL:
        text = f"Agrees: {count} within what friction, joints and servos allow, up to ±{width:.0%}"
        if outside := sum(gait.outside for gait in judged):
            text = (
                f"Agrees: together the speeds of {count} are likely enough; {outside} of them "
                f"{'lies' if outside == 1 else 'lie'} outside the 95 % band of that gait alone"
            )
        return "agrees", f"{text} ({chance}; {largest})."
    return "differs", f"Differs: {largest} ({chance}, {count})."


def _explained(friction: Factor | None, amplitude: Factor | None) -> str:
    """Return which of the two factors would explain the speeds; "" without factors."""
    if not friction or not amplitude:
        return ""
    causes = {
        f"all friction times {friction.factor:.2g}": friction.p_value,
        f"joints that reach {amplitude.factor:.0%} of the amplitude": amplitude.p_value,
    }
    able = [f"{words} (p = {p:.2g})" for words, p in causes.items() if p >= DOUBTFUL]
    if able:
        return f" It would be explained by {' or by '.join(able)}. Measure that first."
    return (
        " No one factor on friction or on amplitude explains it: look at the ground's slope, "
        "the surface, tape and watch, the frequency, the gait itself."
    )
