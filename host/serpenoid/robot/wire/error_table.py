"""Why the board refuses a line, in the firmware's own words (firmware/lib/protocol)."""

from __future__ import annotations

from ..._core import firmware
from ...model.errors import CommandRefused
from .protocol import Verdict

ERRORS = {word: tuple(row) for word, *row in firmware.ERRORS}  # number, what happened, what to do


def refused(text: str, verdict: Verdict) -> CommandRefused:
    """Return the error that the board refused a command: its own detail, or else the table's."""
    detail = verdict.detail
    if not detail and verdict.error in ERRORS:
        detail = "- {1}; {2}".format(*ERRORS[verdict.error])
    return CommandRefused(f"the board refuses {text!r}: {verdict.error} {detail}", verdict.error)
