"""Tables in Markdown pages that a benchmark renews between two markers."""

from __future__ import annotations

from pathlib import Path

from ..model.errors import BadInput
from ..model.files import read_text, write_text


def renew_table(path: Path, name: str, table: str) -> None:
    """Put a table between the markers `<!-- NAME: begin -->` and `<!-- NAME: end -->` of a page.

    Raises BadInput where a marker is missing or stands twice; the page is then left as it is.
    """
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    text = read_text(path)
    if text.count(begin) != 1 or text.count(end) != 1:
        raise BadInput(f"{path} must have {begin!r} and {end!r} once each, around the table")
    head, rest = text.split(begin)
    write_text(path, f"{head}{begin}\n{table}\n{end}{rest.split(end)[1]}")
