"""The benchmark's hand-written equations agree with the dense ones, its solvers with the core."""

import numpy as np
import pytest

pytest.importorskip("numba", reason="an optional peer: pip install 'serpenoid[bench]'")

import serpenoid as sn
from serpenoid.bench.peers import numba_equations
from serpenoid.bench.problems import problems
from simulation.truth_cases import rate_of


@pytest.mark.parametrize("problem", problems(), ids=lambda p: p.name)
def test_numba_and_dense_rates_agree(problem):
    y = problem.first + 0.01
    compiled = numba_equations.rate_array(
        problem.implicit, 0.37, y, numba_equations.parameters(problem)
    )
    plain = rate_of(problem)(0.37, y)
    # the dense system of 50 links loses some digits
    assert np.abs(compiled - plain).max() < 1e-10 * np.abs(plain).max()


def test_dop853_and_the_core_reach_the_same_end():
    problem = next(p for p in problems() if p.name == "paper3")
    p = numba_equations.parameters(problem)
    end, steps = numba_equations.dop853_run(False, problem.first, p, 10.0, 1e-13, 1e-14, 10**6)
    run = sn.simulate(problem.scene(start=problem.start, dt_s=1e-3, record_every=10**4))
    assert steps > 0
    # RK4 at 1 ms over 10 s leaves some 1e-10 here
    assert problem.error(problem.vector(run.state()), end) < 1e-9
