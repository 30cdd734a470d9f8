"""A run in time: checked, started, run by the core, and given its judge."""

from __future__ import annotations

from collections.abc import Callable, Collection

from ..model.checks import check_kind
from ..model.errors import BadInput
from ..model.link_state import LinkState
from .accuracy import simulate_to
from .core_run import run_core
from .judge import RunJudge
from .run import Run
from .scene import Scene
from .stability import check_step
from .starts import check_imposed, start_state


def simulate(
    scene: Scene,
    progress: Callable[[float], object] | None = None,
    *,
    accuracy: float | None = None,
    keep: Collection[str] = (),
) -> Run:
    """Run a scene and return what it recorded.

    Parameters
    ----------
    scene
        The run's description.
    progress
        Called now and then with the time in s.
    accuracy
        Largest estimated error, in body lengths and rad. If given, the step or tolerance is chosen
        for it, and the method too unless the scene names one. `Run.picked` says which and why.
    keep
        "dt_s", "tolerance": what `accuracy` must not change.

    Returns
    -------
    Run
        The record, and its error.

    Raises
    ------
    BadInput
        For a scene that cannot run.
    StepTooLarge
        Before the run, if dt_s is outside the method's stability region.
    Diverged
        If the state leaves the finite numbers or the method gives up; the message has the time.
    NotConverged
        If `accuracy` cannot be reached.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> run = sn.simulate(sn.Scene(robot, ground, gait, duration_s=0.5))
    >>> run.x_m.shape[1]
    6
    """
    check_kind("scene", scene, Scene)
    if accuracy is not None:
        return simulate_to(accuracy, scene, lambda one: simulate(one, progress), keep)
    if keep:
        raise BadInput(f"keep is {keep!r} without an accuracy; give accuracy too, or leave it out")
    check_step(scene)
    if isinstance(scene.start, LinkState):
        check_imposed(scene, scene.start)
    return Run(scene=scene, judge=_JUDGE, **run_core(scene, start_state(scene), progress))


_JUDGE = RunJudge(simulate)
