"""What `serpenoid video` answers of a film."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import serpenoid as sn
from command_line import serpenoid


def measured(film: object, line: str = "") -> Any:
    """Return what `serpenoid video FILM LINE` answers, by attributes; raise what it refuses."""
    done = serpenoid(f"video {film} {line} --json")
    if done.returncode:
        raise sn.BadInput(done.stderr)
    return json.loads(done.stdout, object_hook=lambda values: SimpleNamespace(**values))


def remarks_of(run: Any) -> dict[str, str]:
    """Return the remarks of an answer, by name."""
    return {remark.name: remark.text for remark in run.remarks}
