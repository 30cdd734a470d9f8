"""Servos from a session: which of a kind would have run its gaits so, friction being as fitted."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from ...model.drives import Servo, ServoKind
from ...model.errors import BadInput
from ...model.gait import Gait
from ...periodic.servo_steady import servo_state
from ...periodic.steady import Steady, steady_gait
from ...servos.bench_test import KEPT, MeasuredServo, measured_servo
from ...servos.folded_film import Ripple, film_ripples
from ..crawls.level import on_level
from ..crawls.runs import runs_by_gait
from ..filmed_joints import film_chi2
from ..friction_fit import fit_friction
from ..friction_result import FrictionFit
from ..kinds.video import FilmReading
from ..session import Session
from ..speed_samples import AMPLITUDE_SIGMA, sample_speeds

Array = NDArray[np.float64]
Ripples = tuple[Ripple, ...]
DRAWS, LEAST_DRAWS = 256, 3.0
_GRAIN = 0.01  # of the speed: how far servos are apart of which some are drawn
_UNLIKELY = 16.0  # chi2 a gait, of the best servo
_FAR = 13.0  # of chi2 from the best servo's: those beyond weigh less than 0.2 % of it each


def servo_of_session(
    session: Session,
    like: ServoKind,
    fit: FrictionFit | None = None,
    *,
    draws: int = DRAWS,
    name: str = "measured",
    seed: int = 0,
) -> MeasuredServo:
    """Return what a session's gait runs and films leave of a kind of servo.

    fit: the session's own unless given. Speeds count with the doubt about friction and the joints'
    amplitude; films also with amplitude and ripple of the joints. Raises BadInput.
    """
    fit, like = fit or fit_friction(session), session.setup.driving(like)
    session = on_level(session, fit)
    runs = runs_by_gait(session)
    films = [film for film in session.kept_films if film.gait in runs]
    if not runs:
        raise BadInput(f"{session.where}: no gait run and no film; take one with `calibrate`")
    asked = {film.gait: film.commanded for film in films}
    gaits = [asked.get(gait, gait) for gait in runs]
    filmed = [list(runs).index(film.gait) for film in films]
    ripples = dict(zip(filmed, (_ripples(f, like.servo.frame_s) for f in films), strict=True))
    servos = like.draws(draws, seed)
    drawn = sample_speeds(fit, gaits, amplitude_sigma=AMPLITUDE_SIGMA, seed=seed).joints_m_s

    def chi2_of(moved: Array) -> Array:
        speed = _by_speed(drawn, list(runs.values()), moved[..., 0])
        return speed + film_chi2(films, moved[:, filmed, 1]) + moved[..., 2].sum(axis=1)

    chi2 = _solved(fit, gaits, servos, ripples, chi2_of)
    weight = np.exp(-0.5 * (chi2 - chi2.min()))
    weight /= weight.sum()
    if (count := 1 / float(np.sum(weight**2))) < LEAST_DRAWS or chi2.min() > _UNLIKELY * len(gaits):
        raise BadInput(
            f"of {draws} servos like {like.name} {count:.1f} would have run so: too few to tell a "
            "servo by; look at `serpenoid compare`, or take another kind"
        )
    rng = np.random.default_rng(seed)
    kept = tuple(servos[k] for k in rng.choice(draws, KEPT, p=weight))
    best = servos[int(np.argmax(weight))]
    source = f"{len(gaits)} gaits of {session.setup.name}, from {like.name}"
    return measured_servo(like, best, kept, name, source, float(chi2.min()), len(gaits))


def _solved(
    fit: FrictionFit,
    gaits: list[Gait],
    servos: list[Servo],
    ripples: dict[int, Ripples],
    chi2_of: Callable[[Array], Array],
) -> Array:
    """Return each servo's chi2 by its fine states; inf where rough ones say that it is far off.

    Rough states are a fifth of the work and tell nothing of ripples, which only add to chi2.
    """
    ideal = [steady_gait(fit.robot, fit.ground, g, rtol=1e-3, powers=False) for g in gaits]
    moved = _moved(ideal, servos, None)
    solved = np.zeros(len(servos), bool)
    chi2 = chi2_of(moved)
    while True:
        least = chi2[solved].min(initial=math.inf) if solved.any() else chi2.min()
        near = np.flatnonzero(~solved & (chi2 <= least + _FAR))
        if not near.size:
            return np.where(solved, chi2, math.inf)
        moved[near] = _moved(ideal, [servos[k] for k in near], ripples)
        solved[near] = True
        chi2 = chi2_of(moved)


def _moved(ideal: list[Steady], servos: list[Servo], ripples: dict[int, Ripples] | None) -> Array:
    """Return shares of the ideal speed and of the amplitude, and ripples' chi2: (servos, gaits, 3).

    ripples: as films showed them; None for rough states, without.
    """

    def of(one: Servo) -> list[tuple[float, float, float]]:
        seen = ripples or {}
        return [
            _of_gait(state, one, seen.get(k, ()), ripples is None) for k, state in enumerate(ideal)
        ]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return np.array(list(pool.map(of, servos)))


def _of_gait(ideal: Steady, servo: Servo, seen: Ripples, rough: bool) -> tuple[float, float, float]:
    watch = [k for ripple in seen for k in ripple.harmonics]
    found = servo_state(ideal, servo, rough, watch)
    chi2, lines = 0.0, found.lines
    for ripple in seen:
        made, lines = math.hypot(*lines[: len(ripple.harmonics)]), lines[len(ripple.harmonics) :]
        chi2 += ripple.chi2(made)
    return found.speed / max(ideal.speed_m_s, 1e-9), found.amplitude, chi2


def _ripples(film: FilmReading, frame_s: float) -> Ripples:
    """Return how unevenly the joints of a film turn, where its track tells it."""
    if film.track is None:
        return ()
    rows = film.track.values
    return film_ripples(rows[:, 0], rows[:, 4:], film.omega_rad_s, frame_s)


def _by_speed(drawn: Array, runs: list[list], shares: Array) -> Array:
    """Return -2 log likelihood of the mean speeds with each servo, up to a constant.

    drawn: (samples, gaits) speeds of ideal joints, m/s, as friction and amplitude allow.
    """
    weights = [np.array([r.speed_sigma_m_s for r in one]) ** -2.0 for one in runs]
    speeds = np.array(
        [w @ [r.speed_m_s for r in one] / w.sum() for w, one in zip(weights, runs, strict=True)]
    )
    centre, spread = drawn.mean(axis=0), np.cov(drawn.T).reshape((len(runs),) * 2)
    noise = np.array([1 / w.sum() for w in weights]) + (_GRAIN * centre) ** 2
    each = shares[:, :, None] * spread * shares[:, None, :] + np.diag(noise)
    off = speeds - shares * centre
    out = np.einsum("ki,kij,kj->k", off, np.linalg.inv(each), off)
    log_volume = np.linalg.slogdet(each)[1]
    return out + log_volume - log_volume.min()
