"""Joints as a film showed them, in a comparison: no doubt about their amplitude, and a verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .friction_result import FrictionFit
from .kinds.video import FilmReading
from .session import Session
from .speed_samples import SpeedSamples, speed

AGREES = 2.0  # standard deviations


def joints_seen(drawn: SpeedSamples, session: Session) -> SpeedSamples:
    """Return the samples; the amplitude of gaits that a film showed is no longer in doubt."""
    filmed = {film.gait for film in session.kept_films}
    seen = np.array([gait in filmed for gait in drawn.gaits])
    joints = np.where(seen, drawn.friction_m_s, drawn.joints_m_s)
    return replace(drawn, joints_m_s=joints, both_m_s=joints * drawn.shares)


def seen_on_film(
    session: Session, fit: FrictionFit, drawn: SpeedSamples, word: str, text: str
) -> tuple[str, str]:
    """Return the verdict with what the films say of the joints.

    It is `amplitude` where the joints as filmed explain the speed and as commanded do not.
    """
    for film in session.kept_films:
        column = next((j for j, g in enumerate(drawn.gaits) if g == film.gait), None)
        if column is None:
            continue
        spread = float(np.std(drawn.friction_m_s[:, column]))
        sigma = float(np.hypot(film.speed_sigma_m_s, spread))
        made, commanded = (speed(fit.robot, fit.ground, g) for g in (film.gait, film.commanded))
        text = f"{text} {_words(film, made, commanded)}"
        explained = abs(film.speed_m_s - made) < AGREES * sigma
        if explained and abs(film.speed_m_s - commanded) > AGREES * sigma:
            word = "amplitude"
    return word, text


def _words(film: FilmReading, made: float, commanded: float) -> str:
    return (
        f"Film {film.number} shows joints at {100 * film.mean_gain:.1f} ± "
        f"{100 * film.gain_sigma:.1f} % of the commanded amplitude: with joints as seen "
        f"{1e3 * made:.2f} mm/s are predicted, as commanded {1e3 * commanded:.2f}, and "
        f"{1e3 * film.speed_m_s:.2f} were measured."
    )
