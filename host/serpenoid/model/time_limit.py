"""The one limit of time for calls whose cost is not known before."""

from __future__ import annotations

import time

from .errors import NotConverged

LIMIT_S = 20.0


class TimeLimit:
    """End a call that takes longer than the limit. The core calls it as it reports progress.

    work: what takes so long, in the plural. way_out: what would help.
    """

    def __init__(self, work: str, way_out: str) -> None:
        self._message = f"{work} take longer than {LIMIT_S:g} s; {way_out}"
        self._end_s = time.monotonic() + LIMIT_S

    def __call__(self, _gaits: int = 0) -> None:
        """Raise NotConverged once the time is over."""
        if time.monotonic() > self._end_s:
            raise NotConverged(self._message)
