"""Which pushes or slides to take next, in minutes of work for per cent of the speeds' band."""

from __future__ import annotations

from collections.abc import Sequence

from ...model.drives import ServoKind
from ...model.gait import Gait
from ...servos.catalogue import HOBBY
from ..filmed_joints import servo_seen
from ..friction_fit import fit_friction
from ..session import Session
from ..speed_samples import Progress, band_parts, servo_fields, servo_note
from .floor_readings import candidates
from .next_reading import Advice, NextReading, gaits_that_matter
from .speed_slopes import speed_slopes

NOTE = (
    "By minutes of work: the first saves most of the band a minute. Once pushes are filmed, what "
    "joints really do is the larger part: a film of a crawl tells it (`serpenoid video`)."
)


def advise_on_floor(
    session: Session,
    gaits: Sequence[Gait] = (),
    *,
    samples: int = 48,
    by_film: bool | None = None,
    servo: ServoKind | None = HOBBY,
    progress: Progress | None = None,
) -> Advice:
    """Rank pushes and slides by how much of the speeds' band they save a minute.

    gaits: those that matter; the session's planned ones unless given. by_film: pushes can be
    filmed; as those taken were unless given. servo: as for `advise`. Raises
    BadInput as `advise` does.
    """
    wanted = gaits_that_matter(session, gaits)
    fit = fit_friction(session)
    filmed = any(p.track is not None for p in session.kept_pushes) if by_film is None else by_film
    now, options = candidates(session, filmed)
    servo = servo and servo_seen(session.setup.driving(servo), session.kept_films, fit)
    slopes = speed_slopes(fit, wanted, samples, progress)
    parts = band_parts(fit, wanted, servo)
    linear = slopes.band(now)
    rows = []
    for option in options:
        ratio = slopes.band(option.covariance) / linear
        left = parts.with_friction(ratio)
        rows.append(
            NextReading(
                option.kind,
                left,
                option.count,
                left,
                lambda_rad=option.lambda_rad,
                bend=session.setup.procedure.bend,
                minutes=option.minutes,
                told=option.told,
            )
        )
    rows.sort(key=lambda r: (r.band - parts.whole) / (r.minutes or 1.0))
    after = rows[0].band
    note = " ".join(filter(None, (NOTE, servo_note(parts, servo, after))))
    fields = servo_fields(servo, parts)
    return Advice(wanted, parts.whole, after, tuple(rows), note, *fields, fit.alarms)
