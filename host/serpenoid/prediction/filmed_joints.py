"""Joints as films showed them, in a comparison: which servos move them so, and a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..base.long_calls import in_threads
from ..base.particles import alike
from ..calibration.crawls.data import CrawlData, Crawls
from ..calibration.friction_result import FrictionFit
from ..calibration.speeds import AMPLITUDE_SIGMA, speed
from ..model.drives import Servo, ServoKind
from ..model.plugs import plugs
from ..periodic.servo_steady import servo_state
from ..periodic.steady import steady_gait
from ..session.film import FilmReading
from ..session.session import Session
from .speed_samples import SpeedSamples

AGREES = 2.0  # standard deviations
DRAWS, LEAST_DRAWS = 128, 3.0


def servo_seen(
    kind: ServoKind, films: Sequence[FilmReading], fit: FrictionFit, seed: int = 2005
) -> ServoKind:
    """Return the kind with those of its servos that would have moved the joints as filmed.

    The kind as it is, where no film was taken or too few of its servos would have: then something
    else than the servos made the amplitude.
    """
    if not films or kind.exact:
        return kind
    servos = kind.draws(DRAWS, seed)
    ideal = [
        steady_gait(fit.robot, fit.ground, film.commanded, rtol=1e-3, powers=False)
        for film in films
    ]

    def amplitudes(one: Servo) -> list[float]:
        return [servo_state(state, one, rough=True).amplitude for state in ideal]

    off = np.array(in_threads(amplitudes, servos)) - [film.mean_gain for film in films]
    sigma = np.hypot([film.gain_sigma for film in films], AMPLITUDE_SIGMA)
    chi2 = np.sum((off / sigma) ** 2, axis=1)
    if chi2.min() > AGREES**2 * len(films) or alike(-0.5 * chi2) < LEAST_DRAWS:
        return kind
    weight = np.exp(-0.5 * (chi2 - chi2.min()))
    chosen = np.random.default_rng(seed).choice(DRAWS, DRAWS, p=weight / weight.sum())
    return replace(kind, drawn=tuple(servos[k] for k in chosen))


def seen_on_film(
    crawls: Sequence[Crawls],
    fit: FrictionFit,
    drawn: SpeedSamples,
    measured: CrawlData,
    word: str,
    text: str,
) -> tuple[str, str]:
    """Return the verdict with what the films of some crawls say of the joints.

    It is `amplitude` where the joints as filmed explain the speed and as commanded do not.
    """
    for crawl in crawls:
        column, ran = drawn.gaits.index(crawl.gait), measured.gaits.index(crawl.gait)
        speed_m_s = float(measured.speed_m_s[ran])
        sigma = np.hypot(measured.sigma_m_s[ran], np.std(drawn.both_m_s[:, column]))
        share = float(np.median(drawn.shares[:, column]))
        gaits = crawl.gait, crawl.commanded
        predicted = [share * speed(fit.robot, fit.ground, gait) for gait in gaits]
        text = f"{text} {_words(crawl.films, predicted, speed_m_s)}"
        made, commanded = (abs(speed_m_s - each) < AGREES * sigma for each in predicted)
        if made and not commanded:
            word = "amplitude"
    return word, text


def swapped_plugs(session: Session) -> list[str]:
    """Return which joints each film shows in each other's place, in words: the first to mend."""
    words = []
    for film in session.kept_films:
        gait = film.gait
        shift = np.array(gait.joint_shift_rad, dtype=np.float64)
        phase = shift + gait.beta_rad * np.arange(len(shift), dtype=np.float64)
        order = plugs(phase, gait.beta_rad)[0]
        if swapped := [str(k + 1) for k, other in enumerate(order) if k != other]:
            words.append(
                f"First: film {film.number} shows joints {' and '.join(swapped)} as if their plugs "
                "were swapped. Swap them back and film again."
            )
    return words


def _words(films: Sequence[FilmReading], predicted: Sequence[float], measured: float) -> str:
    gains = np.array([film.mean_gain for film in films])
    sigma = np.linalg.norm([film.gain_sigma for film in films]) / len(films)
    numbers = " and ".join(str(film.number) for film in films)
    return (
        f"Film{'s' if len(films) > 1 else ''} {numbers} "
        f"show{'' if len(films) > 1 else 's'} joints at {100 * gains.mean():.1f} ± "
        f"{100 * sigma:.1f} % of the commanded amplitude: with joints as seen "
        f"{1e3 * predicted[0]:.2f} mm/s are predicted, as commanded {1e3 * predicted[1]:.2f}, and "
        f"{1e3 * measured:.2f} were measured."
    )
