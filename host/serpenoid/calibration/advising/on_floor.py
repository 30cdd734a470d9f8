"""Which pushes or slides to take next, in minutes of work for per cent of the speeds' band."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...model.drives import ServoKind
from ...model.errors import BadInput
from ...model.gait import Gait
from ..advice import Advice, NextReading, speed_slopes
from ..floor.candidates import candidates
from ..friction_fit import fit_friction
from ..friction_result import band
from ..session import Session
from ..speed_samples import AMPLITUDE_SIGMA, Progress, sample_speeds

NOTE = (
    "By minutes of work: the first saves most of the band a minute. Once pushes are filmed, what "
    "joints really do is the larger part: a film of a crawl tells it (`serpenoid video`)."
)


def advise_on_floor(
    session: Session, gaits: Sequence[Gait] = (), *, samples: int = 48,
    by_film: bool | None = None, servo: ServoKind | None = None, progress: Progress | None = None,
) -> Advice:  # fmt: skip
    """Rank pushes and slides by how much of the speeds' band they save a minute.

    gaits: those that matter; the session's planned ones unless given. by_film: pushes can be
    filmed; as those taken were unless given. servo: as for `advise`. Raises
    BadInput as `advise` does.
    """
    wanted = tuple(gaits) or session.setup.procedure.gaits
    if not wanted:
        raise BadInput(f"{session.where}: no gait to predict; name one with --gait")
    fit = fit_friction(session)
    filmed = any(p.track is not None for p in session.kept_pushes) if by_film is None else by_film
    now, options = candidates(session, filmed)
    slopes = speed_slopes(fit, wanted, samples, progress)
    drawn = sample_speeds(fit, wanted, amplitude_sigma=AMPLITUDE_SIGMA, servo=servo)
    halves = []
    for speeds in (drawn.both_m_s, drawn.friction_m_s):
        ends = [band(of_gait) for of_gait in speeds.T]
        halves.append(sum((b - a) / (b + a) for a, b in ends) / len(ends))
    whole, friction = halves
    linear = slopes.band(now)
    rows = []
    for option in options:
        ratio = slopes.band(option.covariance) / linear
        left = math.sqrt(max(whole**2 - friction**2, 0.0) + (ratio * friction) ** 2)
        rows.append(NextReading(
            option.kind, left, option.count, left, lambda_rad=option.lambda_rad,
            bend=session.setup.procedure.bend, minutes=option.minutes, told=option.told,
        ))  # fmt: skip
    rows.sort(key=lambda r: (r.band - whole) / (r.minutes or 1.0))
    named = servo and servo.name
    return Advice(wanted, whole, rows[0].band, tuple(rows), NOTE, named)
