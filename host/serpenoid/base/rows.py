"""Results as text: a sentence, and a table with name, unit, value and interval in each row."""

from __future__ import annotations

import importlib
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table


class Row(NamedTuple):
    """One row of a result; numbers that it lacks are NaN.

    low, high: the 95 % interval. sigma: standard deviation. detail: whether commands print the row
    with --verbose only, such as numerical errors and margins. words: text in place of the value.
    """

    name: str
    unit: str
    value: float = math.nan
    low: float = math.nan
    high: float = math.nan
    sigma: float = math.nan
    detail: bool = False
    words: str = ""

    @property
    def interval(self) -> str:
        """Return the interval in words, with its upper end alone if it begins at 0."""
        if math.isnan(self.high):
            return ""
        return f"{self.low:.3g} to {self.high:.3g}" if self.low else f"below {self.high:.3g}"

    @property
    def cells(self) -> list[str]:
        """Return name with unit, value with its standard deviation, and interval.

        Two digits of a standard deviation count, and the value ends at the second one.
        """
        value = "–" if math.isnan(self.value) else f"{self.value:.4g}"
        if self.sigma > 0.0:
            decimals = max(1 - int(f"{self.sigma:.1e}".partition("e")[2]), 0)
            value = f"{self.value:.{decimals}f} ± {self.sigma:.{decimals}f}"
        name = f"{self.name}, {self.unit}" if self.unit else self.name
        return [name, self.words or value, self.interval]


def detail(name: str, unit: str, value: float = math.nan, words: str = "") -> Row:
    """Return a row that commands print with --verbose only."""
    return Row(name, unit, value, detail=True, words=words)


class Result:
    """Something that can be printed: a sentence, and a table of rows."""

    __slots__ = ()

    def in_words(self) -> str:
        """Return the main answer in a sentence, in two digits; "" if the table has it."""
        return ""

    def rows(self) -> list[Row]:
        """Return the numbers, most wanted first; none where the sentence says all."""
        return []

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return heads and cells; rows of details only if verbose, intervals where there is one."""
        rows = [row for row in self.rows() if verbose or not row.detail]
        count = 3 if any(row.interval for row in rows) else 2
        return ["", "value", "95 % interval"][:count], [row.cells[:count] for row in rows]

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.in_words()}>"

    def __str__(self) -> str:
        from rich.console import Console

        text = Console(width=100, file=io.StringIO(), markup=False, emoji=False, highlight=False)
        text.print(self.in_words())
        if self.table()[1]:
            text.print(table("", *self.table()))
        return text.file.getvalue().strip()  # type: ignore[attr-defined]


class Plottable(Result):
    """A result that has a figure.

    serpenoid.show, which may use all rooms of results, draws the figure. It is imported by name at
    the first use, as the one exception from the order of the rooms.
    """

    __slots__ = ()

    def plot(self, path: Path | str | None = None, **details: Any) -> Figure:
        """Draw this result.

        Parameters
        ----------
        path
            File to write, PNG, PDF or SVG; none unless given.
        **details
            For a FrictionFit: `session`, whose readings are drawn with the fitted lines.

        Returns
        -------
        matplotlib.figure.Figure
            The figure, with `axes` and `savefig` as in matplotlib.

        Examples
        --------
        >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
        >>> ground = sn.Ground(ct=0.1, cn=10.0)
        >>> state = sn.steady_gait(robot, ground, sn.Gait.degrees(30, 80, hertz=0.8))
        >>> [axes.get_ylabel() for axes in state.plot().axes]
        ['speed (m/s)', 'net power (W)']
        """
        figures = importlib.import_module("serpenoid.show.result_figure")
        return figures.figure_of(self, path and Path(path), **details)


def table(
    title: str, heads: Sequence[str], cells: Sequence[Sequence[str]], text_columns: int = 1
) -> Table:
    """Return a table for printing; the first text_columns are text, the others numbers."""
    from rich.table import Table

    printed = Table(title=title, title_justify="left", title_style="bold", header_style="")
    printed.show_header = any(heads)
    for i, head in enumerate(heads):
        printed.add_column(head, justify="left" if i < text_columns else "right", overflow="fold")
    for row in cells:
        printed.add_row(*row)
    return printed


def two_digits(value: float) -> str:
    """Return a number in two digits, such as 0.10, 2.1 or 12."""
    return f"{value:#.2g}".removesuffix(".")


def ranged(value: float, unit: str, low: float, high: float) -> str:
    """Return a value with its range in two digits; in four if both ends would be the same."""
    if two_digits(low) == two_digits(high):
        return f"{value:.4g} {unit} ({low:.4g} to {high:.4g})"
    ends = f"{two_digits(low)} to {two_digits(high)}" if low else f"below {two_digits(high)}"
    return f"{two_digits(value)} {unit} ({ends})"
