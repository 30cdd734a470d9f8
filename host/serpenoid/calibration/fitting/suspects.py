"""What each reading does to a fit, and which reading, bend, zero or file others contradict."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.errors import NotConverged
from ...session.session import Session
from .posterior import Mode
from .shared import FRICTIONS
from .unknowns import Floats

_REFITTED = 8  # so many suspects are fitted without, since a gross outlier is no linear step
_TOLD_APART = 2 * math.log(10.0)  # of chi2: one suspect is then ten times as likely as another
_LEAST_SIGMA = 1e-12  # of a friction whose draws are all at its limit of 0
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
        figures = asdict(self)
        shift = dict(zip(FRICTIONS, figures.pop("shift"), strict=False))
        return figures | {"shift_in_sigmas": shift}


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
        moved = shift[: mode.posterior.frictions] / np.maximum(sigma, _LEAST_SIGMA)
        out.append(Influence(number, leverage, rare, tuple(moved.tolist()), chi2))
    return tuple(out)


def _normal(chi2: float, rows: int) -> float:
    """Return the normal deviate that is as rare as a chi2."""
    from scipy.special import chdtrc, ndtri

    return float(-ndtri(max(chdtrc(rows, chi2), 1e-300) / 2))


def suspects_in_words(session: Session, mode: Mode) -> str:
    """Name what to look at first: without it the readings disagree least.

    Residuals would mislead, for a line follows its outlier. A suspect is one without which the
    others still tell every friction.
    """
    suspects, steps, left = _suspects(session, mode), {}, {}
    for words, rows in suspects.items():
        if (step := mode.without(rows)) is not None:
            steps[words] = step[0] + 2.0 * rows.sum()
    for words in sorted(steps, key=steps.__getitem__)[:_REFITTED]:
        try:
            without = mode.posterior.mode(mode.x, np.where(suspects[words], 0.0, 1.0))
            _ = without.covariance  # raises where the others leave a friction open
        except NotConverged:
            continue
        left[words] = without.chi2
    if not left:
        numbers = mode.posterior.numbers
        worst = numbers[int(np.argmax(np.where(numbers >= 0, np.abs(mode.residuals), 0.0)))]
        return f"Look at reading {worst} first: it is furthest off."
    score = {words: chi2 + 2.0 * suspects[words].sum() for words, chi2 in left.items()}
    least = min(score.values())
    return _named({w: chi2 for w, chi2 in left.items() if score[w] < least + _TOLD_APART})


def _suspects(session: Session, mode: Mode) -> dict[str, Rows]:
    """Return rows that may be wrong together, by what they are: readings, files, bends, zero."""
    posterior = mode.posterior
    numbers = posterior.numbers
    readings = dict.fromkeys(numbers[numbers >= 0].tolist())
    groups = {f"reading {number}": numbers == number for number in readings}
    pushes = session.kept_pushes
    for sha256 in dict.fromkeys(push.file_sha256 for push in pushes):
        group = [push.number for push in pushes if push.file_sha256 == sha256]
        if sha256 and len(group) > 1:
            named = ", ".join(map(str, group))
            groups[f"the file of readings {named}"] = np.isin(numbers, group)
    shared = {
        name: f"the bend of {math.degrees(angle):.3g}°{block.bends.where} as it was set"
        for block in posterior.blocks
        for name, angle in zip(block.bends.names, block.bends.angle_rad, strict=True)
    } | {"zero": "the inclinometer's zero as it was read"}
    priors = zip(posterior.names[posterior.frictions :], np.flatnonzero(numbers < 0), strict=True)
    for name, row in priors:
        if name in shared:
            words = shared[name]  # the same of two bends that were set alike
            groups[words] = groups.get(words, False) | (np.arange(len(numbers)) == row)
    return groups


def _named(left: dict[str, float]) -> str:
    """Say what to look at; left: chi2 without each."""
    if len(left) == 1:
        ((words, chi2),) = left.items()
        return (
            f"Without {words} chi2 would be {chi2:.1f}: look at that one first. Void it if it was "
            "misread."
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
