"""Ratchet wheels, whose friction differs forwards and backwards, against independent code."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from robots import gait_in_deg

from . import truth_cases

SMALL = sn.Robot(3, 0.0756, 0.076)
GROUNDS = {
    "both": sn.Ground((0.014, 0.05), 0.2, (0.0233, 0.06), 0.045),
    "dry": sn.Ground(0.014, 0.2, (0.0, 0.05), 0.045),
}
GAIT = gait_in_deg(60, 100, 4.0)
ENDS = ("start", "end")


@pytest.mark.parametrize("name", GROUNDS)
def test_half_a_cycle_equals_the_event_driven_reference(name: str) -> None:
    """Compare the start of the periodic state, and the end of a run of half a cycle."""
    scene = sn.Scene(
        SMALL,
        GROUNDS[name],
        GAIT,
        method="nonsmooth",
        start="steady",
        duration_s=GAIT.period_s / 2,
        tolerance=1e-9,
    )
    begin, end = (
        np.reshape(truth_cases.DRY_RUNS[f"ratchet {name}"][key], (2, 3, 3)) for key in ENDS
    )
    state = sn.simulate(scene).state(0)
    assert state.omega_rad_s == pytest.approx(begin[1, :, 2], abs=3e-5 * GAIT.omega_rad_s)
    start = sn.LinkState(*begin[0].T, *begin[1].T)
    run = sn.simulate(replace(scene, start=start))
    assert truth_cases.places(run)[-1] == pytest.approx(end[0], abs=3e-7)
