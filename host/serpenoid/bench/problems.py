"""The scenes of the benchmark, the number by which solutions are judged, and the truth.

Viscous ground: SciPy's DOP853 at a tolerance of 1e-13 on the equations of `scipy_peer`, which share
nothing with the core. Known to the distance from a second solution. Dry ground: smooth motion
between switching events by the tests' reference (tests/oracle/contact_modes.py), known to what a
tolerance a hundred times looser changes. The stiff scenes take long, so all end states are kept in
references.json; `studies/references.py` solves the viscous ones again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import EllipsisType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import BadInput
from ..base.files import read_json
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.link_state import LinkState
from ..model.robot import Robot
from ..simulation.run import Run
from ..simulation.scene import Scene
from ..simulation.starts import start_state

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """Name a scene of the benchmark: what is solved, for how long, from which start."""

    name: str
    title: str
    robot: Robot
    ground: Ground
    gait: Gait
    duration_s: float
    stiffness_n_m: float = 0.0  # 0: the explicit formulation
    damping_n_s_m: float = 0.0

    @property
    def implicit(self) -> bool:
        """Tell which formulation is solved."""
        return self.stiffness_n_m > 0

    @property
    def formulation(self) -> str:
        """Return the name that a Scene gives the formulation."""
        return "implicit" if self.implicit else "explicit"

    def scene(self, **changes: object) -> Scene:
        """Return the scene from the common start; the fields given replace the problem's own."""
        fields = {
            "formulation": self.formulation,
            "duration_s": self.duration_s,
            "start": "link1_at_rest",
            **changes,
        }
        if self.implicit:
            fields.setdefault("joint_stiffness_n_m", self.stiffness_n_m)
            fields.setdefault("joint_damping_n_s_m", self.damping_n_s_m)
        return Scene(self.robot, self.ground, self.gait, **fields)  # type: ignore[arg-type]

    @cached_property
    def start(self) -> LinkState:
        """Return the state from which every contender starts (consistent: no ringing)."""
        method = "rk4" if self.ground.smooth else "nonsmooth"
        return start_state(self.scene(method=method))

    @property
    def first(self) -> Array:
        """Return the start as the peer's state vector (scipy_peer)."""
        return self.vector(self.start)

    def vector(self, state: LinkState | Run, at: int | EllipsisType = ...) -> Array:
        """Return a link state, or a run at one of its recorded times, as the peers' vector."""
        x, y, theta, vx, vy, omega = (
            getattr(state, name)[at]
            for name in ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
        )
        if self.implicit:
            return np.concatenate([x, y, vx, vy, [theta[0], omega[0]]])
        return np.array([x[0], y[0], theta[0], vx[0], vy[0], omega[0]])

    @property
    def scale(self) -> Array:
        """Return what counts as 1 in each entry: body length, radian, and these times omega."""
        body, w = self.robot.links * self.robot.link_length_m, self.gait.omega_rad_s
        if not self.implicit:
            return np.array([body, body, 1, body * w, body * w, w])
        n = self.robot.links
        return np.concatenate([np.full(2 * n, body), np.full(2 * n, body * w), [1, w]])

    @property
    def places(self) -> NDArray[np.bool_]:
        """Return which entries are places and angles, no rates."""
        n = self.robot.links
        kinds = [True, False, True, False] if self.implicit else [True, False]
        return np.repeat(kinds, [2 * n, 2 * n, 1, 1] if self.implicit else [3, 3])

    def error(self, end: Array, exact: Array, entries: Any = ...) -> float:
        """Return the largest scaled difference of two end states, of all entries or of some."""
        return float(np.max((np.abs(end - exact) / self.scale)[entries]))


def gait_deg(alpha_deg: float, beta_deg: float, omega_rad_s: float) -> Gait:
    """Return a gait of amplitude and phase in degrees."""
    return Gait(math.radians(alpha_deg), math.radians(beta_deg), omega_rad_s)


def paper_robot(links: int = 6, mass_kg: float = 1.0) -> Robot:
    """Return the paper's robot with other links."""
    return Robot(links, mass_kg, 0.12)


PAPER_GROUND = Ground(ct=0.1, cn=10.0)
ROBOT_2005 = Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
GROUND_2005 = Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)


def problems() -> tuple[Problem, ...]:
    """Return every problem, in the order of the figure."""
    three = (paper_robot(3), PAPER_GROUND, gait_deg(30, 90, 3))
    six = (paper_robot(), PAPER_GROUND, gait_deg(30, 80, 5))
    robot = (ROBOT_2005, GROUND_2005, gait_deg(70, 75, 5))
    two_waves = Gait(math.radians(30), 4 * math.pi / 49, 5.0)
    fifty = (paper_robot(50), PAPER_GROUND, two_waves)
    return (
        Problem("paper3", "3 links, exact model", *three, 10.0),
        Problem("paper3_k1e3", "3 links, springs k = 1e3, c = 1", *three, 10.0, 1e3, 1.0),
        Problem("paper6", "6 links, exact model", *six, 10.0),
        Problem("paper6_k1e3", "6 links, springs k = 1e3, c = 1", *six, 10.0, 1e3, 1.0),
        Problem("robot2005", "2005 robot, Bingham friction, exact model", *robot, 5.0),
        Problem("stiff_k1e7_c1", "6 links, stiff: k = 1e7, c = 1", *six, 1.0, 1e7, 1.0),
        Problem("stiff_k1e7_c1e3", "6 links, stiff: k = 1e7, c = 1e3", *six, 1.0, 1e7, 1e3),
        Problem("n50", "50 links, exact model", *fifty, 5.0),
        Problem("n50_k1e5", "50 links, springs k = 1e5, c = 10", *fifty, 1.0, 1e5, 10.0),
    )


FILE = Path(__file__).with_name("references.json")


@dataclass(frozen=True, slots=True)
class Reference:
    """Hold an end state (the peers' vector) and the scaled error that it may itself have."""

    end: Array
    known_to: float


def reference(problem: Problem) -> Reference:
    """Return the end state kept for a problem; raise BadInput if it belongs to another start."""
    kept = read_json(FILE)[problem.name]
    moved = problem.error(problem.first, np.array(kept["first"]))  # springs start rounded
    if moved > 1e-10:
        raise BadInput(
            f"the reference kept for {problem.name} has another start; solve it again with "
            "`studies/references.py`"
        )
    return Reference(np.array(kept["end"]), max(kept["known_to"], moved))
