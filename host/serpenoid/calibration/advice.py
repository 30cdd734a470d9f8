"""Which reading to take next: the one that shrinks the speeds' bands most, by the fit's own sums.

A reading that is yet to be taken is put beside the others at its expected value, at an incline that
the treadmill can be set to: its row of the Jacobian adds to the information, a bend set anew brings
its own offset with it, a set point read again its rounding error. Of speed, the
sampled frictions give the share that goes with friction linearly (a regression of sampled speeds,
not a tangent); the new covariance says what is left of it. That ranks the readings. What is told
of the band, now and after the best reading, is sampled as `compare` samples it, since bands are
skewed where wheels stick. A gait run tells of its own speed, but for the joints' amplitude, which
it shares with the gaits that matter; friction fits leave gait runs out, and so does this unless
asked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..model.checks import check_kind
from ..model.drives import ServoKind
from ..model.errors import BadInput
from ..model.gait import Gait
from ..servos.catalogue import HOBBY
from .fitting.data import FitData, Floats, projections
from .fitting.identifiability import SAFE_BEND
from .fitting.joint import jacobian, starting_point
from .fitting.rounding import nearest_shown
from .fitting.shared import shared_covariance
from .friction_fit import fit_friction
from .friction_result import FrictionFit, WholeSnake
from .kinds.station import LEAST_SLIP_M_S, Reading, bent_share
from .session import Session, Setup
from .speed_samples import (
    AMPLITUDE_SIGMA,
    Progress,
    band_parts,
    sample_speeds,
    servo_fields,
    servo_note,
)
from .taking.expected import Series

LAMBDAS_DEG = (0.0, 7.5, 15.0, 20.0, 30.0)  # further, the end joints stand beyond 60 degrees
MOST_INCLINE_RAD = math.atan(0.15)  # of home treadmills, unless this one stood steeper already
SLIPS_M_S = (0.15, 0.3, 0.6, 1.0)
_MOST_TIMES, _WORTH_ANOTHER = 5, 0.1
_Z95 = 1.959964
_SAME_RAD = math.radians(0.5)  # bends that are one
_AS_GOOD = 4.0  # sigmas of a bend from the one that the robot lies in


@dataclass(frozen=True, slots=True)
class NextReading:
    """A reading, and the relative half-width of the speeds' 95 % band (`SpeedBand`) after it.

    kind: station (lambda_rad, incline_rad, belt_speed_m_s expected) or gait (alpha_rad, beta_rad,
    frequency_hz). times: how often it is worth taking. band: mean over the gaits asked for. facing:
    of a station, up the belt for a ratchet's wheels backwards. bend: of a bent station, balanced
    or zigzag. minutes, told: of readings on a floor, what they take, and what to do in words.
    """

    kind: str
    band: float
    times: int
    band_after_times: float
    lambda_rad: float | None = None
    incline_rad: float | None = None
    belt_speed_m_s: float | None = None
    alpha_rad: float | None = None
    beta_rad: float | None = None
    frequency_hz: float | None = None
    facing: str = "down"
    bend: str = ""
    minutes: float | None = None
    told: str = ""

    def in_words(self) -> str:
        """Return what to do."""
        if self.told:
            return self.told
        if self.kind == "gait":
            what = f"a gait run at {self.frequency_hz:.3g} Hz"
        else:
            bend, incline = (
                math.degrees(self.lambda_rad or 0.0),
                math.degrees(self.incline_rad or 0),
            )
            at = f" ({self.bend}; {180 - 2 * bend:.4g}° between the links at either end)"
            links = at if bend else ", straight"
            links += ", facing up" if self.facing == "up" else ""
            what = (
                f"λ = {bend:.4g}°{links}, inclinometer at {incline:.2f}°, "
                f"belt near {self.belt_speed_m_s:.2g} m/s"
            )
        return what + (f", {self.times} times" if self.times > 1 else "")


@dataclass(frozen=True)
class Advice:
    """What advise found: the band now, relative, and the readings, best first.

    band: half of the 95 % band over the speed, mean over the gaits, as `compare` shows it.
    band_after_best: the same share once the best reading is taken as often as it is worth, by
    samples too. note: what must be known beside, "" if nothing. servo: the kind that moves the
    joints, None for ideal ones. band_servo_measured: the same share once one joint was measured in
    a bench test (`serpenoid servo --test`); None for ideal joints.
    """

    gaits: tuple[Gait, ...]
    band: float
    band_after_best: float
    readings: tuple[NextReading, ...]
    note: str = ""
    servo: str | None = None
    band_servo_measured: float | None = None

    @property
    def best(self) -> NextReading:
        """Return the reading that shrinks the band most."""
        return self.readings[0]

    @property
    def measure_servo(self) -> bool:
        """Tell whether measuring a servo shrinks the band more than the best reading."""
        measured = self.band_servo_measured
        return measured is not None and measured < self.band_after_best

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name."""
        return {
            "gaits": [asdict(g) for g in self.gaits],
            "band": self.band,
            "band_after_best": self.band_after_best,
            "note": self.note,
            "servo": self.servo,
            "band_servo_measured": self.band_servo_measured,
            "measure_servo": self.measure_servo,
            "readings": [asdict(r) | {"in_words": r.in_words()} for r in self.readings],
        }


