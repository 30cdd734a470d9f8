"""Everyone in the comparison: our own methods from their table, and what else one might take."""

from __future__ import annotations

from importlib.util import find_spec

from ...simulation.methods import METHODS
from ...simulation.simulate import simulate
from ..contender import STEPS_S, TOLERANCES, Contender, Work, even_step_s
from ..problems import Problem

OWN = "serpenoid"


def _own(problem: Problem, method: str) -> Contender:
    adaptive = problem.formulation in METHODS[method].adaptive

    def work(problem: Problem, setting: float) -> Work:
        control = {"tolerance": setting} if adaptive else {"dt_s": even_step_s(problem, setting)}
        fields = {"method": method, "start": problem.start, "record_every": 10**9, **control}
        scene = problem.scene(**fields)  # made beforehand, as the parameters of the peers are
        return lambda: problem.vector(simulate(scene), -1)

    settings = TOLERANCES if adaptive else STEPS_S
    return Contender(f"{OWN} {method}", OWN, "tolerance" if adaptive else "dt_s", settings, work)


def own(problem: Problem) -> list[Contender]:
    """Return every method of ours that runs a problem's formulation and friction law."""
    law = "viscous" if problem.ground.smooth else "dry"
    return [
        _own(problem, name)
        for name, kind in METHODS.items()
        if problem.formulation in kind.formulations and law in kind.laws
    ]


def absent() -> list[str]:
    """Return the peers that are not installed."""
    modules = {
        "numba": "Numba, SciPy with a Numba right-hand side, SUNDIALS",
        "sksundae": "SUNDIALS",
        "mujoco": "MuJoCo",
    }
    return [f"{module} ({what})" for module, what in modules.items() if not find_spec(module)]


def contenders(problem: Problem) -> list[Contender]:
    """Return everyone who solves a problem here; the right-hand sides of peers need Numba."""
    found = own(problem)
    if find_spec("numba"):
        from ..peers.compiled import numba, scipy

        found += [*scipy(problem), *numba(problem)]
        if find_spec("sksundae"):
            from ..peers.compiled import sundials

            found += sundials(problem)
    if find_spec("mujoco"):
        from ..peers.mujoco_peer import mujoco

        found += mujoco(problem)
    return found
