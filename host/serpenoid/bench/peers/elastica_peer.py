"""PyElastica on a periodic gait: what of the robot a Cosserat rod can say, and how.

Its continuum snake is an elastic rod with muscle torques whose gait is improved by re-simulating it
(CMA-ES). The same here, as far as it can state the robot: as many elements as links, each nearly
unstretchable; imposed joint angles as intrinsic curvature between elements, held by a stiff bend;
viscous friction along and across each element, at its middle. A rod's mass sits at its nodes, so
that a link's inertia is m L^2 / 4 plus the section's own, which the exact model then takes, too.
Not stated: pinned joints (the bend gives way), a link's true inertia, wheels that stick (its own
friction plane smooths sgn over a slip speed), powers of the joints.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

import elastica as ea  # pyright: ignore[reportMissingImports] (an optional extra)
import numpy as np
from elastica.rod.cosserat_rod import (  # pyright: ignore[reportMissingImports]
    CosseratRod,
)
from elastica.timestepper.symplectic_steppers import (  # pyright: ignore[reportMissingImports]
    PositionVerlet,
)

from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ..contender import check_smooth
from .rod_robot import RADIUS_OF_LENGTH

STIFFNESS_NM = 50.0  # of a joint's bend, N m/rad


class _Snake(ea.BaseSystemCollection, ea.Forcing):  # pyright: ignore
    pass


@dataclass(frozen=True, slots=True)
class RodGait:
    """Hold what following one gait gave.

    speed_m_s: of the last cycle; change: of it by that cycle, relative; seconds: of processor time;
    bend_error_rad: how far the joints were off the gait at the end.
    """

    speed_m_s: float
    change: float
    cycles: int
    seconds: float
    bend_error_rad: float


def _rod(robot: Robot, ground: Ground, gait: Gait) -> tuple[Any, Any]:
    length, n = robot.link_length_m, robot.links
    radius = RADIUS_OF_LENGTH * length
    modulus = STIFFNESS_NM * length / (math.pi * radius**4 / 4)
    rod = CosseratRod.straight_rod(
        n, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), n * length, radius,
        robot.link_mass_kg / (math.pi * radius**2 * length), youngs_modulus=modulus,
        shear_modulus=modulus / 3,
    )  # fmt: skip
    lag = gait.beta_rad * np.arange(n - 1)

    class Wheels(ea.NoForces):  # pyright: ignore
        def apply_forces(self, system: Any, time: Any = 0.0) -> None:
            along = system.tangents
            v = (system.velocity_collection[:, 1:] + system.velocity_collection[:, :-1]) / 2
            rolling = (v * along).sum(axis=0) * along
            force = -(ground.ct_forward * rolling + ground.cn * (v - rolling))
            system.external_forces[:, :-1] += force / 2
            system.external_forces[:, 1:] += force / 2

    class Servos(ea.NoForces):  # pyright: ignore
        def apply_forces(self, system: Any, time: Any = 0.0) -> None:
            begun = min(float(time) * gait.omega_rad_s / math.pi, 1.0)  # the first half cycle
            angle = gait.alpha_rad * np.sin(gait.omega_rad_s * float(time) + lag)
            size = begun**2 * (3 - 2 * begun)
            system.rest_kappa[0] = size * angle / system.rest_voronoi_lengths

    snake = _Snake()
    snake.append(rod)
    snake.add_forcing_to(rod).using(Wheels)
    snake.add_forcing_to(rod).using(Servos)
    snake.finalize()
    return snake, rod


def follow(
    robot: Robot, ground: Ground, gait: Gait, dt_s: float, settled: float, most_cycles: int = 40
) -> RodGait:
    """Follow a gait from rest until a cycle's speed is the last one's to `settled`, relative.

    Seconds of processor time leave out one step that compiles. Raises BadInput.
    """
    check_smooth("PyElastica", ground)
    snake, rod = _rod(robot, ground, gait)
    steps = math.ceil(gait.period_s / dt_s)
    dt_s, stepper, now = gait.period_s / steps, PositionVerlet(), 0.0
    stepper.step(_rod(robot, ground, gait)[0], 0.0, dt_s)
    start, speed, before, cycle = time.process_time(), 0.0, math.inf, 0
    while cycle < most_cycles and not (cycle > 2 and abs(speed / before - 1) < settled):
        first, before = _centre(rod), speed or math.inf
        for _ in range(steps):
            now = stepper.step(snake, now, dt_s)
        speed = float(np.hypot(*(_centre(rod) - first)[:2])) / gait.period_s
        cycle += 1
    spent = time.process_time() - start
    heading = np.unwrap(np.arctan2(rod.tangents[1], rod.tangents[0]))
    meant = gait.alpha_rad * np.sin(
        gait.omega_rad_s * now + gait.beta_rad * np.arange(robot.links - 1)
    )
    off = float(np.abs(np.diff(heading) - meant).max())
    return RodGait(speed, abs(speed / before - 1), cycle, spent, off)


def _centre(rod: Any) -> Any:
    return (rod.position_collection * rod.mass).sum(axis=1) / rod.mass.sum()
