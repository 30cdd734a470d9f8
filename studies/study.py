"""The one runner of studies over simulated sessions: every case and session, on all cores."""

from __future__ import annotations

import math
import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np


def all_cores() -> ProcessPoolExecutor:
    """Return a pool of processes, one a core, that Ctrl-C ends without a word once they work."""
    spawn, silently = multiprocessing.get_context("spawn"), (signal.SIGINT, signal.SIG_DFL)
    return ProcessPoolExecutor(mp_context=spawn, initializer=signal.signal, initargs=silently)


@dataclass(frozen=True)
class Study:
    """Declare a study.

    cases: kinds of sessions. world: makes what all of them share from the cases. session: gives
    the result of (case, seed, number, world). rows: of (case, results). rarer: by how much a case
    has fewer sessions than the others.
    """

    cases: Sequence[Any]
    world: Callable[[Sequence[Any]], Any]
    session: Callable[[Any, int, int, Any], Any]
    rows: Callable[[Any, list[Any]], list[Any]]
    rarer: Callable[[Any], int] = lambda _case: 1

    def run(self, sessions: int, seed: int, tell: Callable[[str], None]) -> Iterator[Any]:
        """Yield the rows of every case."""
        tell("solving for the speeds that sessions are judged by")
        world = self.world(self.cases)
        with all_cores() as pool:
            for number, case in enumerate(self.cases, 1):
                numbers = range(max(sessions // self.rarer(case), 1))
                run_case = partial(_session, self.session, case, seed, world)
                results = list(pool.map(run_case, numbers, chunksize=10))
                tell(f"case {number} of {len(self.cases)}: {len(results)} sessions")
                yield from self.rows(case, results)


def kolmogorov(p_values: Sequence[float]) -> float:
    """Return how far p-values are from even ones, by Kolmogorov: 1.63 is the limit at 1 %."""
    ordered, count = np.sort(p_values), len(p_values)
    above = np.arange(1, count + 1) / count - ordered
    return float(math.sqrt(count) * max(above.max(), (1 / count - above).max()))


def _session(session: Callable[..., Any], case: Any, seed: int, world: Any, number: int) -> Any:
    return session(case, seed, number, world)
