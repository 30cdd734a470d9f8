"""A robot as MJCF moves in MuJoCo as it does here, without friction and with viscous friction."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
import serpenoid as sn
from refusals import refused

ROBOT = sn.Robot(4, 0.3, 0.1)
TORQUE = [0.004, -0.003, 0.002]
STILL = sn.Gait(0.0, 0.0, 1.0)


def in_mujoco(ground: sn.Ground, start: sn.LinkState, duration_s: float) -> np.ndarray:
    """Return x, y, theta of every link at the end, (3, n)."""
    model = mujoco.MjModel.from_xml_string(sn.to_mjcf(ROBOT, ground, timestep_s=5e-4))
    data = mujoco.MjData(model)
    turn = np.diff(start.theta_rad, prepend=0.0)
    data.qpos[:] = [start.x_m[0], start.y_m[0], *turn]
    data.qvel[:] = [start.vx_m_s[0], start.vy_m_s[0], *np.diff(start.omega_rad_s, prepend=0.0)]
    for joint, torque in enumerate(TORQUE, 1):
        data.actuator(f"torque{joint}").ctrl[0] = torque
    for _ in range(round(duration_s / 5e-4)):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    places = np.array([data.body(f"link{i}").xpos[:2] for i in range(1, 5)]).T
    return np.vstack([places, np.cumsum(data.qpos[2:])])


def here(ground: sn.Ground, start: sn.LinkState, duration_s: float) -> np.ndarray:
    run = sn.simulate(
        sn.Scene(
            ROBOT,
            ground,
            STILL,
            drive="torque",
            torque=TORQUE,
            start=start,
            method="dop853",
            tolerance=1e-10,
            duration_s=duration_s,
            dt_s=0.01,
        )
    )
    return np.array([run.x_m[-1], run.y_m[-1], run.theta_rad[-1]])


GROUNDS = {"none": sn.Ground(0, 0), "viscous": sn.Ground(0.02, 1.5)}


@pytest.mark.parametrize("ground", GROUNDS.values(), ids=GROUNDS)
def test_the_same_motion(ground) -> None:
    start = sn.LinkState.joined(
        ROBOT, [0.1, -0.2, 0.3, 0.7, 0.1, -0.4], [0.1, 0.05, 0.5, -1.0, 0.3, 2.0]
    )
    ours, theirs = here(ground, start, 1.0), in_mujoco(ground, start, 1.0)
    assert theirs == pytest.approx(ours, abs=2e-6)
    assert np.abs(ours[2] - start.theta_rad).max() > 0.3  # it did move


def test_dry_friction_is_left_out_with_a_warning() -> None:
    with pytest.warns(UserWarning, match="fn0 0.2 N are left out"):
        text = sn.to_mjcf(ROBOT, sn.Ground(0.1, 1.0, 0.1, 0.2))
    assert text == sn.to_mjcf(ROBOT, sn.Ground(0.1, 1.0))


def test_refusals() -> None:
    with refused("robot is a Ground"):
        sn.to_mjcf(sn.Ground(0.1, 1.0), ROBOT)
    with refused("timestep_s is 0"):
        sn.to_mjcf(ROBOT, sn.Ground(0.1, 1.0), timestep_s=0)
