"""The stiff method: truth from SciPy on plain equations, order, ringing, extremes, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from robots import PAPER, gait_in_deg
from scipy.integrate import solve_ivp
from serpenoid.bench.problems import PAPER_GROUND, Problem
from serpenoid.simulation.starts import start_state

from .truth_cases import rate_of

THREE = sn.Robot(3, 1.0, 0.12)
THREE_GAIT = gait_in_deg(30, 90, 3.0)
SIX_GAIT = gait_in_deg(30, 80, 5.0)


def three(duration_s: float, k: float, c: float) -> Problem:
    return Problem("three", "", THREE, PAPER_GROUND, THREE_GAIT, duration_s, k, c)


def six(k: float, c: float, **changes: object) -> sn.Scene:
    fields = {"method": "radau", "tolerance": 1e-6, "duration_s": 0.3, "dt_s": 0.01, **changes}
    return sn.Scene(
        PAPER,
        PAPER_GROUND,
        SIX_GAIT,
        formulation="implicit",
        joint_stiffness_n_m=k,
        joint_damping_n_s_m=c,
        **fields,
    )


def radau_end(problem: Problem, tolerance: float, **changes: object) -> np.ndarray:
    scene = problem.scene(
        method="radau", tolerance=tolerance, dt_s=problem.duration_s, start=problem.start, **changes
    )
    return problem.vector(sn.simulate(scene).state())


@pytest.mark.parametrize(
    ("duration_s", "k", "c", "solver", "rtol"),
    [
        (0.3, 1e3, 1.0, "DOP853", 1e-12),
        (0.05, 1e5, 10.0, "DOP853", 1e-12),
        (0.02, 1e7, 1e3, "Radau", 1e-9),
    ],
)
def test_it_meets_its_tolerance(
    duration_s: float, k: float, c: float, solver: str, rtol: float
) -> None:
    problem = three(duration_s, k, c)
    exact = solve_ivp(
        rate_of(problem), (0, duration_s), problem.first, solver, rtol=rtol, atol=rtol / 100
    ).y[:, -1]
    for tolerance in (1e-3, 1e-5, 1e-7):
        assert problem.error(radau_end(problem, tolerance), exact) < tolerance


@pytest.mark.parametrize("method", ["radau", "dop853"])
@pytest.mark.parametrize("case", ["servo", "torque", "incline", "offset"])
def test_what_a_scene_may_have(case: str, method: str) -> None:
    """Held to RK4 with small steps on springs that it can bear."""
    ground, gait, more = PAPER_GROUND, THREE_GAIT, {}
    if case == "servo":
        more = {"drive": "servo", "servo": sn.Servo(2.0, 0.05, 1.0, 6.0)}
    elif case == "torque":
        more = {"drive": "torque", "torque": lambda t: 0.02 * np.sin(3 * t + np.arange(2))}
    elif case == "incline":
        more = {"incline_rad": 0.2, "incline_direction_rad": 0.7}
    else:
        gait = sn.Gait(0.5, 1.0, 4.0, 0.1)

    def end(method: str, dt_s: float) -> np.ndarray:
        scene = sn.Scene(
            THREE,
            ground,
            gait,
            formulation="implicit",
            joint_stiffness_n_m=1e4,
            joint_damping_n_s_m=30.0,
            duration_s=0.1,
            method=method,
            dt_s=dt_s,
            tolerance=1e-8,
            **more,
            start="link1_at_rest",
        )
        return sn.simulate(scene).state().packed()

    # the kinks of a servo's limits inside a step cost order, not truth
    allowed = 1e-5 if case == "servo" else 1e-7
    assert np.abs(end(method, 0.01) - end("rk4", 2e-5)).max() < allowed


@pytest.mark.parametrize("c", [0.0, 1.0])
def test_ringing_is_followed_not_quietly_damped(c: float) -> None:
    """From a zero gap the joints ring; above the tolerance the ringing must be in the result."""
    problem = three(0.02, 1e6, c)
    start = start_state(problem.scene(gap="zero"))
    first = problem.vector(start)
    exact = solve_ivp(rate_of(problem), (0, 0.02), first, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    smooth = radau_end(problem, 1e-6)
    assert problem.error(smooth, exact) > 1e-5  # so large is the ringing itself
    for tolerance in (1e-6, 1e-7):
        run = sn.simulate(
            problem.scene(method="radau", tolerance=tolerance, dt_s=0.02, start=start)
        )
        assert problem.error(problem.vector(run.state()), exact) < 2 * tolerance
        assert problem.error(problem.vector(run.state()), exact) < run.local_error


def test_where_a_fixed_step_is_refused_this_method_is_named_and_runs() -> None:
    with pytest.raises(sn.StepTooLarge, match="method 'radau'"):
        sn.simulate(six(1e7, 1.0, method="rk4", dt_s=1e-3))
    dry = replace(six(1e7, 1.0, method="rk4", dt_s=1e-3), ground=sn.Ground(0.1, 10.0, 0.1, 0.1))
    with pytest.raises(sn.StepTooLarge) as refusal:
        sn.simulate(dry)
    assert "radau" not in str(refusal.value)


def test_recorded_times_lie_on_the_motion() -> None:
    """Dense output, joint forces included, is as good as steps that end on the recorded times."""
    run = sn.simulate(six(1e7, 1.0, dt_s=1e-3, record=("joints",), record_every=1))
    fine = sn.simulate(six(1e7, 1.0, dt_s=1e-3, record=("joints",), record_every=1, tolerance=1e-9))
    assert run.steps < 30
    assert len(run.t_s) == 301
    assert np.abs(run.x_m - fine.x_m).max() < 1e-6
    assert np.abs(run.omega_rad_s - fine.omega_rad_s).max() < 1e-5
    scale = np.abs(fine.joint_force_x_n).max()
    assert np.abs(run.joint_force_x_n - fine.joint_force_x_n).max() < 1e-3 * scale


@pytest.mark.parametrize("friction", [0.0, 1e-5, 1e6])
def test_friction_of_every_size(friction: float) -> None:
    """Heavy friction is stiff, too: its derivative must be in the matrix."""
    start = start_state(six(1e7, 1e4))  # of another ground: a damped jolt
    run = sn.simulate(
        sn.Scene(
            PAPER,
            sn.Ground(friction, friction),
            SIX_GAIT,
            formulation="implicit",
            joint_stiffness_n_m=1e7,
            joint_damping_n_s_m=1e4,
            method="radau",
            tolerance=1e-5,
            duration_s=0.3,
            dt_s=0.3,
            start=start,
        )
    )
    assert run.steps < 400


def test_a_torque_beyond_numbers_ends_with_its_cause() -> None:
    scene = sn.Scene(
        THREE,
        PAPER_GROUND,
        THREE_GAIT,
        formulation="implicit",
        drive="torque",
        method="radau",
        torque=lambda t: [1e300 if t > 0.05 else 0.0, 0.0],
        duration_s=0.2,
        start="link1_at_rest",
    )
    with pytest.raises(sn.Diverged, match="however short"):
        sn.simulate(scene)
