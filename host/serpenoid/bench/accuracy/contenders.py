"""Everyone in the comparison: our own methods from their table, and what else one might take."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec

from ...simulation.methods import METHODS
from ...simulation.simulate import simulate
from ..problems import Array, Problem

Work = Callable[[], Array]
STEPS_S = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
OWN = "serpenoid"


@dataclass(frozen=True)
class Contender:
    """Hold one way to solve a problem: work(problem, setting) makes the call that is timed.

    setting: one of settings, loosest first; kind says what it is: "dt_s", "tolerance" or
    "width_m_s" (of the smoothed sign, at a tolerance that does not show).
    """

    name: str
    family: str
    kind: str
    settings: tuple[float, ...]
    work: Callable[[Problem, float], Work]


def even_step_s(problem: Problem, dt_s: float) -> float:
    """Return the step next to dt_s of which the duration is a whole number."""
    return problem.duration_s / max(1, round(problem.duration_s / dt_s))


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
    law = "dry" if problem.ground.dry else "viscous"
    return [
        _own(problem, name)
        for name, kind in METHODS.items()
        if problem.formulation in kind.formulations and law in kind.laws
    ]


def absent() -> list[str]:
    """Return the peers that are not installed."""
    modules = {"numba": "Numba, SciPy with a Numba right-hand side, SUNDIALS",
               "sksundae": "SUNDIALS", "mujoco": "MuJoCo"}  # fmt: skip
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
