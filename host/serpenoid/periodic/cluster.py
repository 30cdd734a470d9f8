"""The shapes of a grid, solved here or by the workers of a Dask cluster."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
from typing import Any

import numpy as np

from .. import _core
from ..base.errors import BadInput, ClusterFailed
from ..base.long_calls import Progress
from ..base.vectors import Array
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot

Shape = tuple[Robot, Ground, Gait]  # its gait at the first rate


def solve_shapes(
    shapes: Sequence[Shape],
    rates: Sequence[float],
    rtol: float,
    powers: bool,
    threads: int = 1,
    progress: Progress | None = None,
) -> Array:
    """Return the core's eleven figures of each shape at each rate, (shape, rate, 11).

    A shape's are the same to the last bit whatever shapes are solved with it.
    """
    models = [core_model(*shape) for shape in shapes]
    return _core.sweep(models, rates, rtol, powers, min(threads, len(models)), progress)


def solve_chunk(required: str, shapes: Sequence[Shape], **how: Any) -> Array:
    """Return a worker's figures of some shapes; raises ClusterFailed for another version.

    Only the same version gives the same figures to the last bit.
    """
    if (present := version("serpenoid")) != required:
        raise ClusterFailed(
            f"a worker has serpenoid {present}, here is {required}; install the same version there"
        )
    return solve_shapes(shapes, **how)


def solve_on_cluster(
    scheduler: str,
    shapes: Sequence[Shape],
    rates: Sequence[float],
    rtol: float,
    powers: bool,
    progress: Progress | None,
) -> Array:
    """Return what `solve_shapes` does, from the workers; raises BadInput, ClusterFailed.

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
    dask_errors = distributed.CancelledError, distributed.KilledWorker, distributed.TimeoutError
    lost = OSError, ValueError, TypeError, ImportError, *dask_errors
    try:
        client: Any = distributed.Client(scheduler, set_as_default=False)
        with client:
            client.wait_for_workers(1, 60.0)
            # With four chunks a thread all threads end at about the same time.
            share = -(-len(shapes) // (4 * sum(client.nthreads().values())))
            # 2000 gaits on dry ground are about a second of work.
            size = min(share, max(1, 2000 // len(rates)))
            chunks = [shapes[k : k + size] for k in range(0, len(shapes), size)]
            how = {"rates": rates, "rtol": rtol, "powers": powers}
            solve = partial(solve_chunk, version("serpenoid"), **how)
            parts = []
            for future in client.map(solve, chunks, pure=False):
                parts.append(future.result())
                if progress is not None:
                    progress(parts[-1].shape[0] * parts[-1].shape[1])
            return np.concatenate(parts)
    except lost as error:
        raise ClusterFailed(
            f"the cluster at {scheduler} gives no answer ({type(error).__name__}: {error}); see "
            "that `dask scheduler` and `dask worker` run with serpenoid, and what they logged"
        ) from None
