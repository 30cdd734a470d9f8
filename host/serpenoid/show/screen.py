"""The one way to a terminal: what comes from files, boards and users is never taken as markup."""

from __future__ import annotations

from typing import Any

from rich.console import Console


def screen(**options: Any) -> Console:
    """Return a rich console that shows text as it is, `[/b]` and `:smile:` included."""
    return Console(markup=False, emoji=False, **options)
