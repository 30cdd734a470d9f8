"""Compare a gait's speed with PyElastica, which follows an elastic rod until its motion repeats.

A rod states the paper's robot only in part. It has one element for each link, nearly
unstretchable. Joint angles are imposed as intrinsic curvature, held by a stiff bend. Friction is
viscous along and across each element, at its middle. A rod's mass sits at its nodes, so the
inertia of a link is m L^2 / 4 plus that of its section; the exact model is given the same inertia.
Not stated: pinned joints (the bend gives way), a link's own inertia, wheels that stick, powers.

    python studies/rod.py            three gaits; needs PyElastica (`pip install pyelastica`)
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import serpenoid as sn

ROBOT, GROUND = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
GAITS = {"paper": (30.0, 80.0, 5.0), "slow": (32.0, 84.0, 1.8), "fast": (25.0, 86.0, 10.0)}
STEP_S, SETTLED, MOST_CYCLES = 2e-4, 3e-3, 40
RADIUS_OF_LENGTH = 1 / 6  # radius of the rod's section over the length of a link
STIFFNESS_NM = 50.0  # of a joint's bend, N m/rad


@dataclass(frozen=True, slots=True)
class RodGait:
    """Hold one gait followed by a rod.

    speed_m_s: of the last cycle; change: of that speed by the last cycle, relative; seconds: of
    processor time; bend_error_rad: largest difference of a joint from the gait at the end.
    """

    speed_m_s: float
    change: float
    cycles: int
    seconds: float
    bend_error_rad: float


def as_rod_sees_it(robot: sn.Robot) -> sn.Robot:
    """Return the robot with the link inertia that masses at the rod's nodes give."""
    m, length = robot.link_mass_kg, robot.link_length_m
    section = m * (RADIUS_OF_LENGTH * length) ** 2 / 4
    return replace(robot, link_inertia_kg_m2=m * length**2 / 4 + section)


def _rod(robot: sn.Robot, ground: sn.Ground, gait: sn.Gait) -> tuple[Any, Any]:
    """Return PyElastica's system and its rod."""
    import elastica as ea

    length, n = robot.link_length_m, robot.links
    radius = RADIUS_OF_LENGTH * length
    modulus = STIFFNESS_NM * length / (math.pi * radius**4 / 4)
    density = robot.link_mass_kg / (math.pi * radius**2 * length)
    rod = ea.CosseratRod.straight_rod(
        n,
        np.zeros(3),
        np.array([1.0, 0, 0]),
        np.array([0, 0, 1.0]),
        n * length,
        radius,
        density,
        youngs_modulus=modulus,
        shear_modulus=modulus / 3,
    )
    lag = gait.beta_rad * np.arange(n - 1)

    class Wheels(ea.NoForces):
        def apply_forces(self, system: Any, time: Any = 0.0) -> None:
            along = system.tangents
            v = (system.velocity_collection[:, 1:] + system.velocity_collection[:, :-1]) / 2
            rolling = (v * along).sum(axis=0) * along
            force = -(ground.ct_forward * rolling + ground.cn * (v - rolling))
            system.external_forces[:, :-1] += force / 2
            system.external_forces[:, 1:] += force / 2

    class Servos(ea.NoForces):
        def apply_forces(self, system: Any, time: Any = 0.0) -> None:
            begun = min(float(time) * gait.omega_rad_s / math.pi, 1.0)  # the first half cycle
            angle = gait.alpha_rad * np.sin(gait.omega_rad_s * float(time) + lag)
            size = begun**2 * (3 - 2 * begun)
            system.rest_kappa[0] = size * angle / system.rest_voronoi_lengths

    class Snake(ea.BaseSystemCollection, ea.Forcing):
        pass

    snake = Snake()
    snake.append(rod)
    snake.add_forcing_to(rod).using(Wheels)
    snake.add_forcing_to(rod).using(Servos)
    snake.finalize()
    return snake, rod


def follow(robot: sn.Robot, ground: sn.Ground, gait: sn.Gait, settled: float = SETTLED) -> RodGait:
    """Follow a gait from rest until the speed of two cycles agrees to `settled`, relative.

    One step before the clock starts compiles PyElastica. Viscous ground with one ct only.
    """
    import elastica as ea

    snake, rod = _rod(robot, ground, gait)
    steps = math.ceil(gait.period_s / STEP_S)
    dt_s, stepper, now = gait.period_s / steps, ea.PositionVerlet(), 0.0
    stepper.step(_rod(robot, ground, gait)[0], 0.0, dt_s)
    start, speed, before, cycle = time.process_time(), 0.0, math.inf, 0
    while cycle < MOST_CYCLES and not (cycle > 2 and abs(speed / before - 1) < settled):
        first, before = _centre(rod), speed or math.inf
        for _ in range(steps):
            now = stepper.step(snake, now, dt_s)
        speed = float(np.hypot(*(_centre(rod) - first)[:2])) / gait.period_s
        cycle += 1
    spent = time.process_time() - start
    heading = np.unwrap(np.arctan2(rod.tangents[1], rod.tangents[0]))
    phase = gait.omega_rad_s * now + gait.beta_rad * np.arange(robot.links - 1)
    bend_error = float(np.abs(np.diff(heading) - gait.alpha_rad * np.sin(phase)).max())
    return RodGait(speed, abs(speed / before - 1), cycle, spent, bend_error)


def _centre(rod: Any) -> Any:
    return (rod.position_collection * rod.mass).sum(axis=1) / rod.mass.sum()


def main() -> None:
    """Print both speeds and processor times of each gait."""
    seen = as_rod_sees_it(ROBOT)
    for name, (alpha_deg, beta_deg, omega_rad_s) in GAITS.items():
        gait = sn.Gait(math.radians(alpha_deg), math.radians(beta_deg), omega_rad_s)
        rod = follow(ROBOT, GROUND, gait)
        start = time.process_time()
        for _ in range(100):
            exact_m_s = sn.steady_gait(seen, GROUND, gait, powers=False).speed_m_s
        exact_s = (time.process_time() - start) / 100
        print(
            f"{name}: PyElastica {rod.speed_m_s:.5f} m/s in {rod.seconds:.3g} s ({rod.cycles} "
            f"cycles), exact model {exact_m_s:.5f} m/s in {1e6 * exact_s:.3g} us: "
            f"{100 * (rod.speed_m_s / exact_m_s - 1):+.1f} %"
        )


if __name__ == "__main__":
    main()
