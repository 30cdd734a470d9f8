"""What each method does to the energy and the momentum of a snake that nothing acts on.

Six links, limp joints, no friction, thrown with a spin: energy, momentum and angular momentum are
constants of the motion, so what they do is the method's own doing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...model.errors import BadInput, Diverged, StepTooLarge
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.link_state import LinkState
from ...model.robot import Robot
from ...simulation.methods import METHODS
from ...simulation.run import Run
from ...simulation.scene import Scene
from ...simulation.simulate import simulate

ROBOT = Robot(6, 1.0, 0.12)
PLACE = (0.0, 0.0, 0.1, 0.5, -0.3, 0.2, 0.6, -0.1)
RATES = (0.3, -0.2, 1.0, -0.6, 0.8, 0.4, -0.9, 0.5)
TOLERANCE = 1e-11


@dataclass(frozen=True, slots=True)
class Drift:
    """Hold what a free snake, limp and without friction, gains or loses in so many steps.

    Relative to the energy at the start, and to the momentum that the links have taken singly.
    """

    method: str
    formulation: str
    steps: int
    dt_s: float
    energy: float
    momentum: float
    angular_momentum: float
    said: str = ""


def _scene(method: str, formulation: str, steps: int, dt_s: float) -> Scene:
    start = LinkState.joined(ROBOT, PLACE, RATES)
    scene = Scene(
        ROBOT,
        Ground(0.0, 0.0),
        Gait(0.0, 0.0, 1.0),
        formulation=formulation,
        joint_damping_n_s_m=0.0,
        drive="torque",
        torque=[0.0] * (ROBOT.links - 1),
        method=method,
        start=start,
        dt_s=dt_s,
        duration_s=steps * dt_s,
        record_every=10**9,
    )
    return replace(scene, tolerance=TOLERANCE) if scene.adaptive else scene


def drift(method: str, formulation: str, steps: int, dt_s: float) -> Drift:
    """Return how a method keeps what a free snake keeps, from the start to the end of a run."""
    try:
        run = simulate(_scene(method, formulation, steps, dt_s))
    except (StepTooLarge, Diverged, BadInput) as said:
        nothing = (math.nan,) * 3
        return Drift(method, formulation, steps, dt_s, *nothing, said=str(said))
    return Drift(method, formulation, steps, dt_s, *_changes(run))


def _changes(run: Run) -> tuple[float, float, float]:
    """Return the relative changes of energy, momentum and angular momentum."""
    m, inertia = ROBOT.link_mass_kg, ROBOT.inertia_kg_m2
    vx, vy, w = run.vx_m_s, run.vy_m_s, run.omega_rad_s
    energy = 0.5 * (m * (vx**2 + vy**2) + inertia * w**2).sum(axis=1)
    if run.scene.formulation == "implicit":
        energy = energy + 0.5 * run.scene.joint_stiffness_n_m * (run.gap_m**2).sum(axis=(1, 2))
    momentum = m * np.array([vx.sum(axis=1), vy.sum(axis=1)])
    spin = (m * (run.x_m * vy - run.y_m * vx) + inertia * w).sum(axis=1)
    speed, away = np.hypot(vx, vy), np.hypot(run.x_m, run.y_m)
    return (
        float(abs(energy[-1] / energy[0] - 1)),
        float(np.abs(momentum[:, -1] - momentum[:, 0]).max() / (m * speed[0].sum())),
        float(abs(spin[-1] - spin[0]) / (m * away * speed + inertia * abs(w)).sum(axis=1).max()),
    )


def run(steps: int, tell: Callable[[str], None]) -> list[Drift]:
    """Return the drift of every method that runs a free snake, at 1 and at 0.1 ms."""
    tell("free snake: energy and momentum ...")
    return [
        drift(name, formulation, steps, dt)
        for name, kind in METHODS.items()
        for formulation in kind.formulations
        for dt in (1e-3, 1e-4)
        if "torque" in kind.drives
    ]
