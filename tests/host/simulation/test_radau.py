"""Methods that pick their own steps: truth from SciPy on dense equations, ringing, refusals."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from robots import PAPER, VISCOUS, gait_in_deg

from . import truth_cases as tc

THREE = sn.Robot(3, 1.0, 0.12)
THREE_GAIT = gait_in_deg(30, 90, 3.0)
SCENE = sn.Scene(THREE, VISCOUS, THREE_GAIT, method="dop853", duration_s=0.3, dt_s=0.3)
SOFT = replace(SCENE, formulation="implicit", method="radau")
STIFF = sn.Scene(
    PAPER,
    VISCOUS,
    gait_in_deg(30, 80, 5.0),
    formulation="implicit",
    joint_stiffness_n_m=1e7,
    method="radau",
    duration_s=0.3,
    dt_s=1e-3,
    record_every=1,
)


def on_springs(duration_s: float, k: float, c: float) -> sn.Scene:
    return replace(
        SOFT,
        duration_s=duration_s,
        dt_s=duration_s,
        joint_stiffness_n_m=k,
        joint_damping_n_s_m=c,
    )


def start_of(scene: sn.Scene) -> sn.LinkState:
    return sn.simulate(replace(scene, duration_s=0.0)).state(0)


@pytest.mark.parametrize(
    ("scene", "solver", "rtol"),
    [
        (SCENE, "DOP853", 1e-12),
        (on_springs(0.3, 1e3, 1.0), "DOP853", 1e-12),
        (on_springs(0.05, 1e5, 10.0), "DOP853", 1e-12),
        (on_springs(0.02, 1e7, 1e3), "Radau", 1e-9),
    ],
)
def test_it_meets_its_tolerance(scene: sn.Scene, solver: str, rtol: float) -> None:
    start = start_of(scene)
    exact, _ = tc.end_of(scene, start, rtol, solver)
    for tolerance in (1e-3, 1e-5, 1e-7):
        run = sn.simulate(replace(scene, start=start, tolerance=tolerance))
        assert tc.off(tc.places(run)[-1], exact, THREE) < tolerance
        assert run.local_error > 0


@pytest.mark.parametrize("c", [0.0, 1.0])
def test_ringing_above_the_tolerance_is_followed(c: float) -> None:
    """From a zero gap the joints ring: it must be in the result, not quietly damped."""
    scene = on_springs(0.1, 1e4, c)
    start = start_of(replace(scene, gap="zero"))
    exact, _ = tc.end_of(scene, start, 1e-12, "DOP853")

    def error(run: sn.Run) -> float:
        return tc.off(tc.places(run)[-1], exact, THREE)

    assert error(sn.simulate(scene)) > 1e-5  # so large is the ringing
    for tolerance in (1e-6, 1e-7):
        run = sn.simulate(replace(scene, tolerance=tolerance, start=start))
        assert error(run) < min(0.1 * tolerance, run.local_error)


def test_ringing_below_the_tolerance_is_stepped_over() -> None:
    """Each frame of a servo makes stiff springs ring, by 1e-8 m: the pinned robot moves the same.

    To follow it would take 40 000 steps.
    """
    servo = sn.Servo(20.0, 1.0, torque_limit_nm=10.0, speed_limit_rad_s=10.0)
    driven = replace(STIFF, drive="servo", servo=servo, record_every=10, tolerance=1e-6)
    run = sn.simulate(replace(driven, joint_stiffness_n_m=1e9))
    pinned = sn.simulate(replace(driven, formulation="explicit", method="dop853", tolerance=1e-9))
    assert tc.off(tc.places(run), tc.places(pinned), PAPER) < 1e-5
    assert run.steps < 300


@pytest.mark.parametrize(("k", "c"), [(1e5, 1.0), (1e7, 1.0), (1e5, 32.0), (1e7, 320.0)])
def test_errors_do_not_add_up_over_many_steps(k: float, c: float) -> None:
    """Each corner of a table of torques makes 24 links ring; their errors all lean to one side."""
    led = sn.Scene(sn.Robot(24, 1.0, 0.12), VISCOUS, STIFF.gait, method="rk4", record=("joints",))
    turn = sn.simulate(replace(led, duration_s=1.0, record_every=10))
    scene = replace(
        led,
        formulation="implicit",
        joint_stiffness_n_m=k,
        joint_damping_n_s_m=c,
        drive="torque",
        torque=sn.TorqueTable(turn.t_s, turn.joint_torque_nm),
        start=turn.state(0),
        duration_s=1.0,
        dt_s=0.1,
        record_every=1,
    )
    exact = sn.simulate(replace(scene, method="dop853", tolerance=1e-12))
    for tolerance in (1e-6, 1e-9):
        run = sn.simulate(replace(scene, method="radau", tolerance=tolerance))
        assert tc.off(tc.places(run), tc.places(exact), scene.robot) < tolerance


def test_links_of_a_milligram_follow_stiff_servos_on_dry_ground() -> None:
    """Behind each frame they move within microseconds, in which wheels must not change for ever."""
    servo = sn.Servo(20.0, 1.0, torque_limit_nm=10.0, speed_limit_rad_s=10.0)
    driven = replace(STIFF, formulation="explicit", method="nonsmooth", drive="servo", servo=servo)
    scene = replace(driven, ground=sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27))
    heavy, light = (
        sn.simulate(replace(scene, robot=sn.Robot(2, mass_kg, 0.076))) for mass_kg in (1e-5, 1e-6)
    )
    assert np.abs(heavy.x_m - light.x_m).max() < 1e-5


def test_where_a_fixed_step_is_refused_this_method_is_named_and_runs() -> None:
    with pytest.raises(sn.StepTooLarge, match="method 'radau'"):
        sn.simulate(replace(STIFF, method="rk4"))
    with pytest.raises(sn.StepTooLarge) as refusal:
        sn.simulate(replace(STIFF, method="rk4", ground=sn.Ground(0.1, 10.0, 0.1, 0.1)))
    assert "radau" not in str(refusal.value)


def test_recorded_times_lie_on_the_motion() -> None:
    """Dense output, joint forces included, is as good as steps that end on the recorded times."""
    run, fine = (
        sn.simulate(replace(STIFF, record=("joints",), tolerance=tolerance))
        for tolerance in (1e-6, 1e-9)
    )
    assert run.steps < 40
    assert len(run.t_s) == 301
    assert np.abs(run.x_m - fine.x_m).max() < 1e-6
    assert np.abs(run.omega_rad_s - fine.omega_rad_s).max() < 2e-5
    scale = np.abs(fine.joint_force_x_n).max()
    assert np.abs(run.joint_force_x_n - fine.joint_force_x_n).max() < 1e-3 * scale


def test_a_torque_beyond_numbers_ends_with_its_cause() -> None:
    torque = {"drive": "torque", "torque": lambda t: [1e300 if t > 0.05 else 0.0, 0.0]}
    with pytest.raises(sn.Diverged, match="however short"):
        sn.simulate(replace(SOFT, **torque, start="link1_at_rest"))


def test_a_stiff_scene_is_refused_by_the_explicit_method() -> None:
    scene = replace(SCENE, robot=sn.Robot(6, 1e-6, 0.12), duration_s=100.0)
    began = time.process_time()
    with pytest.raises(sn.Diverged, match="stiff"):
        sn.simulate(scene)
    assert time.process_time() - began < 20  # the run itself would take hours
