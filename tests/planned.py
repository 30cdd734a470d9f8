"""A session whose plan is written anew, as a person edits session.toml."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from serpenoid.session.folder import read_session


def replan(folder: Path, **changes: Any) -> None:
    """Change the plan of a session's folder."""
    setup = read_session(folder).setup
    planned = replace(setup, plan=replace(setup.plan, **changes))
    (folder / "session.toml").write_text(planned.text("a test", "2026-05-01T12:00:00Z"))