def advise(
    session: Session,
    gaits: Sequence[Gait] = (),
    *,
    samples: int = 48,
    lambdas_deg: Sequence[float] = LAMBDAS_DEG,
    runs: bool = False,
    servo: ServoKind | None = HOBBY,
    progress: Progress | None = None,
) -> Advice:
    """Rank the readings that could be taken next by the speed band they leave.

    gaits: those that matter; the session's planned ones unless given. lambdas_deg: bends to choose
    from, in degrees. runs: whether to count gait runs, those taken and those to take. servo: the
    kind that moves the joints, as for `compare`; where it, and no longer friction, is what to
    measure, the note says so. No place is
    named where a reading was voided, none steeper than MOST_INCLINE_RAD or the steepest taken, none
    faster than the plan's belt. Raises BadInput if there is no gait, and what fit_friction raises
    for readings that leave a parameter open: then it names the reading that would close it.
    """
    check_kind("session", session, Session)
    wanted = tuple(gaits) or session.setup.procedure.gaits
    if not wanted:
        raise BadInput(f"{session.where}: no gait to predict; name one with --gait")
    if not session.kept:
        raise BadInput(f"{session.where}: no station was held; ask advise_on_floor for pushes")
    fit = fit_friction(session)
    whole = np.array(list(fit.whole_snake.values()))
    slopes = speed_slopes(fit, wanted, samples, progress)
    ran = [_sigmas_of_runs(session, gait) if runs else [] for gait in wanted]
    readings = [
        _station(session, whole, (slopes, ran), at)
        for at in _places(session, whole, [math.radians(bend) for bend in lambdas_deg])
    ]
    covariance = _covariance(session, whole)
    readings += [_gait_run(session, covariance, slopes, ran, j) for j in range(len(wanted)) if runs]
    if not readings:
        raise BadInput(
            f"{session.where}: no station that this treadmill can be set to tells more; take gait "
            "runs, or raise belt_speed_max_m_s in the plan"
        )
    linear = slopes.band(covariance)
    parts = band_parts(fit, wanted, servo)
    now = parts.with_friction(slopes.band(covariance, ran) / linear)
    total = [replace(
        r, band=parts.with_friction(r.band / linear),
        band_after_times=parts.with_friction(r.band_after_times / linear),
    ) for r in sorted(readings, key=lambda r: r.band)]  # fmt: skip
    then = _after(session, fit, total[0])
    last = total[0].band_after_times
    after = last if then is None else band_parts(then, wanted, servo).whole
    notes = filter(None, (_ratchet_note(session, fit), servo_note(parts, servo, after)))
    return Advice(wanted, now, after, tuple(total), " ".join(notes), *servo_fields(servo, parts))


def _after(session: Session, fit: FrictionFit, told: NextReading) -> FrictionFit | None:
    """Return the fit as a station taken as told would leave it, at the same values."""
    if told.kind != "station":
        return None
    first = max(r.number for r in session.readings) + 1
    more = (
        Reading(
            first + k, told.lambda_rad or 0.0, told.incline_rad or 0.0, told.belt_speed_m_s or 0.0,
            facing=told.facing, bend=told.bend or "zigzag",
        )
        for k in range(told.times)
    )  # fmt: skip
    values = np.array(list(fit.whole_snake.values()))
    before = _covariance(session, values)
    covariance = _covariance(replace(session, readings=(*session.readings, *more)), values)
    shrink = np.sqrt(np.diag(covariance) / np.diag(before))
    ends = {
        name: tuple(max(v + s * (end - v), 0.0) for end in fit.intervals[name])
        for name, v, s in zip(fit.names, values, shrink, strict=True)
    }
    scale = np.sqrt(np.diag(fit.covariance) / np.diag(before))
    return replace(fit, covariance=covariance * np.outer(scale, scale), intervals=WholeSnake(ends))


