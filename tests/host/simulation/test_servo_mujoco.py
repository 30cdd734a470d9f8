"""Servos by another code: MuJoCo's rotors, joint damping, position actuators; viscous ground."""

from __future__ import annotations

import math
from xml.etree import ElementTree as ET

import numpy as np
import pytest
import serpenoid as sn
from serpenoid import _core

mujoco = pytest.importorskip("mujoco")
ROBOT, GROUND = sn.Robot(6, 0.0756, 0.076), sn.Ground(0.1, 1.0)
GAIT = sn.Gait(math.radians(50), math.radians(70), math.tau * 0.8)
SERVO = sn.Servo(2.0, 0.04, 1e6, 1e6, 0.0, armature_kg_m2=4e-3, gear_damping_nms_rad=5e-3)
STEP_S, FRAME_S = 2e-4, 0.02


def mujoco_model(servo: sn.Servo) -> mujoco.MjModel:
    """Return the robot with MuJoCo's own servos: position actuators with damping, and rotors."""
    root = ET.fromstring(sn.to_mjcf(ROBOT, GROUND, timestep_s=STEP_S))
    for joint in root.iter("joint"):
        if joint.get("type") == "hinge" and joint.get("name", "").startswith("joint"):
            joint.set("armature", repr(servo.armature_kg_m2))
            joint.set("damping", repr(servo.gear_damping_nms_rad))
    actuators = root.find("actuator")
    assert actuators is not None
    for motor in actuators.findall("motor"):
        actuators.remove(motor)
    for i in range(1, ROBOT.links):
        ET.SubElement(
            actuators,
            "position",
            name=f"servo{i}",
            joint=f"joint{i}",
            kp=repr(servo.stiffness_nm_rad),
            kv=repr(servo.damping_nms_rad),
        )
    return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))


def centres_by_mujoco(servo: sn.Servo, start: sn.LinkState, frames: int) -> np.ndarray:
    """Return where the centre of mass is at each frame, (frames + 1, 2), m."""
    model = mujoco_model(servo)
    data = mujoco.MjData(model)
    data.qpos[:3] = start.x_m[0], start.y_m[0], start.theta_rad[0]
    data.qvel[:3] = start.vx_m_s[0], start.vy_m_s[0], start.omega_rad_s[0]
    data.qpos[3:], data.qvel[3:] = np.diff(start.theta_rad), np.diff(start.omega_rad_s)
    servos = [model.actuator(f"servo{i}").id for i in range(1, ROBOT.links)]
    setpoints = _core.firmware.gait_setpoints_rad(
        GAIT.alpha_rad, GAIT.beta_rad, GAIT.omega_rad_s, frames=frames, joints=ROBOT.links - 1
    )
    found = []
    for angles in setpoints:
        data.ctrl[servos] = angles
        mujoco.mj_kinematics(model, data)
        found.append(data.xipos[1:, :2].mean(axis=0))
        for _ in range(round(FRAME_S / STEP_S)):
            mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    return np.array([*found, data.xipos[1:, :2].mean(axis=0)])


@pytest.mark.parametrize("formulation", ["explicit", "implicit"])
def test_a_robot_with_rotors_goes_where_mujoco_takes_it(formulation: str) -> None:
    scene = sn.Scene(
        ROBOT,
        GROUND,
        GAIT,
        drive="servo",
        servo=SERVO,
        start="link1_at_rest",
        dt_s=2e-4,
        record_every=100,
        duration_s=2.0,
        formulation=formulation,
        joint_stiffness_n_m=2e4,
        joint_damping_n_s_m=20.0,
    )
    run = sn.simulate(scene)
    start = sn.LinkState(
        run.x_m[0], run.y_m[0], run.theta_rad[0], run.vx_m_s[0], run.vy_m_s[0], run.omega_rad_s[0]
    )
    ours = np.stack([run.x_m.mean(1), run.y_m.mean(1)], axis=1)
    theirs = centres_by_mujoco(SERVO, start, 100)
    travelled = np.ptp(ours, axis=0).max()
    # 200 us of either code's RK4; joints of springs give way by some micrometres
    allowed = 1e-6 if formulation == "explicit" else 2e-3
    assert np.abs(ours - theirs).max() < allowed * travelled
    no_rotor = centres_by_mujoco(sn.Servo(2.0, 0.04, 1e6, 1e6, 0.0), start, 100)
    assert np.abs(no_rotor - theirs).max() > 5e-3 * travelled  # or the test could not fail


def test_the_speed_with_servos_is_that_of_a_long_run_by_mujoco() -> None:
    found = sn.steady_gait(ROBOT, GROUND, GAIT, servo=SERVO)
    start = sn.LinkState.in_gait(ROBOT, GAIT, 0.0, [0.0] * 3, [0.0] * 3)
    cycle = 1.25  # s; 62.5 frames: two cycles are 125
    centres = centres_by_mujoco(SERVO, start, 7 * 125)
    way = np.linalg.norm(centres[-1] - centres[-1 - 2 * 125])
    assert way / (4 * cycle) == pytest.approx(found.speed_m_s, rel=2e-3)
    assert abs(found.speed_m_s / found.ideal.speed_m_s - 1) > 0.006
