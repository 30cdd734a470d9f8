"""The ledger's positive work, whose integrand has kinks: its error, its order, its claim, its cost.

References: the table of an event-driven solver (tests/oracle), pinned joints for hard springs, and
the periodic state.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import serpenoid as sn
from robots import PAPER, VISCOUS

from . import truth_cases as tc

POSITIVE = 6  # column of positive work
PAPER = sn.Scene(
    PAPER,
    VISCOUS,
    tc.PAPER_GAIT,
    method="dop853",
    duration_s=2.0,
    dt_s=0.01,
    record=("energy",),
)


def positive(scene: sn.Scene, tolerance: float) -> sn.Run:
    return sn.simulate(replace(scene, tolerance=tolerance, record=("energy",)))


def claim(run: sn.Run) -> float:
    energy = run.error_estimate.integration.energy_j
    assert energy is not None
    return energy["positive_work_j"]


@pytest.mark.parametrize("name", ["viscous", "dry", "torque", "table", "servo", "full"])
def test_against_events(name: str) -> None:
    """A slow reference with its own equations: to 2e-8, and loose runs to what they claim."""
    if name in ("viscous", "dry"):
        ground = VISCOUS if name == "viscous" else sn.Ground(0.1, 1.0, 0.1, 0.5)
        scene = replace(
            PAPER,
            robot=sn.Robot(4, 1.0, 0.12),
            ground=ground,
            duration_s=0.3,
            method="dop853" if name == "viscous" else "nonsmooth",
        )
    else:
        scene = tc.free_case(name, 7 if name == "full" else 2, duration_s=0.2)
    truth = tc.DRY_RUNS[f"work {name}"]["positive_work_j"]
    assert positive(scene, 1e-12).energy_j[-1, POSITIVE] == pytest.approx(truth, rel=2e-8)
    for tolerance in (1e-6, 1e-9):
        run = positive(scene, tolerance)
        error = abs(run.energy_j[-1, POSITIVE] - truth)
        assert error <= 1.1 * claim(run) + 1e-10 * truth


@pytest.mark.parametrize("dry", [False, True])
def test_the_periodic_state_has_the_same_positive_power(dry: bool) -> None:
    ground = tc.BINGHAM if dry else PAPER.ground
    robot = tc.OF_2005 if dry else PAPER.robot
    gait = replace(tc.PAPER_GAIT, alpha_rad=math.radians(70)) if dry else tc.PAPER_GAIT
    steady = sn.steady_gait(robot, ground, gait, rtol=1e-7 if dry else 1e-10)
    period = gait.period_s
    run = sn.simulate(
        replace(
            PAPER,
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
    power = (run.energy_j[-1, POSITIVE] - run.energy_j[-2, POSITIVE]) / period
    assert power == pytest.approx(steady.positive_power_w, rel=1e-7 if dry else 3e-8)
