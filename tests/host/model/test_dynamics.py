"""Single evaluations of the compiled models: the dense reference, and their energy balance."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
from oracle import dense
from oracle.params import Params
from refusals import refused
from robots import VISCOUS

K_N_M, C_N_S_M = 730.0, 2.3
THEIRS = {"torque_nm": "torque", "joint_acceleration_rad_s2": "phi_ddot"}  # the reference's names


def random_case(n: int, seed: int) -> tuple[Params, sn.Robot, sn.Ground, np.random.Generator]:
    """Draw a robot on dry ground, once for the reference and once for us."""
    rng = np.random.default_rng([seed, n])
    m, half, inertia = rng.uniform(0.05, 2.0, 3)
    ct, cn, ft0, fn0 = rng.uniform(0.0, 5.0, 4)
    p = Params(n, m, half, inertia, ct, cn, ft0, fn0)
    return p, sn.Robot(n, m, 2 * half, inertia), sn.Ground(ct, cn, ft0, fn0), rng


def random_state(robot: sn.Robot, rng: np.random.Generator, formulation: str) -> sn.LinkState:
    """Draw a state; the joints are open in the implicit formulation."""
    n = robot.links
    if formulation == "explicit":
        return sn.LinkState.joined(robot, rng.normal(size=n + 2), rng.normal(size=n + 2))
    return sn.LinkState(*rng.normal(size=(6, n)))


@pytest.mark.parametrize("formulation", ["explicit", "implicit"])
@pytest.mark.parametrize("drive", THEIRS)
@pytest.mark.parametrize("n", [2, 3, 4, 12, 50])
def test_an_evaluation_is_the_dense_solution(n: int, drive: str, formulation: str) -> None:
    p, robot, ground, rng = random_case(n, len(drive + formulation))
    springs = {"joint_stiffness_n_m": K_N_M, "joint_damping_n_s_m": C_N_S_M}
    spring = dense.Spring(K_N_M, C_N_S_M) if formulation == "implicit" else None
    state = random_state(robot, rng, formulation)
    pose = np.column_stack([state.x_m, state.y_m, state.theta_rad])
    rates = np.column_stack([state.vx_m_s, state.vy_m_s, state.omega_rad_s])
    imposed = rng.normal(size=n - 1)
    truth = dense.evaluate(p, pose, rates, spring=spring, **{THEIRS[drive]: imposed})
    a = sn.acceleration(
        robot,
        ground,
        state,
        **{drive: imposed},
        formulation=formulation,
        **(springs if spring else {}),
    )
    # the dense saddle-point system loses some digits with n; ours is the better one
    for ours, theirs in (
        (a.alpha_rad_s2, truth.theta_ddot),
        (a.ax_m_s2, truth.accel_m_s2[:, 0]),
        (a.joint_torque_nm, truth.torque_n_m),
        (a.joint_force_x_n, truth.force_n[:, 0]),
        (a.joint_force_y_n, truth.force_n[:, 1]),
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * (1 + abs(theirs).max()))


def test_a_thousand_links_close_the_chain() -> None:
    """With n = 1000 the recovered torque behind the head vanishes: the torques close the loop."""
    robot, ground = sn.Robot(1000, 0.01, 0.02), sn.Ground(0.1, 3.0, 0.01, 0.02)
    rng = np.random.default_rng(4)
    q = np.concatenate([[0, 0], 0.3 * np.sin(np.arange(1000) / 7)])
    qdot = rng.normal(size=1002)
    bend = rng.normal(size=999)
    imposed = sn.acceleration(robot, ground, (q, qdot), joint_acceleration_rad_s2=bend)
    back = sn.acceleration(robot, ground, (q, qdot), torque_nm=imposed.joint_torque_nm)
    # torques are sums over n links: n roundings of the largest, turned into acceleration by 1/I
    rounding = 1e-16 * 1000 * abs(imposed.joint_torque_nm).max() / robot.link_inertia_kg_m2
    np.testing.assert_allclose(np.diff(back.alpha_rad_s2), bend, rtol=0, atol=3 * rounding)
    assert rounding < 1e-4


def test_bad_input_is_named() -> None:
    still = ([0.0] * 5, [0.0] * 5)
    for change, said in (
        ({"state": ([0, 0, 0, 0, np.nan], [0] * 5)}, r"q\[4\] is nan"),
        ({"torque_nm": [1.0]}, r"torque_nm has shape \(1,\); it must be 2 numbers"),
        ({"torque_nm": None}, "0 of torque_nm and joint_acceleration_rad_s2 are given"),
        ({"formulation": "exact"}, "formulation is 'exact'; it must be one of explicit, implicit"),
    ):
        with refused(said):
            given = {"state": still, "torque_nm": [0.0, 0.0]} | change
            sn.acceleration(sn.Robot(3, 1.0, 0.12), VISCOUS, **given)
