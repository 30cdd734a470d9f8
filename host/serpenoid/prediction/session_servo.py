"""Servos from a session: which of a kind would have run its gaits so, frictions fitted beside."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..calibration.crawls.data import CrawlData
from ..calibration.crawls.fit import with_crawls
from ..calibration.friction_fit import fit_friction
from ..calibration.friction_result import DOUBTFUL, FrictionFit
from ..calibration.kinds.video import FilmReading
from ..calibration.session import Session
from ..model.drives import Servo, ServoKind
from ..model.errors import BadInput
from ..model.long_calls import in_threads
from ..periodic.servo_steady import servo_state
from ..periodic.steady import steady_gait
from ..servos.bench_test import KEPT, MeasuredServo, measured_servo
from ..servos.folded_film import film_ripples

Array = NDArray[np.float64]
LEAST_SERVOS = 3.0  # alike in weight, that are left of the pool


def servo_of_session(
    session: Session,
    like: ServoKind,
    fit: FrictionFit | None = None,
    *,
    name: str = "measured",
    seed: int = 0,
) -> MeasuredServo:
    """Return what a session's gait runs and films leave of a kind of servo.

    fit: of all other readings, the session's own unless given; a robust one takes any reading for
    a possible misreading. The crawls are fitted with friction,
    the joints' amplitude and the servos as unknowns (`crawls.fit`); each servo that this leaves
    then counts by the ripple of the joints in films. Raises BadInput.
    """
    fit, like = fit or fit_friction(session), session.setup.driving(like)
    if not session.kept_crawls:
        raise BadInput(f"{session.where}: no gait run and no film; take one with `calibrate`")
    if like.exact or not (session.kept or session.on_floor):
        raise BadInput(
            f"{session.where}: a servo is told by crawls beside stations or pushes, and from a "
            "kind that leaves room, such as hobby"
        )
    crawls = with_crawls(session, fit, like, seed, fit.method.startswith("robust"))
    assert crawls.servos is not None
    drawn, index = crawls.servos.drawn, np.array(crawls.servos.index)
    weight = np.exp(-0.5 * _ripple_chi2(session, fit, drawn, np.unique(index)))[index]
    weight /= weight.sum()
    poor = crawls.p_value is not None and crawls.p_value < DOUBTFUL
    by_servo = np.bincount(index, weight)
    count = 1 / float(np.sum(by_servo**2))
    if poor or count < min(LEAST_SERVOS, len(drawn) / 2):
        few = "no servo" if poor else f"{count:.1f} of {len(drawn)} servos"
        raise BadInput(
            f"{few} like {like.name} would have run so: too few to tell a servo by; look at "
            "`serpenoid compare`, or take another kind"
        )
    rng = np.random.default_rng(seed)
    kept = tuple(drawn[k] for k in rng.choice(index, KEPT, p=weight))
    typical = drawn[int(by_servo.argmax())]
    gaits = len(CrawlData.of(session))
    source = f"{gaits} gaits of {session.setup.name}, from {like.name}"
    readings = len(crawls.residuals) + gaits
    return measured_servo(like, typical, kept, name, source, crawls.chi2, readings)


def _ripple_chi2(
    session: Session, fit: FrictionFit, servos: tuple[Servo, ...], used: NDArray[np.intp]
) -> Array:
    """Return how far the ripples of used servos are from those filmed, less the least: (S,)."""
    chi2 = np.zeros(len(servos))
    for film in session.kept_films:
        if not (ripples := _ripples(film, servos[0].frame_s)):
            continue
        ideal = steady_gait(fit.robot, fit.ground, film.commanded, rtol=1e-3, powers=False)
        watch = [k for ripple in ripples for k in ripple.harmonics]

        def off(k: int) -> float:
            lines, total = servo_state(ideal, servos[k], False, watch).lines, 0.0  # noqa: B023
            for ripple in ripples:
                mine, lines = lines[: len(ripple.harmonics)], lines[len(ripple.harmonics) :]
                total += ripple.chi2(math.hypot(*mine))
            return total

        chi2[used] += in_threads(off, used.tolist())
    return chi2 - chi2[used].min()


def _ripples(film: FilmReading, frame_s: float) -> tuple:
    """Return how unevenly the joints of a film turn, where its track tells it."""
    if film.track is None:
        return ()
    rows = film.track.values
    return film_ripples(rows[:, 0], rows[:, 4:], film.omega_rad_s, frame_s)
