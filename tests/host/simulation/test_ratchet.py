"""Ratchet wheels: friction that differs forwards and backwards, in every formulation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import OF_2005, gait_in_deg

from . import truth_cases as tc

SMALL = sn.Robot(3, 0.0756, 0.076)
RATCHET = sn.Ground((0.014, 0.05), 0.2, (0.0233, 0.06), 0.045)
GROUNDS = {
    "both": RATCHET,
    "dry": sn.Ground(0.014, 0.2, (0.0, 0.05), 0.045),
    "viscous": sn.Ground((0.014, 0.14), 0.2),
    "viscous, dry across": sn.Ground((0.14, 0.014), 0.2, 0.0, 0.045),
}
GAIT = gait_in_deg(40, 60, 2.0)
FREE = gait_in_deg(60, 100, 4.0)
ENDS = ("start", "end")


def travel_m_s(run: sn.Run) -> float:
    """Return the centre of mass's way from the first to the last row over the time, m/s."""
    way = [(v[-1] - v[0]).mean() for v in (run.x_m, run.y_m)]
    return math.hypot(*way) / run.t_s[-1]


@pytest.mark.parametrize("name", GROUNDS)
def test_half_a_cycle_is_that_of_the_event_driven_reference(name: str) -> None:
    """In time, and for the periodic state: half a period later it is its own mirror image."""
    scene = sn.Scene(
        SMALL,
        GROUNDS[name],
        FREE,
        method="nonsmooth",
        start="steady",
        duration_s=FREE.period_s / 2,
        tolerance=1e-9,
    )
    begin, end = (np.reshape(tc.DRY_RUNS[f"ratchet {name}"][key], (2, 3, 3)) for key in ENDS)
    state = sn.simulate(scene).state(0)
    assert state.omega_rad_s == pytest.approx(begin[1, :, 2], abs=3e-5 * FREE.omega_rad_s)
    start = sn.LinkState(*begin[0].T, *begin[1].T)
    run = sn.simulate(replace(scene, start=start))
    assert tc.places(run)[-1] == pytest.approx(end[0], abs=3e-7)
    assert end[1, :, 2] == pytest.approx(-begin[1, :, 2], abs=3e-5 * FREE.omega_rad_s)
    assert travel_m_s(run) > 1e-3  # it moves


def test_more_wheels_stop_at_once_than_there_are_freedoms() -> None:
    """A lag of 60 degrees: five wheels across stop within an instant, on three freedoms."""
    loose, tight = (
        sn.simulate(
            sn.Scene(
                OF_2005,
                GROUNDS["dry"],
                GAIT,
                start="steady",
                duration_s=GAIT.period_s / 2,
                tolerance=tolerance,
            )
        )
        for tolerance in (1e-7, 1e-10)
    )
    assert tc.off(tc.places(loose), tc.places(tight), OF_2005) < 1e-6


def test_what_smooth_methods_cannot_do_is_said() -> None:
    with refused("nonsmooth"):
        sn.Scene(OF_2005, GROUNDS["viscous"], GAIT, method="dop853")
    assert sn.Scene(OF_2005, GROUNDS["viscous"], GAIT).method == "nonsmooth"
    with refused("rtol"):
        sn.steady_gait(OF_2005, GROUNDS["viscous"], GAIT, rtol=1e-10)
