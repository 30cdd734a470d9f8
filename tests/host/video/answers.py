"""Answers of `serpenoid video`."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import serpenoid as sn
from command_line import serpenoid


def film_answer(film: object, line: str = "") -> Any:
    """Return the answer of `serpenoid video FILM LINE`; raise BadInput if the command fails."""
    result = serpenoid(f"video {film} {line} --json")
    if result.returncode:
        raise sn.BadInput(result.stderr)
    return json.loads(result.stdout, object_hook=lambda values: SimpleNamespace(**values))


def remarks_of(run: Any) -> dict[str, str]:
    """Return the texts of the remarks, by name."""
    return {remark.name: remark.text for remark in run.remarks}
