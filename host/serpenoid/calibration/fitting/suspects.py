"""What each reading does to a fit, and which reading, bend, zero or file others contradict."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.errors import NotConverged
from ..session import Session
from .posterior import Mode
from .shared import FRICTIONS
from .unknowns import Floats

_REFITTED = 5  # so many suspects are fitted without, since a gross outlier is no linear step
_TOLD_APART = 2 * math.log(10.0)  # of chi2: one suspect is then ten times as likely as another
Rows = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Influence:
    """What one reading does to a fit: how the parameters would move without it.

    reading: its number. leverage: 0 (the others say it as well) to 1 (nothing checks it).
    studentised: residual over its own standard deviation. shift: change of ct, cn, ft0, fn0 (and
    ct, ft0 backwards), if it were left out, in standard deviations of each. chi2_without: chi2 of
    the fit without it.
    """

    reading: int
    leverage: float
    studentised: float
    shift: tuple[float, ...]
    chi2_without: float

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name."""
        shift = dict(zip(FRICTIONS, self.shift, strict=False))
        return {
            "reading": self.reading,
            "leverage": self.leverage,
            "studentised": self.studentised,
            "shift_in_sigmas": shift,
            "chi2_without": self.chi2_without,
        }


def influences(mode: Mode, sign: Floats, share: Floats, sigma: Floats) -> tuple[Influence, ...]:
    """Return what each reading does, in the readings' order, by one linear step.

    sign, share: of each reading, its residual's sign, and the share of its variance that it has
    alone. sigma: of the frictions.
    """
    out = []
    numbers = mode.posterior.numbers
    readings = list(dict.fromkeys(numbers[numbers >= 0].tolist()))
    for number, side, alone in zip(readings, sign.tolist(), share.tolist(), strict=True):
        rows = numbers == number
        slopes = mode.slopes[rows]
        says = float(np.linalg.eigvalsh(slopes @ mode.covariance @ slopes.T)[-1])
        without = mode.without(rows)
        chi2, shift = without or (mode.chi2, np.zeros(len(mode.x)))
        rare = side * _normal(max(mode.chi2 - chi2, 0.0), int(rows.sum()))
        leverage = min(max(1.0 - (1.0 - says) / alone, 0.0), 1.0)
        moved = shift[: mode.posterior.frictions] / sigma
        out.append(Influence(number, leverage, rare, tuple(moved.tolist()), chi2))
    return tuple(out)


def _normal(chi2: float, rows: int) -> float:
    """Return the normal deviate that is as rare as a chi2."""
    from scipy.special import chdtrc, ndtri

    return float(-ndtri(max(chdtrc(rows, chi2), 1e-300) / 2))


@dataclass(frozen=True)
class _Suspect:
    """Some rows that may be wrong together: in words, and as a subject of a sentence."""

    words: str
    rows: Rows


def suspects_in_words(session: Session, mode: Mode) -> str:
    """Name what to look at first: without it the readings disagree least.

    Residuals would mislead, for a line follows its outlier. A suspect is one without which the
    others still tell every friction.
    """
    scores = []
    for suspect in _suspects(session, mode):
        without = mode.without(suspect.rows)
        if without is not None:
            scores.append((without[0] + 2.0 * suspect.rows.sum(), suspect))
    scores.sort(key=lambda score: score[0])
    left = {}
    for _, suspect in scores[:_REFITTED]:
        try:
            again = mode.posterior.mode(mode.x, np.where(suspect.rows, 0.0, 1.0))
        except NotConverged:
            continue
        left[suspect.words] = again.chi2 + 2.0 * (suspect.rows.sum() - 1), again.chi2
    if not left:
        numbers = mode.posterior.numbers
        worst = numbers[int(np.argmax(np.where(numbers >= 0, np.abs(mode.residuals), 0.0)))]
        return f"Look at reading {worst} first: it is furthest off."
    least = min(score for score, _ in left.values())
    return _named(
        {words: chi2 for words, (score, chi2) in left.items() if score < least + _TOLD_APART}
    )


def _suspects(session: Session, mode: Mode) -> Iterator[_Suspect]:
    posterior = mode.posterior
    numbers = posterior.numbers
    for number in dict.fromkeys(numbers[numbers >= 0].tolist()):
        yield _Suspect(f"reading {number}", numbers == number)
    files: dict[str, list[int]] = {}
    for push in session.kept_pushes:
        files.setdefault(push.file_sha256, []).append(push.number)
    for sha256, group in files.items():
        if sha256 and len(group) > 1:
            named = ", ".join(map(str, group))
            yield _Suspect(f"the file of readings {named}", np.isin(numbers, group))
    first_prior = len(numbers) - (len(posterior.unknowns) - posterior.frictions)
    bends = {
        name: f"the bend of {math.degrees(angle):.3g}°{block.bends.where} as it was set"
        for block in posterior.blocks
        for name, angle in zip(block.bends.names, block.bends.angle_rad, strict=True)
    }
    for k, unknown in enumerate(posterior.unknowns[posterior.frictions :]):
        words = bends | {"zero": "the inclinometer's zero as it was read"}
        if unknown.name in words:
            yield _Suspect(words[unknown.name], np.arange(len(numbers)) == first_prior + k)


def _named(left: dict[str, float]) -> str:
    """Say what to look at; left: chi2 without each."""
    if len(left) == 1:
        ((words, chi2),) = left.items()
        return (
            f"Without {words} chi2 would be {chi2:.1f}: look at that one first, or fit with method "
            "'robust'."
        )
    numbers = sorted(int(w.removeprefix("reading ")) for w in left if w.startswith("reading "))
    others = [words for words in left if not words.startswith("reading ")]
    parts = [f"reading {_listed(list(map(str, numbers)))}"] if numbers else []
    return (
        f"Without {_listed([*parts, *others])} chi2 would be {max(left.values()):.1f} or less: "
        "look at those first. Another reading of their series tells which one is wrong."
    )


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
