"""Measured gait runs against the speeds that the session's own friction predicts, and a verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import check_kind, check_number
from ..base.errors import BadInput, NotConverged
from ..base.rows import Result
from ..calibration.crawls.data import CrawlData, crawls_by_command, mean_speed, same_command
from ..calibration.crawls.level import Slope, floor_slope, is_sloped, on_level
from ..calibration.friction_fit import fit_friction
from ..calibration.friction_result import FrictionFit
from ..calibration.speeds import AMPLITUDE_SIGMA, Progress, speed
from ..model.drives import ServoKind
from ..model.gait import Gait, gait_name
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import highest_hz, too_fast_text
from ..session.gait_run import GaitRun
from ..session.session import Session
from ..simulation.steady_springs import steady_springs
from .filmed_joints import seen_on_film, servo_seen, swapped_plugs
from .speed_samples import SpeedSamples, sample_speeds
from .verdict import Judge
from .verdict_words import in_words

NOT_MEASURED = "No gait was run yet: these are predictions. Run one, and compare again."
NO_GAIT = "no gait run and no gait planned; give one, or take a run with `serpenoid calibrate`"
_LEVEL = (
    "Crawls there and back are shown as they would be on level ground: the floor falls by "
    "{} towards {}, and by {} to the {} of the way there."
)
_CURVE_POINTS, _SPRINGS_EVERY = 49, 6  # chords between them are 0.1 % off; springs take longer


@dataclass(frozen=True)
class ComparedGait:
    """One gait: predicted by exact and implicit model, with its 95 % bands, and measured.

    low_m_s, high_m_s: of the frictions that the fit allows. low_all_m_s, high_all_m_s: with the
    joints' amplitude and the servos besides; None where the gait is too fast for them. runs:
    numbers of the measured runs; measured_m_s, sigma_m_s: their mean and its standard deviation;
    none if not measured. residual_m_s: measured less predicted.
    implicit_m_s: None where the paper's springs never settle, or were not asked.
    """

    alpha_rad: float
    beta_rad: float
    frequency_hz: float
    exact_m_s: float
    implicit_m_s: float | None
    low_m_s: float
    high_m_s: float
    low_all_m_s: float | None
    high_all_m_s: float | None
    runs: tuple[int, ...] = ()
    measured_m_s: float | None = None
    sigma_m_s: float | None = None
    residual_m_s: float | None = None

    @property
    def name(self) -> str:
        """Return the gait's angles and frequency."""
        return gait_name(Gait(self.alpha_rad, self.beta_rad, math.tau * self.frequency_hz))

    @property
    def band_in_words(self) -> str:
        """Return the band with joints and servos, m/s, or that there is none."""
        if self.low_all_m_s is None:
            return "too fast"
        return f"{self.low_all_m_s:.3g} to {self.high_all_m_s:.3g}"

    def cells(self) -> list[str]:
        """Return the gait and its speeds, m/s, as in the heads of a comparison."""
        measured = f"{self.measured_m_s:.4f} ± {self.sigma_m_s:.4f}" if self.runs else "–"
        return [
            self.name,
            measured,
            self.band_in_words,
            f"{self.exact_m_s:.4f}",
            f"{self.low_m_s:.3g} to {self.high_m_s:.3g}",
            "–" if self.implicit_m_s is None else f"{self.implicit_m_s:.4f}",
        ]


