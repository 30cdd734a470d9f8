"""The study of 2005 remade: its robots, runs, sweep and optima."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.vectors import Array
from ..gaits.least_power import LeastPower, power_front
from ..model.drives import TorqueTable
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, steady_gait
from ..periodic.sweep import Sweep, sweep
from ..simulation.run import Run
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

D = math.pi / 180
ROBOT, GROUND = Robot(6, 1.0, 0.12), Ground(0.1, 10.0)
THREE = Robot(3, 1.0, 0.12)
THREE_GAIT = Gait(30 * D, 90 * D, 3.0)
# How both formulations are compared: RK4, 1 ms.
BESIDE = Scene(THREE, GROUND, THREE_GAIT, method="rk4", dt_s=1e-3, duration_s=10.0, record_every=1)
OF_2005, BINGHAM = Robot(6, 0.0756, 0.076), Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
PATH_GAIT, EXPERIMENT = Gait(30 * D, 80 * D, 5.0), Gait(70 * D, 75 * D, math.pi)
PAPERS_OPTIMUM = (30 * D, 80 * D)
FRONT_M_S = (0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7)
FRONT_2005_M_S = (0.03, 0.05, 0.1, 0.15, 0.2)
GRID_ALPHA, GRID_BETA = (5 * D, 75 * D), (20 * D, 90 * D)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Hold the error of the implicit against the exact model in time, tail link of three.

    t_s (T,), theta_error_rad (T,), velocity_error_m_s (T, 2). gap: how the joints start, "zero"
    (closed, so that their springs ring; the paper's) or "slow_manifold" (open by their load).
    """

    gap: str

    t_s: Array
    theta_error_rad: Array
    velocity_error_m_s: Array


def compare_formulations(gap: str = "zero") -> Comparison:
    """Run both formulations side by side (Figs. 6 and 7): RK4, 1 ms, link 1 at rest at first."""
    scene = replace(BESIDE, start="link1_at_rest", gap=gap)
    exact, soft = simulate(scene), simulate(replace(scene, formulation="implicit"))
    error = np.stack([soft.vx_m_s - exact.vx_m_s, soft.vy_m_s - exact.vy_m_s], axis=2)[:, 0]
    return Comparison(gap, exact.t_s, (soft.theta_rad - exact.theta_rad)[:, 0], error)


def compare_torque_driven() -> float:
    """Return the largest error of the tail's angle when both are driven by one list of torques."""
    scene = replace(BESIDE, record=("joints",))
    run = simulate(scene)
    table = TorqueTable(run.t_s, run.joint_torque_nm)
    driven = replace(scene, drive="torque", torque=table, record=(), start=run.state(0))
    exact, soft = simulate(driven), simulate(replace(driven, formulation="implicit"))
    return float(np.abs(soft.theta_rad - exact.theta_rad).max())


def papers_sweep() -> Sweep:
    """Solve the paper's 4500 gaits."""
    return sweep(
        ROBOT,
        GROUND,
        alpha_rad=np.arange(5, 76, 5) * D,
        beta_rad=np.arange(20, 91, 5) * D,
        omega_rad_s=np.arange(1.0, 21.0),
        powers=False,
    )


def papers_front() -> list[LeastPower]:
    """Find the least-power gaits of the paper's robot over its speeds."""
    front = power_front(ROBOT, GROUND, speeds_m_s=np.array(FRONT_M_S))
    return [best for best in front if best is not None]


def cloud_2005() -> Sweep:
    """Solve a grid of gaits of the 2005 robot on its measured, dry ground."""
    return sweep(
        OF_2005,
        BINGHAM,
        alpha_rad=np.arange(30, 106, 5) * D,
        beta_rad=np.arange(40, 111, 5) * D,
        omega_rad_s=np.geomspace(0.7, 12, 12),
        rtol=1e-3,
        powers=False,
    )


def path_run(gait: Gait, cycles: int) -> Run:
    """Return a run of the periodic state (Figs. 12 and 13)."""
    return simulate(
        Scene(
            ROBOT,
            GROUND,
            gait,
            start="steady",
            method="rk4",
            dt_s=gait.period_s / 600,
            record_every=5,
            duration_s=cycles * gait.period_s,
        )
    )


def dearer(front: Sequence[LeastPower], speed_m_s: float) -> float:
    """Return by what fraction the paper's (30, 80) deg costs more than the optimum at a speed."""
    from scipy.optimize import brentq

    best = min(front, key=lambda b: abs(b.speed_m_s - speed_m_s))

    def papers(rate: float) -> Steady:
        return steady_gait(ROBOT, GROUND, Gait(*PAPERS_OPTIMUM, rate))

    around = 0.2 * best.gait.omega_rad_s, 5 * best.gait.omega_rad_s
    rate: Any = brentq(lambda rate: papers(rate).speed_m_s - best.speed_m_s, *around)
    return papers(rate).power_w / best.power_w - 1


def finer_step(dt_s: float = 2.5e-4) -> float:
    """Return by what part of the largest value a shorter step than 1 ms changes places and speeds.

    Of the paper's three links, by both formulations.
    """
    worst = 0.0
    for formulation in ("explicit", "implicit"):
        scene = replace(BESIDE, formulation=formulation, record_every=10, start="link1_at_rest")
        run = simulate(scene)
        fine = simulate(replace(scene, dt_s=dt_s, record_every=round(1e-2 / dt_s)))
        for x, y in (("x_m", "y_m"), ("vx_m_s", "vy_m_s")):
            full = np.hypot(getattr(run, x), getattr(run, y)).max()
            gap = [getattr(run, name) - getattr(fine, name) for name in (x, y)]
            worst = max(worst, float(np.hypot(*gap).max() / full))
    return worst


def without_dry_friction_along() -> list[tuple[float, float, float]]:
    """Return frequency in Hz, and by what part speed and power change without ft0 (2005 robot)."""
    changes = []
    for frequency in (0.2, 0.5, 1.0, 1.5, 2.0):
        gait = replace(EXPERIMENT, omega_rad_s=2 * math.pi * frequency)
        full, free = (
            steady_gait(OF_2005, ground, gait, rtol=1e-4)
            for ground in (BINGHAM, replace(BINGHAM, ft0=0.0))
        )
        changes.append(
            (frequency, free.speed_m_s / full.speed_m_s - 1, free.power_w / full.power_w - 1)
        )
    return changes
