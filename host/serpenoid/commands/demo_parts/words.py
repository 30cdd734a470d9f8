"""How the demo speaks: a few lines for each step, and a fit beside the truth."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from ...show import report

if TYPE_CHECKING:
    from ...calibration.friction_result import FrictionFit
    from ...model.ground import Ground

STEPS, WIDTH = 8, 96
FRICTIONS = ("ct", "cn", "ft0", "fn0")


def say(text: str) -> None:
    """Print a text as it stands."""
    report.console.print(text)


def step(number: int, *sentences: str) -> None:
    """Print what a step of the demo gave."""
    head = f"[{number}/{STEPS}] "
    text = " ".join(sentence for sentence in sentences if sentence)
    say(textwrap.fill(head + text, WIDTH, subsequent_indent=" " * len(head)))


def true_frictions(ground: Ground) -> dict[str, float]:
    """Return the true frictions of the whole snake by name."""
    return {name: getattr(ground, name) for name in FRICTIONS}


def beside_truth(fit: FrictionFit, ground: Ground) -> str:
    """Return how many intervals of a fit contain the truth, and the rolling friction for one."""
    truth, rows = true_frictions(ground), fit.rows()
    inside = sum(row.low <= truth[name] <= row.high for name, row in zip(truth, rows, strict=True))
    rolling = rows[FRICTIONS.index("ft0")]
    return (
        f"{inside} of {len(rows)} true frictions lie inside their 95 % intervals; dry friction "
        f"along is {rolling.value:.3g} N ({rolling.low:.3g} to {rolling.high:.3g}, truth "
        f"{truth['ft0']:.3g})."
    )
