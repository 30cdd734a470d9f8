"""SciPy's equations and solvers agree with the dense ones and the core; ratchet wheels, too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from scipy.integrate import solve_ivp
from serpenoid.bench.accuracy.measure import OWN, contenders
from serpenoid.bench.problems import Problem, problems
from serpenoid.bench.scipy_peer import Equations, scipy, solve
from simulation.truth_cases import rate_of

GROUNDS = {
    "viscous": sn.Ground(ct=(0.1, 2.0), cn=10.0),
    "dry": sn.Ground(ct=(0.1, 2.0), cn=10.0, ft0=(0.02, 0.3), fn0=0.1),
    "held backwards": sn.Ground(ct=0.1, cn=10.0, ft0=(0.0, 0.3)),
}


def ratchet(name: str, ground: str = "viscous") -> Problem:
    return replace(next(p for p in problems() if p.name == name), ground=GROUNDS[ground])


def test_the_dense_equations_and_the_core_go_the_same_way() -> None:
    gait, ground = sn.Gait(1.2, 3.0, 3.0), sn.Ground(ct=(0.1, 20.0), cn=1.0)
    problem = replace(ratchet("paper3"), gait=gait, ground=ground, duration_s=3.0)
    out = solve_ivp(rate_of(problem), (0, 3), problem.first, "DOP853", rtol=1e-10, atol=1e-12)
    end = out.y[:, -1]
    run = sn.simulate(problem.scene(start=problem.start, method="nonsmooth", tolerance=1e-11))
    # SciPy steps over the kinks of the friction by its error control alone
    assert problem.error(problem.vector(run.state()), end) < 1e-7
    forwards = replace(problem, ground=sn.Ground(0.1, 1.0)).scene(start=problem.start)
    assert problem.error(problem.vector(sn.simulate(forwards).state()), end) > 0.1


RATCHETS = [ratchet(name, ground) for name in ("paper6", "paper6_k1e3") for ground in GROUNDS]


@pytest.mark.parametrize("problem", [*problems(), *RATCHETS], ids=lambda p: p.name)
def test_plain_and_dense_rates_agree(problem: Problem) -> None:
    away = np.random.default_rng(3).normal(size=problem.first.size) * 0.3
    y = away if problem.ground.ratchet else problem.first + 0.01
    plain, dense = Equations(problem).rate(0.4, y), rate_of(problem)(0.4, y)
    # the dense system of 50 links loses some digits
    assert np.abs(plain - dense).max() < 1e-10 * np.abs(dense).max()


def test_dop853_and_the_core_reach_the_same_end() -> None:
    problem = next(p for p in problems() if p.name == "paper3")
    end = solve(problem, "DOP853", 1e-13)
    run = sn.simulate(problem.scene(start=problem.start, dt_s=1e-3, record_every=10**4))
    # RK4 at 1 ms over 10 s leaves some 1e-10 here
    assert problem.error(problem.vector(run.state()), end) < 1e-9


@pytest.mark.parametrize("method", ["RK45", "LSODA", "BDF"])
def test_scipy_solves_dry_ground_the_better_the_narrower_the_sign(method: str) -> None:
    problem = replace(next(p for p in problems() if p.name == "robot2005"), duration_s=0.4)
    exact = problem.vector(
        sn.simulate(problem.scene(start=problem.start, method="nonsmooth")).state()
    )
    peer = next(c for c in scipy(problem) if c.name == f"SciPy {method}")
    wide, narrow = (problem.error(peer.work(width)(), exact) for width in (1e-2, 1e-3))
    assert narrow < wide / 3 < 0.05


def test_our_own_methods_run_a_viscous_ratchet() -> None:
    problem = replace(ratchet("paper3"), duration_s=0.1)
    ours = {c.name: c for c in contenders(problem) if c.family == OWN}
    for name, contender in ours.items():
        assert np.isfinite(contender.work(contender.settings[2])()).all(), name
    assert set(ours) >= {"serpenoid rk4", "serpenoid nonsmooth"}
