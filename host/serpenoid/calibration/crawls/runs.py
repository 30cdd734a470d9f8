"""The measured crawls of a session, those of one gait together."""

from __future__ import annotations

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
        same = [known for known in found if _same(known, gait)]
        found.setdefault(same[0] if same else gait, []).append(run)
    return dict(sorted(found.items(), key=lambda item: item[0].omega_rad_s))


def _same(one: Gait, other: Gait) -> bool:
    apart = abs(one.omega_rad_s - other.omega_rad_s) / one.omega_rad_s
    return replace(other, omega_rad_s=one.omega_rad_s) == one and apart < SAME_RATE
