"""What runs say of their own error, held to tight references; accuracy= keeps its word."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
import serpenoid as sn
from refusals import refused
from robots import BINGHAM, OF_2005, PAPER, VISCOUS, gait_in_deg
from serpenoid.simulation.judge import difference

GAIT = gait_in_deg(30, 80, 5.0)
SERVO = sn.Servo(stiffness_nm_rad=100.0, damping_nms_rad=2.0, torque_limit_nm=5.0)
SCENES = {
    "plain": sn.Scene(PAPER, VISCOUS, GAIT, duration_s=3.0),
    "incline": sn.Scene(PAPER, VISCOUS, GAIT, duration_s=3.0, incline_rad=0.1),
    "servo": sn.Scene(PAPER, VISCOUS, GAIT, duration_s=1.0, drive="servo", servo=SERVO),
    "limp": sn.Scene(PAPER, VISCOUS, GAIT, duration_s=3.0, limp=(2,)),
    "locked": sn.Scene(PAPER, VISCOUS, GAIT, duration_s=3.0, locked={3: 0.2}),
    "dry": sn.Scene(OF_2005, BINGHAM, GAIT, duration_s=2.0),
    "dry servo": sn.Scene(OF_2005, BINGHAM, GAIT, duration_s=1.0, drive="servo", servo=sn.Servo()),
    "dry limp": sn.Scene(OF_2005, BINGHAM, GAIT, duration_s=2.0, limp=(2,)),
    "dry torque": sn.Scene(
        OF_2005,
        BINGHAM,
        GAIT,
        duration_s=2.0,
        drive="torque",
        torque=[2e-3, -1e-3, 1.5e-3, -2e-3, 1e-3],
    ),
}


def reference(scene: sn.Scene) -> sn.Run:
    """Return a run far more accurate than those judged, by another method."""
    if scene.law == "dry":
        return sn.simulate(replace(scene, method="nonsmooth", tolerance=1e-11))
    if scene.servo:
        return sn.simulate(replace(scene, method="dop853", tolerance=1e-10))
    return sn.simulate(replace(scene, method="rk4", dt_s=1e-4, record_every=10))


@pytest.mark.parametrize("name", [n for n in SCENES if "dry" not in n])
@pytest.mark.parametrize(
    "how",
    [
        {"method": "rk4", "dt_s": 1e-2},
        {"method": "dop853", "tolerance": 1e-5},
    ],
    ids=lambda how: how["method"],
)
def test_the_estimate_is_about_the_error(name: str, how: dict) -> None:
    scene = replace(SCENES[name], **how)
    if name == "servo":  # servo poles need small steps
        scene = replace(scene, dt_s=1e-4)
    run, exact = sn.simulate(scene), reference(SCENES[name])
    true, said = difference(run, exact), run.error_estimate.integration
    assert 0.3 * true.position_m < said.position_m + 1e-9
    assert said.position_m < 30 * true.position_m + 1e-7
    assert 0.3 * true.angle_rad < said.angle_rad + 1e-9


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("accuracy", [1e-2, 1e-5])
def test_an_accuracy_is_kept(name: str, accuracy: float) -> None:
    scene = SCENES[name]
    run = sn.simulate(scene, accuracy=accuracy)
    off, body = difference(run, reference(scene)), scene.robot.links * scene.robot.link_length_m
    assert max(off.position_m / body, off.angle_rad) < accuracy
    assert run.scene.method in run.picked


def test_chaos_is_named() -> None:
    """Springs without friction swing as a pendulum chain does: nobody can say where it is."""
    scene = sn.Scene(
        sn.Robot(4, 0.2, 0.1),
        sn.Ground(1e-4, 1e-3),
        sn.Gait(1.0, 1.0, 3.0),
        drive="servo",
        servo=sn.Servo(0.05, 0.0, 1.0, 100.0),
        method="dop853",
        tolerance=1e-3,
        duration_s=100.0,
        dt_s=0.01,
    )
    run = sn.simulate(scene)
    assert not run.error_estimate.settled
    assert run.error_estimate.chaotic
    assert 0 < run.error_estimate.believed_s < 100
    assert any("the motion is chaotic" in w and "believe it up to" in w for w in run.warnings)


def test_what_only_fixed_steps_run_is_judged_by_shorter_ones() -> None:
    """The paper's scheme, whose dampers act on the step before: no other method runs it."""
    scene = replace(SCENES["plain"], formulation="implicit", method="paper", dt_s=2e-4)
    run = sn.simulate(scene)
    true = difference(run, sn.simulate(replace(scene, dt_s=2e-5, record_every=10)))
    said = run.error_estimate.integration
    assert true.position_m <= said.position_m < 3 * true.position_m


@pytest.mark.parametrize("method", ["dop853", "nonsmooth"])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-7])
def test_methods_that_follow_a_tolerance_know_their_error(method: str, tolerance: float) -> None:
    scene = replace(SCENES["plain"], method=method, tolerance=tolerance)
    run = sn.simulate(scene)
    true = difference(run, reference(replace(scene, method="rk4")))
    said = run.error_estimate.integration
    assert true.position_m < 1.1 * said.position_m
    assert said.position_m < 2 * true.position_m + 1e-8


def test_the_springs_error_is_the_difference_to_the_exact_model() -> None:
    soft = replace(SCENES["plain"], formulation="implicit", joint_stiffness_n_m=1e3)
    run = sn.simulate(soft)
    true = difference(run, reference(SCENES["plain"]))
    said = run.error_estimate.modelling
    assert said is not None
    assert said.position_m == pytest.approx(true.position_m, rel=1e-3)
    assert any("springs (k = 1000 N/m) change the mean speed" in w for w in run.warnings)


def test_a_method_that_knows_nothing_of_sticking_is_warned_of() -> None:
    run = sn.simulate(replace(SCENES["dry"], method="rk4", duration_s=0.3))
    assert any("nothing of sticking" in w for w in run.warnings)


def test_an_accuracy_out_of_reach_is_refused() -> None:
    with refused("accuracy is 1e-20"):
        sn.simulate(SCENES["plain"], accuracy=1e-20)


@pytest.mark.parametrize("asked", [{"incline_rad": 0.017}, {"method": "rk4"}])
def test_a_robot_at_rest_has_no_share_of_its_speed_to_be_off(asked):
    still = sn.Gait(0.0, 1.4, 5.0)
    scene = sn.Scene(OF_2005, BINGHAM, still, duration_s=3.0, formulation="implicit", **asked)
    run = sn.simulate(scene)
    assert math.isnan(run.error_estimate.integration.mean_speed)
    assert math.isnan(run.error_estimate.modelling.mean_speed)
    assert not [warning for warning in run.warnings if "mean speed" in warning]


def test_the_stiffness_that_an_accuracy_asks_for_is_enough() -> None:
    scene = replace(SCENES["plain"], formulation="implicit", duration_s=1.0)
    with pytest.raises(sn.NotConverged, match="joint_stiffness_n_m") as refused:
        sn.simulate(scene, accuracy=1e-3)
    advised = float(re.search(r"joint_stiffness_n_m ([\d.e+]+)", str(refused.value))[1])
    run = sn.simulate(replace(scene, joint_stiffness_n_m=advised), accuracy=1e-3)
    assert run.error_estimate.worst(scene.robot.body_length_m) <= 1e-3
