"""Positive work in the energy ledger: its error, and the estimate of its error.

The integrand max(power, 0) has kinks. References are a table from an event-driven solver
(tests/oracle) and the periodic state.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import serpenoid as sn
from robots import PAPER, VISCOUS

from . import truth_cases

POSITIVE_WORK = 6  # column of the energy table, J
PAPER_SCENE = sn.Scene(
    PAPER,
    VISCOUS,
    truth_cases.PAPER_GAIT,
    method="dop853",
    duration_s=2.0,
    dt_s=0.01,
    record=("energy",),
)


def run_with_energy(scene: sn.Scene, tolerance: float) -> sn.Run:
    return sn.simulate(replace(scene, tolerance=tolerance, record=("energy",)))


def work_error_estimate(run: sn.Run) -> float:
    energy = run.error_estimate.integration.energy_j
    assert energy is not None
    return energy["positive_work_j"]


@pytest.mark.parametrize("name", ["viscous", "dry", "torque", "table", "servo", "full"])
def test_work_of_an_event_driven_solver(name: str) -> None:
    """Compare with other equations to 2e-8, and at loose tolerances to the error estimate."""
    if name in ("viscous", "dry"):
        ground = VISCOUS if name == "viscous" else sn.Ground(0.1, 1.0, 0.1, 0.5)
        scene = replace(
            PAPER_SCENE,
            robot=sn.Robot(4, 1.0, 0.12),
            ground=ground,
            duration_s=0.3,
            method="dop853" if name == "viscous" else "nonsmooth",
        )
    else:
        scene = truth_cases.free_case(name, 7 if name == "full" else 2, duration_s=0.2)
    truth = truth_cases.DRY_RUNS[f"work {name}"]["positive_work_j"]
    assert run_with_energy(scene, 1e-12).energy_j[-1, POSITIVE_WORK] == pytest.approx(
        truth, rel=2e-8
    )
    for tolerance in (1e-6, 1e-9):
        run = run_with_energy(scene, tolerance)
        error = abs(run.energy_j[-1, POSITIVE_WORK] - truth)
        assert error <= 1.1 * work_error_estimate(run) + 1e-10 * truth


@pytest.mark.parametrize("dry", [False, True])
def test_the_periodic_state_has_the_same_positive_power(dry: bool) -> None:
    ground = truth_cases.BINGHAM if dry else PAPER_SCENE.ground
    robot = truth_cases.OF_2005 if dry else PAPER_SCENE.robot
    gait = (
        replace(truth_cases.PAPER_GAIT, alpha_rad=math.radians(70))
        if dry
        else truth_cases.PAPER_GAIT
    )
    steady = sn.steady_gait(robot, ground, gait, rtol=1e-7 if dry else 1e-10)
    period = gait.period_s
    run = sn.simulate(
        replace(
            PAPER_SCENE,
            robot=robot,
            ground=ground,
            gait=gait,
            start="steady",
            tolerance=1e-12,
            method="nonsmooth" if dry else "dop853",
            duration_s=3 * period,
            dt_s=period,
        )
    )
    power = (run.energy_j[-1, POSITIVE_WORK] - run.energy_j[-2, POSITIVE_WORK]) / period
    assert power == pytest.approx(steady.positive_power_w, rel=1e-7 if dry else 3e-8)
