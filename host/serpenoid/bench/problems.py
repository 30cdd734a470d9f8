"""The scenes of the benchmark, the error of a solution, and reference solutions.

On viscous ground the reference is SciPy's DOP853 at a tolerance of 1e-13 on the equations of
`scipy_peer`, which are independent of the core; its error is the difference from a second solution.
On dry ground it is an event-driven integration with DOP853 between the events, outside of the core;
its error is the change by a tolerance a hundred times looser. Stiff scenes take long, so all end
states are kept in references.json; `studies/references.py` solves the viscous ones again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.files import read_json
from ..model.gait import Gait
from ..model.link_state import LinkState
from ..model.presets import PRESETS
from ..model.robot import Robot
from ..simulation.scene import Scene
from ..simulation.simulate import start_state

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """A scene of the benchmark; quick: whether `bench --quick` includes it."""

    name: str
    title: str
    scene: Scene
    quick: bool

    @cached_property
    def start(self) -> LinkState:
        """Return the state from which every method starts, in which joint springs do not ring."""
        return start_state(self.scene)

    @property
    def bodies(self) -> int:
        """Return the number of links with independent positions: all on springs, else link 1."""
        return self.scene.robot.links if self.scene.formulation == "implicit" else 1

    def vector(self, state: LinkState) -> Array:
        """Return a link state as the vector of `scipy_peer`: positions, velocities, angle, rate."""
        x, y, theta, vx, vy, omega = state.packed().reshape(6, -1)
        places = [values[: self.bodies] for values in (x, y, vx, vy)]
        return np.concatenate([*places, theta[:1], omega[:1]])

    def error(self, end: Array, exact: Array, places_only: bool = False) -> float:
        """Return the largest scaled difference of two state vectors; places_only: without rates.

        Positions are in body lengths, angles in radians, and rates are these times omega.
        """
        body_m, count = self.scene.robot.body_length_m, 2 * self.bodies
        time_s = 0.0 if places_only else 1 / self.scene.gait.omega_rad_s
        scales = np.repeat([1 / body_m, time_s / body_m, 1, time_s], [count, count, 1, 1])
        return float(np.max(np.abs(end - exact) * scales))


def gait_deg(alpha_deg: float, beta_deg: float, omega_rad_s: float) -> Gait:
    """Return a gait with amplitude and phase lag in degrees."""
    return Gait(math.radians(alpha_deg), math.radians(beta_deg), omega_rad_s)


def paper_robot(links: int = 6, mass_kg: float = 1.0) -> Robot:
    """Return a robot like the paper's with another number or mass of links."""
    return Robot(links, mass_kg, 0.12)


PAPER_GROUND = PRESETS["paper"][1]  # Friction of the 2005 paper, viscous.


def springs(k: float, c: float) -> dict[str, Any]:
    """Return the fields of a scene with the stiffness k, N/m, and damping c, N s/m, of joints."""
    return {"formulation": "implicit", "joint_stiffness_n_m": k, "joint_damping_n_s_m": c}


def problems() -> tuple[Problem, ...]:
    """Return all problems in the order of the figure."""
    common: dict[str, Any] = {"start": "link1_at_rest"}
    three = Scene(paper_robot(3), PAPER_GROUND, gait_deg(30, 90, 3), **common)
    six = Scene(paper_robot(), PAPER_GROUND, gait_deg(30, 80, 5), **common)
    robot = Scene(*PRESETS["2005"], gait_deg(70, 75, 5), duration_s=5.0, **common)
    two_waves = Gait(math.radians(30), 4 * math.pi / 49, 5.0)
    fifty = Scene(paper_robot(50), PAPER_GROUND, two_waves, duration_s=5.0, **common)
    soft, stiff = springs(1e3, 1.0), springs(1e7, 1.0) | {"duration_s": 1.0}
    rows: tuple[tuple[str, str, Scene, dict[str, Any]], ...] = (
        ("paper3", "3 links, exact model", three, {}),
        ("paper3_k1e3", "3 links, springs k = 1e3, c = 1", three, soft),
        ("paper6", "6 links, exact model", six, {}),
        ("paper6_k1e3", "6 links, springs k = 1e3, c = 1", six, soft),
        ("robot2005", "2005 robot, Bingham friction, exact model", robot, {}),
        ("stiff_k1e7_c1", "6 links, stiff: k = 1e7, c = 1", six, stiff),
        ("stiff_k1e7_c1e3", "6 links, stiff: k = 1e7, c = 1e3", six, stiff | springs(1e7, 1e3)),
        ("n50", "50 links, exact model", fifty, {}),
        ("n50_k1e5", "50 links, springs k = 1e5, c = 10", fifty, stiff | springs(1e5, 10.0)),
    )
    quick = ("paper6", "paper6_k1e3", "robot2005")
    return tuple(
        Problem(name, title, replace(scene, **changes), name in quick)
        for name, title, scene, changes in rows
    )


FILE = Path(__file__).with_name("references.json")  # End states that are kept.


def reference(problem: Problem) -> tuple[Array, float]:
    """Return the reference end state of a problem as a vector, and its scaled error."""
    stored = read_json(FILE)[problem.name]
    return np.array(stored["end"]), stored["known_to"]
