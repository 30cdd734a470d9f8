"""Why the board refuses a line, in the firmware's own words (firmware/lib/protocol)."""

from __future__ import annotations

from typing import NamedTuple

from ..._core import firmware
from ...model.errors import CommandRefused
from .protocol import Verdict


class ErrorText(NamedTuple):
    """One row of the table: number, what happened, what to do about it."""

    number: int
    cause: str
    cure: str


ERRORS = {word: ErrorText(*row) for word, *row in firmware.ERRORS}


def refused(text: str, verdict: Verdict) -> CommandRefused:
    """Return the error that the board refused a command: its own detail, or else the table's."""
    known = ERRORS.get(verdict.error)
    detail = verdict.detail or (f"- {known.cause}; {known.cure}" if known else "")
    return CommandRefused(f"the board refuses {text!r}: {verdict.error} {detail}", verdict.error)
