"""What advice consists of: readings that may come next, and the speed band that each leaves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from ..base.errors import BadInput
from ..base.rows import Result
from ..calibration.crawls.data import as_run
from ..model.gait import Gait
from ..session.gait_run import GaitRun
from ..session.session import Session
from ..session.station import Reading

_SHOWN = 5  # readings of a table
_MOST_TIMES = 5  # of one reading
WORTH = 0.1  # of the band: a reading that saves less is not worth a table


@dataclass(frozen=True, slots=True)
class NextReading:
    """A reading, and the relative half-width of the speeds' 95 % band (`SpeedBand`) after it.

    kind: station (lambda_rad, incline_rad, belt_speed_m_s expected) or gait (alpha_rad, beta_rad,
    frequency_hz). times: how often it is worth taking. band: mean over the gaits asked for. bend:
    of a bent station, balanced
    or zigzag. minutes, told: of readings on a floor, what they take, and what to do in words.
    """

    kind: str
    band: float = math.nan
    times: int = 1
    band_after_times: float = math.nan
    lambda_rad: float | None = None
    incline_rad: float | None = None
    belt_speed_m_s: float | None = None
    alpha_rad: float | None = None
    beta_rad: float | None = None
    frequency_hz: float | None = None
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
            bend, incline = (math.degrees(a or 0.0) for a in (self.lambda_rad, self.incline_rad))
            at = f" ({self.bend}; {180 - 2 * bend:.4g}° between the links at either end)"
            links = at if bend else ", straight"
            what = (
                f"λ = {bend:.4g}°{links}, inclinometer at {incline:.2f}°, "
                f"belt near {self.belt_speed_m_s:.2g} m/s"
            )
        return what + (f", {self.times} times" if self.times > 1 else "")


# A reading, and the session with it once, twice and so on.
Option = tuple[NextReading, Iterable[Session]]


def next_number(session: Session) -> int:
    """Return a number that no reading has."""
    return 1 + max((reading.number for reading in session.numbered), default=0)


def repeated(session: Session, part: str, reading: Reading | GaitRun) -> Iterator[Session]:
    """Yield the session with a reading in one of its parts once, twice and so on."""
    readings = getattr(session, part)
    for k in range(_MOST_TIMES):
        readings = (*readings, replace(reading, number=reading.number + k))
        yield replace(session, **{part: readings})


@dataclass(frozen=True)
class Advice(Result):
    """Hold the present speed band and the readings that would shrink it.

    Attributes
    ----------
    gaits
        The gaits whose speeds count.
    band
        Half of the 95 % band of speed, relative, mean over the gaits; `compare` shows the same.
    band_after_best
        The same relative band after the best reading has been taken as often as it is worth.
    readings
        Readings that can be taken next, best first.
    note
        A remark for the user, or "".
    servo
        Name of the kind of servo; None for joints that follow the gait.
    band_servo_measured
        The relative band once one joint was measured in a bench test (`serpenoid servo --test`);
        None for ideal joints.
    fit_alarms
        Why the friction fit that this rests on is not to be trusted.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> advice = sn.advise(session, [gait], servo=None, samples=16, lambdas_deg=(0.0, 15.0))
    >>> bool(advice.band_after_best < advice.band)
    True
    """

    gaits: tuple[Gait, ...]
    band: float
    band_after_best: float
    readings: tuple[NextReading, ...]
    note: str = ""
    servo: str | None = None
    band_servo_measured: float | None = None
    fit_alarms: tuple[str, ...] = ()

    @property
    def best(self) -> NextReading:
        """Return the reading that shrinks the band most."""
        return self.readings[0]

    @property
    def measure_servo(self) -> bool:
        """Tell whether measuring a servo shrinks the band more than the best reading."""
        measured = self.band_servo_measured
        return measured is not None and measured < self.band_after_best

    @property
    def _worth(self) -> bool:
        return self.band - self.band_after_best >= WORTH * self.band

    def in_words(self) -> str:
        """Return how well the speed is known, and which reading to take, if any."""
        if self.measure_servo and not self._worth:
            what = "No further push or station is worth its time now."
        else:
            first = "Of the readings take" if self.measure_servo else "Take next:"
            after = f"then the speed is known to {100 * self.band_after_best:.2g} %"
            what = f"{first} {self.best.in_words()}; {after}."
        return f"{self.note} {what} It is known to {100 * self.band:.2g} % now (95 %).".strip()

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return the best readings and the speed's band after each; none where words do."""
        if not self._worth:
            return [], []  # in words, nothing more
        timed = ["minutes"] if self.best.minutes is not None else []
        cells = [
            [r.in_words(), *(f"{r.minutes:.1f}" for _ in timed), f"{r.band_after_times:.1%}"]
            for r in self.readings[:_SHOWN]
        ]
        return ["reading", *timed, "speed known to"], cells

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name; fit_alarms only where there are any."""
        values = asdict(self)
        alarms = values.pop("fit_alarms")
        readings = [asdict(r) | {"in_words": r.in_words()} for r in self.readings]
        values |= {"measure_servo": self.measure_servo, "readings": readings}
        return values | ({"fit_alarms": list(alarms)} if alarms else {})


def gaits_that_matter(session: Session, gaits: Sequence[Gait]) -> tuple[Gait, ...]:
    """Return the gaits given, else those of the session's plan; raises BadInput for none.

    A planned gait that ran counts at the rate it had, as for `compare`: the board's clock errs.
    """
    wanted = tuple(gaits) or as_run(session, session.setup.procedure.gaits)
    if not wanted:
        raise BadInput(f"{session.where}: no gait to predict; name one with --gait")
    return wanted
