"""Every term of a scene against the dense models, stepped alike; then limits and symmetries."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from oracle.scenes import NAMES, slow_run
from robots import gait_in_deg

GAIT = gait_in_deg(40, 70, 4.0, 0.1)
VISCOUS, NONE = sn.Ground(0.3, 3.0), sn.Ground(0.0, 0.0)
GROUNDS = {
    "viscous": VISCOUS,
    "none": NONE,
    "coulomb": sn.Ground(0.0, 0.0, 0.05, 0.2),
    "bingham": sn.Ground(0.1, 1.0, 0.05, 0.2),
    "ratchet": sn.Ground((0.1, 0.4), 1.0, (0.05, 0.3), 0.2),
}
SLOW_SERVO = sn.Servo(0.8, 0.01, 0.05, 3.0, 0.02)  # at its limits, in every way, most of the time


SERVOS = {
    "servo": SLOW_SERVO,
    "rotor": replace(SLOW_SERVO, armature_kg_m2=4e-4),
    "held servo": replace(
        SLOW_SERVO,
        armature_kg_m2=4e-4,
        gear_friction_nm=0.01,
        gear_damping_nms_rad=2e-3,
        update_hz=250.0,
        supply_sag=0.2,
    ),
}


def robot_of(links: int, inertia: float | None = 2.5e-4) -> sn.Robot:
    return sn.Robot(links, 0.08, 0.09, inertia)


def anywhere(scene: sn.Scene, seed: int) -> sn.LinkState:
    """Return a random state that has the angles and rates of the imposed joints."""
    rng, n, gait = np.random.default_rng(seed), scene.robot.links, scene.gait
    phase = gait.beta_rad * np.arange(n - 1)
    phi = gait.offset_rad + gait.alpha_rad * np.sin(phase)
    rate = gait.omega_rad_s * gait.alpha_rad * np.cos(phase)
    for i in range(n - 1):
        if i + 1 in scene.locked:
            phi[i], rate[i] = scene.locked[i + 1], 0.0
        elif i + 1 in scene.limp or scene.drive != "angle":
            phi[i], rate[i] = rng.normal(0, 0.5), rng.normal(0, 3.0)
    theta = rng.normal() + np.concatenate([[0.0], np.cumsum(phi)])
    omega = rng.normal() + np.concatenate([[0.0], np.cumsum(rate)])
    state = sn.LinkState.joined(
        scene.robot, [*rng.normal(size=2), *theta], [*rng.normal(size=2), *omega]
    )
    if scene.formulation == "explicit":
        return state
    opened = rng.normal(size=(4, n)) * [[1e-3], [1e-3], [0.05], [0.05]]  # m, m/s
    return replace(
        state,
        x_m=state.x_m + opened[0],
        y_m=state.y_m + opened[1],
        vx_m_s=state.vx_m_s + opened[2],
        vy_m_s=state.vy_m_s + opened[3],
    )


def drive_of(name: str, joints: int) -> dict:
    if name == "table":
        rng = np.random.default_rng(7)
        table = sn.TorqueTable(np.array([0.01, 0.02, 0.05]), 0.02 * rng.normal(size=(3, joints)))
        return {"drive": "torque", "torque": table}
    if name == "function":
        return {"drive": "torque", "torque": lambda t: 0.02 * np.cos(30 * t + np.arange(joints))}
    if name == "constant":
        return {"drive": "torque", "torque": 0.01 * np.arange(1, joints + 1)}
    if name in SERVOS:
        return {"drive": "servo", "servo": SERVOS[name]}
    return {"drive": name}


FAULTS = {
    "sound": {},
    "limp": {"limp": (2, 3)},
    "locked": {"locked": {1: 0.4, 4: -0.2}},
    "both": {"limp": (4, 1), "locked": {2: -0.7}},
    "all": {"limp": (1, 3), "locked": {2: 0.1, 4: 0.2}},
}
FORMULATIONS = "explicit", "implicit"
DRIVES = ("angle", "table", "function", "constant", "servo", "held servo", "rotor")
CASES = [
    (formulation, drive, fault, tuple(GROUNDS)[(i + j) % 5], 0.3 * (j % 2))
    for formulation in FORMULATIONS
    for i, drive in enumerate(DRIVES)
    for j, fault in enumerate(FAULTS)
]  # formulation, drive, fault, ground, slope


def assert_alike(run: sn.Run, truth: dict[str, np.ndarray], rtol: float) -> None:
    """Compare all that a run recorded, on the scale of each quantity."""
    for name, wanted in truth.items():
        found = getattr(run, name)
        assert found.shape == wanted.shape, name
        scale = np.abs(wanted).max() + 1e-3
        assert np.abs(found - wanted).max() <= rtol * scale, name


@pytest.mark.parametrize(("formulation", "drive", "fault", "ground", "slope"), CASES)
def test_scenes_are_those_of_the_dense_models(
    formulation: str, drive: str, fault: str, ground: str, slope: float
) -> None:
    scene = sn.Scene(
        robot_of(5),
        GROUNDS[ground],
        GAIT,
        formulation=formulation,
        **drive_of(drive, 4),
        method="rk4",
        **FAULTS[fault],
        joint_stiffness_n_m=300.0,
        joint_damping_n_s_m=0.4,
        incline_rad=slope,
        incline_direction_rad=2.2,
        dt_s=2e-3,
        duration_s=0.05,
        record=("joints", "friction", "energy"),
    )
    scene = replace(scene, start=anywhere(scene, len(drive + fault)))
    # 25 steps of the same method in the same coordinates: rounding alone, magnified by 1/I, k
    assert_alike(sn.simulate(scene), slow_run(scene, scene.start), 1e-10)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("links", [2, 8])
def test_chains_of_any_length_are_those_of_the_dense_models(
    links: int, ground: str, formulation: str
) -> None:
    scene = sn.Scene(
        robot_of(links),
        GROUNDS[ground],
        replace(GAIT, alpha_rad=math.radians(170)),
        formulation=formulation,
        method="rk4",
        incline_rad=0.3,
        incline_direction_rad=2.0,
        joint_stiffness_n_m=300.0,
        dt_s=1e-3,
        duration_s=0.03,
    )
    scene = replace(scene, start=anywhere(scene, links))
    truth = slow_run(scene, scene.start)
    assert_alike(sn.simulate(scene), {name: truth[name] for name in NAMES[:6]}, 1e-10)


@pytest.mark.parametrize("drive", ["angle", "servo", "held servo", "table"])
def test_the_papers_method_steps_as_it_is_written(drive: str) -> None:
    scene = sn.Scene(
        robot_of(4),
        VISCOUS,
        GAIT,
        formulation="implicit",
        **drive_of(drive, 3),
        joint_stiffness_n_m=300.0,
        joint_damping_n_s_m=0.4,
        method="paper",
        dt_s=1e-3,
        duration_s=0.05,
        incline_rad=0.1,
        record=("joints", "friction", "energy"),
    )
    scene = replace(scene, start=anywhere(scene, 5))
    assert_alike(sn.simulate(scene), slow_run(scene, scene.start), 1e-10)
