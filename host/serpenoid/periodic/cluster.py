"""A grid solved stretch by stretch: here, or by the workers of a Dask cluster."""

from __future__ import annotations

import re
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import islice
from typing import Any

from ..model.errors import BadInput, ClusterFailed
from ..model.long_calls import Progress
from ..model.vectors import Array
from .grid import Grid, stretches

Stretch = tuple[int, int]
_GAITS, _DRY_GAITS = 20_000, 2_000  # in a stretch: about a second's work for a processor
_AT_ONCE = 4096  # shapes solved here at a time: what bounds the memory beside the result
_AHEAD = 3  # stretches under way for each of the cluster's threads
_LOOK_S = 1.0  # how often Ctrl-C and the workers are looked after
NO_WORKER_S = 60.0  # without any worker before the work is given up
CONNECT_S = 10.0


def stretch_length(grid: Grid) -> int:
    """Return how many shapes make a good stretch."""
    dry = not all(ground.smooth for ground in grid.grounds)
    return max(1, (_DRY_GAITS if dry else _GAITS) // len(grid.omega_rad_s))


def solve_stretch(grid: Grid, wanted: str, stretch: Stretch) -> Array:
    """Solve a stretch on a worker, in the one thread that the worker gives to it.

    wanted: the package's version; the figures of another one may differ. Raises ClusterFailed.
    """
    from distributed import get_worker

    if (there := own_version()) != wanted:
        raise ClusterFailed(
            f"the worker {get_worker().address} has {there}, here is serpenoid {wanted}; "
            "figures are the same to the bit only with the same version on all: install it there"
        )
    return grid.solve(*stretch, threads=1)


def own_version() -> str:
    """Return the package's version."""
    from importlib.metadata import version

    return version("serpenoid")


@contextmanager
def connected(scheduler: str) -> Iterator[Any]:
    """Give a Dask client of a cluster."""
    try:
        import distributed
    except ImportError:
        raise BadInput(
            "--scheduler needs Dask, which is not installed; pip install 'serpenoid[dask]'"
        ) from None
    if not re.fullmatch(r"inproc://.+|((tcp|tls|ws|wss)://)?[^/]+:\d+/?", scheduler):
        raise BadInput(  # Dask would find out later, and leave a thread and a traceback behind
            f"--scheduler is {scheduler!r}; it must be an address with a port, such as "
            "tcp://10.0.0.1:8786, which `dask scheduler` prints when it starts"
        )
    if scheduler.startswith(("tls", "wss")):
        _check_certificates(scheduler)
    try:
        client = distributed.Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        raise ClusterFailed(
            f"no Dask scheduler answers at {scheduler!r} within {CONNECT_S:g} s ({error}); start "
            "one with `dask scheduler` and workers with `dask worker ADDRESS`, and give the "
            "address that it prints, such as tcp://10.0.0.1:8786"
        ) from None
    try:
        yield client
    finally:
        client.close()


def _check_certificates(scheduler: str) -> None:
    """Raise BadInput unless Dask's configuration has the certificates of an encrypted cluster."""
    from distributed.security import Security

    why = "its configuration here names none"
    try:
        if Security().get_connection_args("client").get("ssl_context") is not None:
            return
    except OSError as error:  # a file that is not there, or no certificate
        why = f"those of its configuration cannot be read: {error}"
    raise BadInput(
        f"--scheduler is {scheduler!r}: Dask needs certificates for this, and {why}; set "
        "distributed.comm.tls.ca-file, client.cert and client.key, as Dask's documentation says "
        "under TLS"
    )


@contextmanager
def _answering(scheduler: str) -> Iterator[None]:
    """Raise ClusterFailed where the scheduler is gone, or work is lost on its workers."""
    from distributed import CancelledError, KilledWorker

    try:
        yield
    except (OSError, CancelledError, KilledWorker, ImportError) as error:
        why = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise ClusterFailed(
            f"the cluster at {scheduler} gives no answer ({why}); what its scheduler and workers "
            "logged says more, such as a worker without serpenoid. Start it again and call again: "
            "a study (a folder) goes on where it was"
        ) from None


def solved(
    grid: Grid,
    threads: int,
    scheduler: str | None,
    progress: Progress | None,
    pieces: Iterable[Stretch] | None = None,
) -> Generator[tuple[Stretch, Array], None, None]:
    """Yield stretches of a grid with their figures; pieces: which, all unless given.

    Solved here by some threads, or where there is a scheduler by its cluster: in the order in which
    they are done, few under way at a time. A stretch whose worker is lost goes to another one.
    Whatever ends the iteration takes the work that is under way off the cluster. Raises
    ClusterFailed.
    """
    if scheduler is None:
        for stretch in pieces or stretches(grid.shapes, _AT_ONCE):
            yield stretch, grid.solve(*stretch, threads, progress)
        return
    with connected(scheduler) as client:
        under_way = dict[Any, Stretch]()
        threads = _threads(client, scheduler)
        if pieces is None:
            share = -(-grid.shapes // (4 * threads))
            pieces = stretches(grid.shapes, max(1, min(stretch_length(grid), share)))
        waiting, solve = iter(pieces), partial(solve_stretch, grid, own_version())
        try:
            while True:
                begun = list(islice(waiting, max(0, _AHEAD * threads - len(under_way))))
                under_way |= zip(client.map(solve, begun, pure=False), begun, strict=True)
                if not under_way:
                    return
                for future in _done(client, list(under_way), scheduler):
                    with _answering(scheduler):
                        table = future.result()
                    stretch = under_way.pop(future)
                    if progress is not None:
                        progress((stretch[1] - stretch[0]) * len(grid.omega_rad_s))
                    yield stretch, table
                if under_way:
                    threads = _threads(client, scheduler)
        finally:
            with suppress(OSError):  # of a scheduler that is gone, with all that was under way
                client.cancel(list(under_way), force=True)


def _threads(client: Any, scheduler: str) -> int:
    """Return the threads of the workers there are. Raises ClusterFailed where none comes."""
    import distributed

    with _answering(scheduler):
        try:
            if not client.nthreads():
                client.wait_for_workers(1, NO_WORKER_S)
        except distributed.TimeoutError:
            raise ClusterFailed(
                f"the cluster at {scheduler} has had no worker for {NO_WORKER_S:g} s; start some "
                f"with `dask worker {scheduler}`; if one ended by itself, its log says why, often "
                "another version of Dask"
            ) from None
        return max(sum(client.nthreads().values()), 1)


def _done(client: Any, futures: list[Any], scheduler: str) -> Iterable[Any]:
    """Return the futures that are done within a moment."""
    import distributed

    with _answering(scheduler), suppress(distributed.TimeoutError), client.as_current():
        waited: Any = distributed.wait(futures, _LOOK_S, return_when="FIRST_COMPLETED")
        return waited.done
    return ()
