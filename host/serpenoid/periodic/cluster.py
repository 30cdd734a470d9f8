"""A grid that is solved by the workers of a Dask cluster."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from importlib.metadata import version
from typing import Any

from ..base.errors import BadInput, ClusterFailed
from ..base.vectors import Array
from .grid import Grid, Stretch, stretches

CONNECT_S = 10.0  # for the scheduler to answer
FIRST_WORKER_S = 60.0  # for the first worker to come
CHUNKS_PER_THREAD = 4  # at least, so that all of the cluster's threads end at about the same time
GAITS_PER_CHUNK, DRY_GAITS_PER_CHUNK = 20_000, 2_000  # at most: about a second of work


def solve_chunk(grid: Grid, wanted: str, chunk: Stretch) -> Array:
    """Return a worker's figures of a chunk; raises ClusterFailed for another version than wanted.

    Only the same version gives the same figures to the last bit.
    """
    if (found := version("serpenoid")) != wanted:
        raise ClusterFailed(
            f"a worker has serpenoid {found}, here is {wanted}; install the same version there"
        )
    return grid.solve(*chunk, threads=1)


def solve_on_cluster(grid: Grid, scheduler: str) -> Iterator[tuple[Stretch, Array]]:
    """Yield the chunks of a grid with their figures, in order; raises BadInput, ClusterFailed.

    The scheduler gives the chunks of a lost worker to another one.
    """
    try:
        import distributed
    except ImportError:
        raise BadInput(
            "--scheduler needs Dask, which is not installed; pip install 'serpenoid[dask]'"
        ) from None
    if not re.fullmatch(r".+:\d+/?", scheduler):
        raise BadInput(
            f"--scheduler is {scheduler!r}; it must be an address with a port, such as "
            "tcp://10.0.0.1:8786, which `dask scheduler` prints when it starts"
        )
    lost = (OSError, ValueError, TypeError, ImportError)
    lost += (distributed.CancelledError, distributed.KilledWorker, distributed.TimeoutError)
    try:
        client: Any = distributed.Client(scheduler, timeout=CONNECT_S, set_as_default=False)
        with client:
            client.wait_for_workers(1, FIRST_WORKER_S)
            share = -(-grid.shapes // (CHUNKS_PER_THREAD * sum(client.nthreads().values())))
            smooth = all(ground.smooth for ground in grid.grounds)
            gaits = GAITS_PER_CHUNK if smooth else DRY_GAITS_PER_CHUNK
            most = max(1, gaits // len(grid.omega_rad_s))
            chunks = list(stretches(grid.shapes, min(share, most)))
            solve = partial(solve_chunk, grid, version("serpenoid"))
            futures = client.map(solve, chunks, pure=False)
            for chunk, future in zip(chunks, futures, strict=True):
                yield chunk, future.result()
    except lost as error:
        raise ClusterFailed(
            f"the cluster at {scheduler} gives no answer ({type(error).__name__}: {error}); see "
            "that `dask scheduler` and `dask worker` run with serpenoid, and what they logged"
        ) from None
