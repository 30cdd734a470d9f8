"""What the command line prints and writes: tables, summaries, CSV files, progress."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..base import rows
from .screen import screen

if TYPE_CHECKING:
    from ..base.rows import Result
    from ..friction.result import FrictionFit

console = screen(width=None if screen().is_terminal else 100, highlight=False)
notices = screen(stderr=True, soft_wrap=True, highlight=False)  # messages beside the answer


def warn(text: str) -> None:
    """Print a warning on standard error; nothing for an empty one."""
    if text:
        notices.print(f"serpenoid: warning: {text}")


def wrote(*paths: Path | None) -> None:
    """Say on standard error which files were written."""
    if any(paths):
        notices.print("wrote " + " and ".join(str(path) for path in paths if path))


def table(
    title: str, heads: Sequence[str], cells: Sequence[Sequence[str]], text_columns: int = 1
) -> None:
    """Print a table; the first columns are text, the others numbers. Nothing is cut off."""
    console.print(rows.table(title, heads, cells, text_columns))


def show(*results: Result, answer: str | None = None, verbose: bool = False) -> None:
    """Print the answer in a sentence, then the rows of all results as one table.

    answer: the sentence; by default that of the first result. verbose: also errors, margins and
    other powers.
    """
    console.print(results[0].in_words() if answer is None else answer)
    heads, cells = zip(*(result.table(verbose) for result in results), strict=True)
    if any(cells):
        table("", max(heads, key=len), list(itertools.chain(*cells)))


def influence(fit: FrictionFit) -> None:
    """Print how the parameters would change without each reading."""
    cells = [
        [
            str(i.reading),
            f"{residual + 0.0:+.1f}",
            "–" if i.chi2_without is None else f"{i.chi2_without:.1f}",
            *(f"{shift:+.2f}" for shift in (i.shift_in_sigmas or {}).values()),
        ]
        for i, residual in zip(fit.influence, fit.residuals, strict=True)
    ]
    columns = ["reading", "off by", "chi2 without", "ct", "cn", "ft0", "fn0"]
    table("change of the parameters without each reading (in their sigmas)", columns, cells)
