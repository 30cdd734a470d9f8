"""Everyone in the comparison: our own methods from their table, and what else one might take."""

from __future__ import annotations

from importlib.util import find_spec

from ...simulation.methods import METHODS
from ...simulation.simulate import simulate
from ..peers.contender import STEPS_S, TOLERANCES, Contender, Work, even_step_s
from ..problems import Problem

OWN = "serpenoid"
MODULES = {
    "numba": "Numba, SciPy with a Numba right-hand side, SUNDIALS",
    "sksundae": "SUNDIALS",
    "mujoco": "MuJoCo",
}


def _own(problem: Problem, method: str) -> Contender:
    adaptive = problem.formulation in METHODS[method].adaptive

    def work(setting: float) -> Work:
        control = {"tolerance": setting} if adaptive else {"dt_s": even_step_s(problem, setting)}
        fields = {"method": method, "start": problem.start, "record_every": 10**9, **control}
        scene = problem.scene(**fields)  # made beforehand, as the parameters of the peers are
        return lambda: problem.vector(simulate(scene), -1)

    kind, settings = ("tolerance", TOLERANCES) if adaptive else ("dt_s", STEPS_S)
    return Contender(f"{OWN} {method}", OWN, kind, settings, work)


def absent() -> list[str]:
    """Return the peers that are not installed."""
    return [f"{module} ({what})" for module, what in MODULES.items() if not find_spec(module)]


def contenders(problem: Problem) -> list[Contender]:
    """Return everyone who solves a problem here; the right-hand sides of peers need Numba."""
    found = [_own(problem, method) for method in problem.methods()]
    if find_spec("numba"):
        from ..peers.compiled import numba, scipy, sundials

        found += [*scipy(problem), *numba(problem)]
        found += sundials(problem) if find_spec("sksundae") else []
    if find_spec("mujoco"):
        from ..peers.mujoco_peer import mujoco

        found += mujoco(problem)
    return found
