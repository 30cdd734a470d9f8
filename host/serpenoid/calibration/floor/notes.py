"""What to know about pushes: which friction they leave open, and what was odd."""

from __future__ import annotations

import math

import numpy as np

from ...base.errors import BadInput
from ...session.session import Session
from ..fitting.posterior import Mode, Posterior
from .block import Pushes

OPEN = 0.5  # of the whole force, in error: a friction is then not told


def check_floor(session: Session, mode: Mode) -> None:
    """Raise BadInput if a friction's error is as large as all the force there is on a floor."""
    blocks = mode.posterior.blocks
    pushes = [block for block in blocks if isinstance(block, Pushes)]
    fast = max((t.pushed_m_s for block in pushes for t in block.tracks), default=0.5)
    bent = any(block.bends.share.any() for block in blocks)
    pairs = [
        ("ct and ft0", 0, 2, "pushes of the straight robot at 0.9 m/s, both ways, filmed"),
        ("cn and fn0", 1, 3, "pushes in the balanced bend of 42 degrees, both ways, filmed"),
    ]
    ridge = 1e-6 * np.eye(len(mode.x))  # what is wholly open then has a vast error
    sigma = np.sqrt(np.diag(np.linalg.inv(mode.information + ridge)))
    # without any bent reading fn0 is boundless, and ft0 with it where links stand off a little
    for names, viscous, dry, cure in pairs if bent else reversed(pairs):
        force = mode.x[viscous] * fast + mode.x[dry]
        off = max(sigma[viscous] * fast, sigma[dry]) / max(force, 1e-9)
        if not np.isfinite(off) or off > OPEN:
            by = f"are open by {off:.0%} of the force" if off < 1.0 else "stay wholly open"
            raise BadInput(
                f"{session.where}: {names} cannot be told from {len(session.kept_pushes)} "
                f"push(es): they {by}; take {cure}"
            )


def _turned_round(session: Session) -> list[int]:
    """Return the filmed pushes that go the other way in the picture than their word says.

    By the most of a place: a camera that stays shows "there" and "back" in opposite directions.
    """
    turned = []
    for place in {p.place for p in session.kept_pushes}:
        there = []
        for push in session.kept_pushes:
            if push.by == "film" and push.place == place:
                _, x, y = push.counted
                sign = 1.0 if push.way == "there" else -1.0
                there.append((push.number, sign * np.array([x[-1] - x[0], y[-1] - y[0]])))
        if len(there) < 3:
            continue
        mean = np.median([way / np.hypot(*way) for _, way in there], axis=0)
        turned += [number for number, way in there if way @ mean < 0.0]
    return sorted(turned)


def floor_notes(session: Session, posterior: Posterior) -> list[str]:
    """Return what a reader of a floor session's numbers should know, in words."""
    blocks = [block for block in posterior.blocks if isinstance(block, Pushes)]
    if not blocks:
        return []
    notes, rolls = [], blocks[0].rolling.rolling
    voided = sum(push.voided for push in session.of("push"))
    if voided:
        notes.append(f"{voided} voided push(es) left out.")
    odd = _turned_round(session)
    if odd:
        notes.append(
            f"Push(es) {', '.join(map(str, odd))} went the other way in the picture than those of "
            "the same word: is there and back mixed up, or was the camera moved? Void and add them "
            "again with the right way; a wrong one spoils ft0 unseen."
        )
    if session.setup.robot_table.wheels_kg is None:
        notes.append(
            "Nobody said what the wheels weigh: their turning is taken for "
            f"{rolls[0]:.1%} ± {rolls[1]:.1%} of the mass. wheels_kg in session.toml makes all "
            "four frictions surer."
        )
    return notes + [note for block in blocks for note in _one_way(block)]


def _one_way(pushes: Pushes) -> list[str]:
    notes = []
    for k, place in enumerate(pushes.places):
        ways = pushes.way[pushes.place == k]
        if np.ptp(ways) == 0.0:
            where = f" at {place}" if place else ""
            notes.append(
                f"All pushes{where} went one way: the floor may slope by "
                f"{math.degrees(pushes.slope_sigma_rad):.2g} degrees, and ft0 is only as sure as "
                "that. Push as often the other way."
            )
    return notes