def _ratchet_note(session: Session, fit: FrictionFit) -> str:
    if not session.setup.procedure.ratchet or len(fit.names) > 4:
        return ""
    return (
        "The plan says that the wheels are ratchets, but nothing tells how they roll backwards: "
        "these bands take them to roll alike both ways. Hold two straight stations facing up first."
    )


@dataclass(frozen=True)
class SpeedSlopes:
    """Speeds of the gaits that matter: (gaits,) values, (gaits, P) change by friction."""

    gaits: tuple[Gait, ...]
    speed_m_s: Floats
    slope: Floats

    def band(self, covariance: Floats, ran: Sequence[Sequence[float]] = ()) -> float:
        """Return the relative half-width of the 95 % band, mean over the gaits.

        ran: per gait, the standard deviations of its runs' speeds. Each tells its own speed, but
        for the joints' amplitude, which runs of one gait share.
        """
        of = self.slope.shape[1]
        friction = covariance[:of, :of]
        for slope, v, sigmas in zip(
            self.slope, self.speed_m_s, ran or [()] * len(self.slope), strict=True
        ):
            if len(sigmas):
                noise = 1.0 / np.sum(np.asarray(sigmas) ** -2.0) + (AMPLITUDE_SIGMA * v) ** 2
                gain = friction @ slope
                friction = friction - np.outer(gain, gain) / (slope @ gain + noise)
        sigma = np.sqrt(np.einsum("gi,ij,gj->g", self.slope, friction, self.slope))
        return float(np.mean(_Z95 * sigma / self.speed_m_s))


def speed_slopes(
    fit: FrictionFit, gaits: Sequence[Gait], samples: int, progress: Progress | None = None
) -> SpeedSlopes:
    """Regress sampled speeds on sampled frictions; raises BadInput for a gait that goes nowhere."""
    drawn = sample_speeds(fit, gaits, count=samples, progress=progress)
    mean = drawn.friction_m_s.mean(axis=0)
    if mean.min() <= 0.0:
        raise BadInput("one of the gaits does not move at all; choose a larger amplitude")
    centred = drawn.whole - drawn.whole.mean(axis=0)
    # a little of the fit's own covariance keeps frictions known all but exactly in their place
    ridge = 1e-6 * len(centred) * np.diag(np.diag(fit.covariance))
    slope = np.linalg.solve(centred.T @ centred + ridge, centred.T @ (drawn.friction_m_s - mean))
    return SpeedSlopes(tuple(gaits), mean, slope.T)


def _covariance(session: Session, whole: Floats) -> Floats:
    """Return the parameters' covariance that a session's readings leave, near these values."""
    data = FitData.of(session)
    slopes = jacobian(starting_point(whole, data), data)
    covariance = np.asarray(np.linalg.inv(slopes.T @ slopes), dtype=np.float64)
    of = data.parameters
    return covariance[:of, :of] + shared_covariance(whole, data.belt_sigma, data.mass_sigma)


def _places(
    session: Session, whole: Floats, bends: Sequence[float]
) -> list[tuple[Series, float, float]]:
    """Return series, inclines and slips worth a look: where the treadmill can be set to.

    The bend that the robot lies in now stands for one that is as good as equal to it.
    """
    given, kept = session.setup.uncertainty, session.kept
    shown = np.array([r.incline_rad for r in kept], dtype=float)
    bent = session.setup.procedure.bend
    now = kept[-1].lambda_rad if kept[-1].bend == bent else 0.0
    fastest = session.setup.procedure.belt_speed_max_m_s
    steepest = max(MOST_INCLINE_RAD, float(shown.max()))
    near, (zero,) = _AS_GOOD * given.lambda_sigma_rad, session.zeros_rad(kept[-1:])
    found: dict[tuple[Series, float], float] = {}
    angles = [now if now and abs(bend - now) < near else bend for bend in bends]
    every = [
        Series(angle, bend=bent) for angle in angles
        if not angle or angle > SAFE_BEND * given.lambda_sigma_rad  # lesser ones bias cn
    ]  # fmt: skip
    for series in [*every, *([Series(0.0, "up", bent)] if len(whole) > 4 else [])]:
        for wanted_m_s in SLIPS_M_S:
            aim = station_incline_rad(whole, session.setup, series, wanted_m_s) + zero
            grade_step = session.setup.treadmill.incline_step_rad
            incline = nearest_shown(aim, shown, given.incline_sigma_rad, grade_step)
            slip = station_slip_m_s(whole, session.setup, series, incline - zero)
            fits = LEAST_SLIP_M_S < slip <= fastest and 0.0 < incline <= steepest
            if fits and not _failed(session, series, incline):
                found[series, round(incline, 6)] = slip
    return [(series, incline, slip) for (series, incline), slip in found.items()]


