"""The measured crawls of a session, those of one gait together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...model.gait import Gait
from ..kinds.gait import GaitRun
from ..session import Session

SAME_RATE = 1e-3  # rates closer than this, relative, are repeats of one gait


def runs_by_gait(session: Session) -> dict[Gait, list[GaitRun]]:
    """Return the runs of every gait; the board's clock moves the rates of repeats by some ppm."""
    found: dict[Gait, list[GaitRun]] = {}
    runs = [(run.gait, run) for run in session.kept_gait_runs]
    runs += [(film.gait, film.gait_run) for film in session.kept_films]
    for gait, run in runs:
        same = [known for known in found if same_gait(known, gait)]
        found.setdefault(same[0] if same else gait, []).append(run)
    return dict(sorted(found.items(), key=lambda item: item[0].omega_rad_s))


def as_run(session: Session, gaits: Sequence[Gait]) -> tuple[Gait, ...]:
    """Return the gaits, each with the rate at which it ran, if it ran."""
    ran = list(runs_by_gait(session))
    return tuple(next((own for own in ran if same_gait(own, gait)), gait) for gait in gaits)


def same_gait(one: Gait, other: Gait) -> bool:
    """Tell whether two gaits differ by no more than the board's clock does."""
    apart = abs(one.omega_rad_s - other.omega_rad_s) / one.omega_rad_s
    return replace(other, omega_rad_s=one.omega_rad_s) == one and apart < SAME_RATE
