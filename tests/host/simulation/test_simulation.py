"""Runs in time: order, published trajectory, limits of the springs, conservation, refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import OF_2005, PAPER, VISCOUS, gait_in_deg

THREE = sn.Robot(3, 1.0, 0.12)
THREE_GAIT = gait_in_deg(30, 90, 3.0)
PAPERS_GAIT = gait_in_deg(30, 80, 5.0)


def test_three_links_at_ten_seconds() -> None:
    run = sn.simulate(
        sn.Scene(
            THREE, VISCOUS, THREE_GAIT, duration_s=10.0, record_every=10_000, start="link1_at_rest"
        )
    )
    end = run.state()
    found = [end.x_m[0], end.y_m[0], end.theta_rad[0], end.vx_m_s[0], end.vy_m_s[0]]
    printed = [0.6944674004, 0.2002216975, 0.6090597074, 0.0621623417, 0.0625789382]
    assert found == pytest.approx(printed, abs=1e-10)
    assert end.omega_rad_s[0] == pytest.approx(-0.7831627707, abs=1e-10)


@pytest.mark.parametrize("method", ["rk4", "nonsmooth"])
def test_a_run_ends_when_it_should(method: str) -> None:
    """3 ms do not divide 0.1 s: the last step is shorter, and the end is that of a fine run."""
    ground = VISCOUS if method == "rk4" else sn.Ground(0.1, 10.0, 0.01, 0.02)
    scene = sn.Scene(THREE, ground, THREE_GAIT, method=method, duration_s=0.1, record_every=1000)
    rough, fine = (sn.simulate(replace(scene, dt_s=dt_s)) for dt_s in (3e-3, 1e-4))
    assert rough.t_s[-1] == fine.t_s[-1] == 0.1
    assert rough.theta_rad[-1] == pytest.approx(fine.theta_rad[-1], abs=1e-8)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"dt_s": 0.0}, "dt_s is 0.0"),
        ({"dt_s": 1e-12, "duration_s": 1e3}, "more than"),
        ({"dt_s": 1e-6, "duration_s": 1e3, "record_every": 1}, "recording would take 144 GB"),
        ({"formulation": "both"}, "formulation is 'both'"),
        ({"drive": "torque"}, "give torque with drive"),
        ({"method": "collocation"}, "method is 'collocation'"),
        ({"record": "joints"}, "must be a list"),
        ({"record": 1.0}, "record is 1.0"),
        ({"limp": 2}, "limp is 2"),
        ({"locked": [2]}, "locked is [2]"),
        ({"record_every": 0}, "record_every is 0"),
        ({"drive": "torque", "torque": lambda _t: [math.nan] * 2}, "torque at 0 s[0] is nan"),
    ],
)
def test_bad_input_is_named(change: dict, said: str) -> None:
    with pytest.raises(sn.BadInput) as error:
        sn.simulate(sn.Scene(THREE, VISCOUS, THREE_GAIT, **change))
    assert said in str(error.value)


def test_a_start_of_another_size_or_whose_joints_turn_at_another_rate_is_refused() -> None:
    start = sn.LinkState.in_gait(PAPER, PAPERS_GAIT, 0.0, [0, 0, 0], [0, 0, 0])
    turning = replace(start, omega_rad_s=start.omega_rad_s + 0.1 * np.arange(6))
    with refused(r"start has joint 1 at rate"):
        sn.simulate(sn.Scene(PAPER, VISCOUS, PAPERS_GAIT, start=turning, duration_s=0.1))
    with refused("start has 6 links, the robot has 3"):
        sn.Scene(THREE, VISCOUS, PAPERS_GAIT, start=start)


@pytest.mark.parametrize("start", ["zero_momentum", "steady"])
@pytest.mark.parametrize("ct", [0.05, 0.5, 5.0, 500.0])
def test_springs_start_at_the_links_own_speed_on_heavily_damped_ground(
    ct: float, start: str
) -> None:
    """Friction decays within a thousandth of the gait's radian, at last faster than springs swing.

    The links go some 1e-4 m/s; springs that start open by what they carry add a few per cent.
    """
    scene = sn.Scene(
        OF_2005,
        sn.Ground(ct, 10 * ct),
        sn.Gait(0.5236, 1.3963, 0.005),
        formulation="implicit",
        joint_stiffness_n_m=1e5,
        joint_damping_n_s_m=10.0,
        dt_s=1e-5 if ct < 50 else 1e-6,
        duration_s=2e-3,
        start=start,
    )
    run = sn.simulate(scene)
    exact = sn.simulate(replace(scene, formulation="explicit"))
    assert np.abs(run.vx_m_s[0] - exact.vx_m_s[0]).max() < 0.05 * np.abs(exact.vx_m_s[0]).max()
    assert np.abs(run.x_m - exact.x_m).max() < 1e-5


def test_springs_too_soft_to_start_with_are_refused() -> None:
    soft = {"formulation": "implicit", "joint_stiffness_n_m": 1.0}
    scene = sn.Scene(PAPER, VISCOUS, PAPERS_GAIT, **soft)
    with refused(r"more than a link .* gap 'zero'"):
        sn.simulate(scene)