@dataclass(frozen=True)
class Comparison(Result):
    """Hold the predicted and the measured speeds of a session, and the verdict.

    Attributes
    ----------
    session
        Name of the session.
    amplitude_sigma
        Stated standard deviation of the joints' amplitude, relative.
    gaits
        The gaits that were run; the planned ones if none was.
    curve
        Speed over frequency at the first gait's amplitude and phase lag: the band of friction
        alone, and the implicit model at each sixth point.
    measured
        All runs that were kept; those along a floor's slope as they would be on level ground.
    p_value
        The chance of residuals this large if model, fit and stated errors hold.
    p_friction, p_amplitude, p_servos
        The same chance if friction, the amplitude or the servos may differ from what is stated;
        None where this was not tested.
    verdict
        "agrees", "neither", "not measured", or the possible causes joined by "or".
    verdict_text
        The verdict in words.
    servo
        Name of the kind of servo; None for joints that follow the gait.
    fit_alarms
        Why the friction fit that this rests on is not to be trusted.
    highest_hz
        Frequency up to which the curve's gait is not too fast for such servos, Hz; None without.

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
    curve: tuple[ComparedGait, ...]
    measured: tuple[GaitRun, ...]
    p_value: float | None
    p_friction: float | None
    p_amplitude: float | None
    verdict: str
    verdict_text: str
    servo: str | None = None
    p_servos: float | None = None
    fit_alarms: tuple[str, ...] = ()
    highest_hz: float | None = None

    def in_words(self) -> str:
        """Return the verdict."""
        return self.verdict_text

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return one line for each gait, m/s: measured, with joints and servos, ideal, implicit."""
        servos = "" if self.servo is None else f" and servos ({self.servo})"
        heads = [
            "gait",
            "measured, m/s",
            f"95 % with joints{servos}, m/s",
            "ideal\njoints",
            "95 % friction",
            "implicit",
        ]
        first = 1 if any(p.runs for p in self.gaits) else 2
        last = None if verbose else 4
        lines = [heads, *(p.cells() for p in self.gaits)]
        lines = [[line[0], *line[first:last]] for line in lines]
        return lines[0], lines[1:]

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name; fit_alarms only where there are any."""
        return {k: v for k, v in asdict(self).items() if k != "fit_alarms" or v}


def compare(
    session: Session,
    fit: FrictionFit | None = None,
    *,
    gaits: Sequence[Gait] = (),
    amplitude_sigma: float = AMPLITUDE_SIGMA,
    servo: ServoKind | None = HOBBY,
    samples: int = 64,
    seed: int = 2005,
    progress: Progress | None = None,
) -> Comparison:
    """Compare a session's gait runs with the speeds that its friction predicts.

    Frictions are sampled, because the distribution of speed is skewed where wheels stick.

    Parameters
    ----------
    session, fit
        The gait runs, and the friction: the session's own joint fit unless given.
    gaits
        Further gaits to predict.
    amplitude_sigma
        Standard deviation of true over commanded amplitude, common to all gaits.
    servo
        The kind that moves the joints, any hobby servo unless given. None: they follow the gait,
        and servos are no cause.
    samples, seed
        Number of frictions drawn, and the seed of the draw.
    progress
        Called with the gaits done, of `gait_count`.

    Returns
    -------
    Comparison
        Speeds, bands, p-values and the verdict.

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
    if not compared_gaits(session, gaits):
        raise BadInput(f"{session.where}: {NO_GAIT}")
    session, levelled = _levelled(session, fit)
    crawls, wanted = crawls_by_command(session), compared_gaits(session, gaits)
    runs = {crawl.gait: crawl.runs for crawl in crawls}
    servo = servo and servo_seen(session.setup.driving(servo), session.kept_films, fit, seed)
    drawn = sample_speeds(
        fit,
        wanted,
        amplitude_sigma=amplitude_sigma,
        servo=servo,
        seen={c.gait: c.commanded for c in crawls if c.films},
        count=samples,
        seed=seed,
        progress=progress,
    )
    points, words = [_point(fit, drawn, j, runs.get(g, ())) for j, g in enumerate(wanted)], []
    for j, g in enumerate(wanted):
        if g not in drawn.seen and (too_fast := too_fast_text(g, servo, points[j].name)):
            words.append(too_fast)
            points[j] = replace(points[j], low_all_m_s=None, high_all_m_s=None)
    judged = _judged(session, fit, drawn, points, (amplitude_sigma, seed, servo))
    remark = servo.remark if servo else ""
    words += [judged.pop("text"), levelled]
    text = " ".join(filter(None, [remark, *swapped_plugs(session), *words]))
    return Comparison(
        session.setup.name,
        amplitude_sigma,
        tuple(points),
        _curve(fit, wanted, samples, seed, progress),
        session.kept_crawls,
        **judged,
        verdict_text=text,
        servo=servo and servo.name,
        fit_alarms=fit.alarms,
        highest_hz=servo and highest_hz(wanted[0], servo),
    )


def _levelled(session: Session, fit: FrictionFit) -> tuple[Session, str]:
    """Return the session on level ground, and the sentence that says so where it sloped."""
    if not is_sloped(session):
        return session, ""
    slope = floor_slope(session, fit.nuisances)
    level = on_level(session, fit.robot, fit.ground, slope)
    return level, level_words(slope)


