"""SciPy's plain equations agree with the dense ones and with the core."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from serpenoid.bench.problems import Problem, problems
from serpenoid.bench.scipy_peer import equations, solve
from serpenoid.bench.work_precision import contenders
from simulation.truth_cases import rate_of

GROUNDS = {
    "viscous": sn.Ground(ct=(0.1, 2.0), cn=10.0),
    "dry": sn.Ground(ct=(0.1, 2.0), cn=10.0, ft0=(0.02, 0.3), fn0=0.1),
    "held backwards": sn.Ground(ct=0.1, cn=10.0, ft0=(0.0, 0.3)),
}


def problem_of(name: str, **changes: object) -> Problem:
    return replace(next(p for p in problems() if p.name == name), **changes)


RATCHETS = [problem_of("paper6", ground=ground) for ground in GROUNDS.values()]
RATCHETS += [problem_of("paper6_k1e3", ground=ground) for ground in GROUNDS.values()]


@pytest.mark.parametrize("problem", [*problems(), *RATCHETS], ids=lambda p: p.name)
def test_plain_and_dense_rates_agree(problem: Problem) -> None:
    away = np.random.default_rng(3).normal(size=problem.first.size) * 0.3
    y = away if problem.ground.ratchet else problem.first + 0.01
    plain, dense = equations(problem)(0.4, y), rate_of(problem)(0.4, y)
    # the dense system of 50 links loses some digits
    assert np.abs(plain - dense).max() < 1e-10 * np.abs(dense).max()


def test_dop853_and_the_core_reach_the_same_end() -> None:
    problem = problem_of("paper3", duration_s=3.0)
    end = solve(problem, "DOP853", 1e-13)
    run = sn.simulate(problem.scene(start=problem.start, dt_s=1e-3, record_every=10**4))
    # RK4 at 1 ms leaves some 1e-10 here
    assert problem.error(problem.vector(run.state()), end) < 1e-9


def test_scipy_solves_dry_ground_the_better_the_narrower_the_sign() -> None:
    problem = problem_of("robot2005", duration_s=0.4)
    exact = problem.vector(
        sn.simulate(problem.scene(start=problem.start, method="nonsmooth")).state()
    )
    peer = next(c for c in contenders(problem) if c.name == "SciPy LSODA")
    wide, narrow = (problem.error(peer.work(width)(), exact) for width in (1e-2, 1e-3))
    assert narrow < wide / 3 < 0.05
