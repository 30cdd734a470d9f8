"""Scenes for the references of tests/oracle: hard springs, free joints on dry ground."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import serpenoid as sn
from numpy.random import Generator
from oracle.scenes import SlowScene
from robots import BINGHAM, OF_2005, VISCOUS, gait_in_deg
from scipy.integrate import solve_ivp

Array = np.ndarray
# Name of a scene -> what an event-driven solver told of it.
DRY_RUNS = json.loads((Path(__file__).parents[2] / "oracle" / "dry_runs.json").read_text())
PAPER_GAIT = gait_in_deg(30, 80, 5.0)


def hard_scene(links: int, k: float, incline_rad: float = 0.0, **more: Any) -> sn.Scene:
    """Return a second of the paper's robot on springs of k N/m with dampers of 1 N s/m."""
    fields = {"duration_s": 1.0, "dt_s": 1e-3, "ground": VISCOUS, **more}
    return sn.Scene(
        sn.Robot(links, 1.0, 0.12),
        gait=PAPER_GAIT,
        formulation="implicit",
        joint_stiffness_n_m=k,
        incline_rad=incline_rad,
        **fields,
    )


def end_of(scene: sn.Scene, start: sn.LinkState, rtol: float = 1e-8, solver: str = "Radau"):
    """Return the links' (x, y, theta) and their rates, each (n, 3), at a smooth scene's end.

    SciPy solves the dense equations of oracle/dense.py, whose states on springs are the gaps.
    """
    slow, none = SlowScene(scene), np.zeros(4)  # without the four integrals of work

    def rate(t: float, y: Array) -> Array:
        return slow.rate(t, np.append(y, none))[:-4]

    span, first = (0.0, scene.duration_s), slow.pack(start)[:-4]
    out = solve_ivp(rate, span, first, solver, rtol=rtol, atol=rtol / 100)
    assert out.success, out.message
    return slow.links(scene.duration_s, np.append(out.y[:, -1], none))[:2]


def places(run: sn.Run) -> Array:
    """Return (x, y, theta) of all links at the recorded times, (T, n, 3)."""
    return np.stack([run.x_m, run.y_m, run.theta_rad], axis=2)


def off(found: Array, truth: Array, robot: sn.Robot) -> float:
    """Return the largest error in body lengths and radians of places (..., n, 3)."""
    gap = found - truth
    centre = np.hypot(gap[..., 0], gap[..., 1]).max() / robot.body_length_m
    return float(max(centre, abs(gap[..., 2]).max()))


def far_scene(cycles: int, offset_rad: float = 0.0, **more: Any) -> sn.Scene:
    """Return many cycles of 2 s of the 2005 robot on dry ground."""
    gait = gait_in_deg(70, 75, math.pi, offset_rad)
    return sn.Scene(OF_2005, BINGHAM, gait, method="nonsmooth", duration_s=2.0 * cycles, **more)


def free_case(kind: str, seed: int, duration_s: float = 0.6) -> sn.Scene:
    """Return a random robot of two to four links on dry ground, its joints driven by `kind`.

    "torque": constant torques; "table": torques in time; "servo": springs and dampers within
    limits; "full": with rotor, gear, held duty and a supply that sags. Two links start bent: a
    straight pair is a singular pose, in which four resting wheels do not hold the joint.
    """
    rng = np.random.default_rng([seed, ("torque", "table", "servo", "full").index(kind)])
    n = int(rng.integers(2, 5))
    robot = sn.Robot(n, 10 ** rng.uniform(-1.4, -0.3), rng.uniform(0.05, 0.12))
    weight = 9.81 * robot.link_mass_kg
    ct, cn = 10 ** rng.uniform(-3, -1), 10 ** rng.uniform(-2, 0)
    ft0, fn0 = weight * 10 ** rng.uniform(-3, -1.3), weight * 10 ** rng.uniform(-1.3, -0.2)
    ground = sn.Ground(ct, cn, ft0, fn0)
    if rng.random() < 0.3:
        back = 10 ** rng.uniform(0.1, 1.0)
        ground = sn.Ground((ct, back * ct), cn, (ft0, back * ft0), fn0)
    bent = 0.3 if n == 2 else 0.0
    gait = sn.Gait(rng.uniform(0.1, 1.2), rng.uniform(0.3, 1.8), rng.uniform(1, 6), bent)
    incline = {
        "incline_rad": float(rng.choice([0, 0, 0.05])),
        "incline_direction_rad": float(rng.uniform(-3, 3)),
    }
    drive = _drive(kind, robot, fn0 * robot.link_length_m * n / 2, rng)
    return sn.Scene(
        robot,
        ground,
        gait,
        method="nonsmooth",
        duration_s=duration_s,
        dt_s=0.01,
        **incline,
        **drive,
    )


def _drive(kind: str, robot: sn.Robot, size_nm: float, rng: Generator) -> dict[str, Any]:
    joints = robot.links - 1
    if kind == "torque":
        torque = rng.normal(size=joints) * size_nm * 10 ** rng.uniform(-1, 0)
        return {"drive": "torque", "torque": torque}
    if kind == "table":
        t_s = np.sort(rng.uniform(0, 0.6, 4))
        rows = rng.normal(size=(4, joints)) * size_nm * 10 ** rng.uniform(-1, 0.3)
        return {"drive": "torque", "torque": sn.TorqueTable(t_s, rows)}
    stiff = robot.inertia_kg_m2 * 10 ** rng.uniform(2, 4)
    limit = stiff * rng.uniform(0.05, 1)
    more = _gear(robot, limit, rng) if kind == "full" else {}
    servo = sn.Servo(stiff, stiff * rng.uniform(0.01, 0.1), limit, **more)
    return {"drive": "servo", "servo": servo}


def _gear(robot: sn.Robot, limit_nm: float, rng: Generator) -> dict[str, float]:
    def or_none(value: float, share: float) -> float:
        return value if rng.random() < share else 0.0

    return {
        "armature_kg_m2": or_none(robot.inertia_kg_m2 * 10 ** rng.uniform(-2, 0), 0.7),
        "gear_friction_nm": or_none(limit_nm * rng.uniform(0, 0.1), 0.6),
        "gear_damping_nms_rad": or_none(0.01 * limit_nm, 0.5),
        "update_hz": float(rng.choice([0, 50, 200])),
        "supply_sag": float(rng.choice([0, 0.05])),
        "dead_band_rad": float(rng.choice([0, 0.01, 0.03])),
    }


def slips(run: sn.Run, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return a vector of every link along and across it, (T, n, 2)."""
    c, s = np.cos(run.theta_rad), np.sin(run.theta_rad)
    return np.stack([c * x + s * y, -s * x + c * y], axis=2)