def level_words(slope: Slope) -> str:
    """Return that crawls are shown as on level ground, and by what the floor falls, and where."""
    along, across = slope
    sizes = [
        f"{math.degrees(abs(angle.value)):.2f} ± {math.degrees(angle.sigma):.2f} deg"
        for angle in slope
    ]
    ends = "there" if along.value >= 0 else "back", "left" if across.value >= 0 else "right"
    return _LEVEL.format(sizes[0], ends[0], sizes[1], ends[1])


def _judged(
    session: Session,
    fit: FrictionFit,
    drawn: SpeedSamples,
    points: Sequence[ComparedGait],
    stated: tuple[float, int, ServoKind | None],
) -> dict[str, Any]:
    """Return the verdict as a Comparison holds it; stated: amplitude_sigma, seed and servo."""
    amplitude_sigma, _, servo = stated
    ran = [j for j, point in enumerate(points) if point.runs]
    if not ran:
        nothing = dict.fromkeys(("p_value", "p_friction", "p_amplitude"))
        return nothing | {"verdict": "not measured", "text": NOT_MEASURED}
    speeds = np.array([(points[j].measured_m_s, points[j].sigma_m_s) for j in ran], dtype=float)
    measured = CrawlData(tuple(drawn.gaits[j] for j in ran), *speeds.T)
    verdict = Judge(fit, drawn.some(ran), *stated)(measured)
    text = in_words(verdict, measured, fit, amplitude_sigma, session.setup.weight_n, servo)
    filmed = [crawl for crawl in crawls_by_command(session) if crawl.films]
    word, text = seen_on_film(filmed, fit, drawn, measured, verdict.word, text)
    causes = {f"p_{name}": cause and cause.p_value for name, cause in verdict.causes.items()}
    return {"p_value": verdict.p_value, "verdict": word, "text": text} | causes


def compared_gaits(session: Session, more: Sequence[Gait] = ()) -> list[Gait]:
    """Return the gaits run, or planned where none was, and further ones."""
    crawls = crawls_by_command(session)
    commands = [crawl.commanded for crawl in crawls] or list(session.setup.procedure.gaits)
    gaits = [crawl.gait for crawl in crawls] or commands
    return gaits + [g for g in more if not any(same_command(known, g) for known in commands)]


def gait_count(session: Session, more: Sequence[Gait] = ()) -> int:
    """Return how many gaits `compare` solves for: the compared ones and the curve's."""
    return len(compared_gaits(session, more)) + _CURVE_POINTS


def _by_springs(fit: FrictionFit, gait: Gait) -> float | None:
    """Return the implicit model's speed, m/s; None where its springs never come to rest."""
    try:
        return steady_springs(fit.robot, fit.ground, gait, rtol=1e-3).speed_m_s
    except NotConverged:  # heavy links on the paper's springs: no reason to withhold the rest
        return None


def _point(
    fit: FrictionFit, drawn: SpeedSamples, j: int, runs: Sequence[GaitRun], springs: bool = True
) -> ComparedGait:
    gait = drawn.gaits[j]
    exact = speed(fit.robot, fit.ground, gait)
    (low, high), _, (low_all, high_all) = drawn.ends_m_s[j].tolist()
    measured, sigma = mean_speed(runs) if runs else (None, None)
    return ComparedGait(
        gait.alpha_rad,
        gait.beta_rad,
        gait.omega_rad_s / (2 * math.pi),
        exact,
        _by_springs(fit, gait) if springs else None,
        low,
        high,
        low_all,
        high_all,
        tuple(r.number for r in runs),
        measured,
        sigma,
        None if measured is None else measured - exact,
    )


def _curve(
    fit: FrictionFit, wanted: list[Gait], samples: int, seed: int, progress: Progress | None
) -> tuple[ComparedGait, ...]:
    rates = [g.omega_rad_s for g in wanted]
    first = wanted[0]
    grid = np.geomspace(0.5 * min(rates), 1.3 * max(rates), _CURVE_POINTS).tolist()
    gaits = [Gait(first.alpha_rad, first.beta_rad, rate) for rate in grid]
    drawn = sample_speeds(fit, gaits, count=samples, seed=seed, progress=progress)
    return tuple(_point(fit, drawn, j, (), j % _SPRINGS_EVERY == 0) for j in range(len(gaits)))