def _failed(session: Session, series: Series, incline_rad: float) -> bool:
    """Tell whether a reading at this bend and incline was voided, and none kept."""
    step = session.setup.treadmill.incline_step_rad
    there = [
        r.voided for r in session.readings
        if abs(r.lambda_rad - series.lambda_rad) < _SAME_RAD and r.facing == series.facing
        and abs(r.incline_rad - incline_rad) < step / 2
    ]  # fmt: skip
    return bool(there) and all(there)


def _pull(whole: Floats, setup: Setup, series: Series) -> tuple[float, float]:
    """Return A and B: the whole snake's friction along the belt is A v + B."""
    ct, cn, ft0, fn0 = whole[:4].tolist()
    if series.facing == "up":
        ct, ft0 = whole[4:6].tolist()
    share = bent_share(series.bend, setup.robot.links) if series.lambda_rad else 0.0
    by_ct, by_cn, by_ft0, by_fn0 = projections(share, series.lambda_rad)
    return float(ct * by_ct + cn * by_cn), float(ft0 * by_ft0 + fn0 * by_fn0)


def station_incline_rad(whole: Floats, setup: Setup, series: Series, slip_m_s: float) -> float:
    """Return the incline at which a snake of this friction holds its station at this slip."""
    slope, least = _pull(whole, setup, series)
    return math.asin(min((slope * slip_m_s + least) / setup.weight_n, 0.7))


def station_slip_m_s(whole: Floats, setup: Setup, series: Series, incline_rad: float) -> float:
    """Return the slip at which it holds its station at this incline, below 0 if it does not."""
    slope, least = _pull(whole, setup, series)
    return (setup.weight_n * math.sin(incline_rad) - least) / max(slope, 1e-12)


def _sigmas_of_runs(session: Session, gait: Gait) -> list[float]:
    """Return the standard deviations of this gait's runs (the board's clock is 1 % off at most)."""
    return [
        r.speed_sigma_m_s
        for r in session.kept_gait_runs
        if abs(r.omega_rad_s / gait.omega_rad_s - 1.0) < 0.01
        and math.isclose(r.alpha_rad, gait.alpha_rad, abs_tol=1e-3)
        and math.isclose(r.beta_rad, gait.beta_rad, abs_tol=1e-3)
    ]


def _station(
    session: Session,
    whole: Floats,
    speeds: tuple[SpeedSlopes, list[list[float]]],
    at: tuple[Series, float, float],
) -> NextReading:
    (slopes, ran), (series, incline, slip) = speeds, at
    first = max(r.number for r in session.readings) + 1
    bands = []
    for times in range(1, _MOST_TIMES + 1):
        more = (
            Reading(
                first + k, series.lambda_rad, incline, slip, facing=series.facing, bend=series.bend
            )
            for k in range(times)
        )
        after = replace(session, readings=(*session.readings, *more))
        bands.append(slopes.band(_covariance(after, whole), ran))
        if times > 1 and bands[-1] > (1.0 - _WORTH_ANOTHER) * bands[-2]:
            break
    times = _worth(bands)
    return NextReading(
        "station", bands[0], times, bands[times - 1],
        lambda_rad=series.lambda_rad, incline_rad=incline, belt_speed_m_s=slip,
        facing=series.facing, bend=series.bend if series.lambda_rad else "",
    )  # fmt: skip


def _worth(bands: list[float]) -> int:
    """Return how often to take a reading: until once more shrinks the band by less than a tenth."""
    times = 1
    while times < len(bands) and bands[times] < (1.0 - _WORTH_ANOTHER) * bands[times - 1]:
        times += 1
    return times


def _gait_run(
    session: Session, covariance: Floats, slopes: SpeedSlopes, ran: list[list[float]], j: int
) -> NextReading:
    """Return what a run of gait j brings: it measures its own speed, with a stopwatch."""
    gait, v = slopes.gaits[j], float(slopes.speed_m_s[j])
    sigma = session.setup.stopwatch.speed(1.0, 1.0 / v)[1]
    bands = []
    for times in range(1, _MOST_TIMES + 1):
        more = [[*s, *([sigma] * times if k == j else [])] for k, s in enumerate(ran)]
        bands.append(slopes.band(covariance, more))
    times = _worth(bands)
    return NextReading(
        "gait", bands[0], times, bands[times - 1], alpha_rad=gait.alpha_rad,
        beta_rad=gait.beta_rad, frequency_hz=gait.omega_rad_s / (2 * math.pi),
    )  # fmt: skip
