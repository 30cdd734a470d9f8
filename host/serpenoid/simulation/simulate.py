"""A run in time: a scene is prepared once, run by the core, and its run given a judge."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import partial

from ..base.checks import check_kind
from ..base.errors import BadInput
from ..model.link_state import LinkState
from .core_run import Progress, run_core
from .judge import check_wanted, run_error, simulate_to
from .run import Run
from .scene import Scene
from .stability import check_step
from .starts import check_imposed, start_state


@dataclass(frozen=True, slots=True)
class Prepared:
    """Hold a scene that is ready to run, and the state that it and related scenes start from.

    progress: called now and then with the time in s.
    """

    scene: Scene
    start: LinkState
    progress: Progress | None = None

    @classmethod
    def of(cls, scene: Scene, progress: Progress | None = None) -> Prepared:
        """Find the state that a scene starts from."""
        if isinstance(scene.start, LinkState):
            check_imposed(scene, scene.start)
        return cls(scene, start_state(scene), progress)

    def run(self) -> Run:
        """Run the scene."""
        judge = partial(run_error, simulate=replace(self, progress=None).run_related)
        out = run_core(self.scene, self.start, self.progress)
        return Run(scene=self.scene, judge=judge, **out)

    def run_related(self, scene: Scene) -> Run:
        """Run a scene that has another method, step or record, or the exact model's joints."""
        check_step(scene)
        if scene.formulation != self.scene.formulation:
            return Prepared.of(scene, self.progress).run()
        return replace(self, scene=scene).run()


def simulate(
    scene: Scene,
    progress: Progress | None = None,
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
        check_wanted(accuracy, keep)
        return simulate_to(accuracy, scene, Prepared.of(scene, progress).run_related, keep)
    if keep:
        raise BadInput(f"keep is {keep!r} without an accuracy; give accuracy too, or leave it out")
    check_step(scene)
    return Prepared.of(scene, progress).run()
