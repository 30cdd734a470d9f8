"""Sweeps on a real Dask cluster of two processes: same bits, a lost worker, other versions."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005, PAPER, VISCOUS
from serpenoid.base.errors import ClusterFailed
from serpenoid.periodic import cluster as cluster_module

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")

AXES = {
    "alpha_rad": np.linspace(0.2, 1.2, 6),
    "beta_rad": [0.5, 0.9, 1.3],
    "omega_rad_s": [1.0, 5.0, 9.0],
}


@pytest.fixture(scope="module")
def local() -> Iterator[Any]:
    """Return a cluster of two processes; who asks a worker that is dead waits for 5 s, not 30."""
    started_by, asked_by = ({"distributed.comm.timeouts.connect": s} for s in ("120s", "5s"))
    with dask.config.set(started_by):  # of a busy machine
        made = distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
        )
    with made, dask.config.set(asked_by):
        yield made


def same(one: sn.Sweep, other: sn.Sweep) -> bool:
    return all(
        np.array_equal(getattr(one, n), getattr(other, n)) for n in sn.Sweep.__match_args__[3:13]
    )


@pytest.mark.parametrize(("robot", "ground"), [(PAPER, VISCOUS), (OF_2005, BINGHAM)])
def test_a_cluster_gives_the_same_bits(local: Any, robot: sn.Robot, ground: sn.Ground) -> None:
    done: list[int] = []
    there = sn.sweep(
        robot,
        ground,
        **AXES,
        rtol=1e-4,
        scheduler=local.scheduler_address,
        progress=done.append,
    )
    assert sum(done) == 54
    assert len(done) > 2  # told piece by piece
    assert same(there, sn.sweep(robot, ground, **AXES, rtol=1e-4))


def test_a_worker_killed_in_the_middle_is_done_without(local: Any) -> None:
    """Its pieces are under way on it and their results lie on it when it dies."""
    axes = AXES | {"alpha_rad": np.linspace(0.2, 1.2, 12)}
    victim = local.workers[0]
    died: list[int] = []

    def kill(_done: int) -> None:
        if not died:
            died.append(victim.pid)
            os.kill(victim.pid, signal.SIGKILL)

    there = sn.sweep(
        OF_2005, BINGHAM, **axes, rtol=1e-6, scheduler=local.scheduler_address, progress=kill
    )
    assert died
    with pytest.raises(ProcessLookupError):
        os.kill(died[0], 0)
    assert same(there, sn.sweep(OF_2005, BINGHAM, **axes, rtol=1e-6))


def test_what_is_no_cluster_is_told() -> None:
    soon = dask.config.set({"distributed.comm.timeouts.connect": "0.3s"})
    with soon, pytest.raises(ClusterFailed, match="the cluster at tcp://127"):
        sn.sweep(PAPER, VISCOUS, **AXES, scheduler="tcp://127.0.0.1:9")


def test_a_worker_of_another_version_is_refused(local: Any, monkeypatch) -> None:
    there = cluster_module.version("serpenoid")
    monkeypatch.setattr(cluster_module, "version", lambda name: "9.9")
    with pytest.raises(ClusterFailed, match=f"has serpenoid {there}, here is 9.9"):
        sn.sweep(PAPER, VISCOUS, **AXES, scheduler=local.scheduler_address)
