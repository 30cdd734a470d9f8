"""Stability: what is refused grows, what runs does not; extremes meet their error or say no."""

from __future__ import annotations

from dataclasses import replace

import pytest
import serpenoid as sn
from robots import PAPER, VISCOUS, gait_in_deg
from serpenoid.bench import stability_map
from serpenoid.simulation.stability import largest_stable_step_s

GAIT = gait_in_deg(30, 80, 5.0)


def test_the_quiet_failure_of_rk4_is_refused() -> None:
    """The limit at 1 ms is 0.78e6 N/m for m = 1 kg; above it a run may stay finite and be wrong."""
    springs = {"formulation": "implicit", "duration_s": 0.02, "start": "link1_at_rest"}
    scene = sn.Scene(PAPER, VISCOUS, GAIT, joint_stiffness_n_m=7e5, **springs)
    sn.simulate(scene)
    for k in (9e5, 2.2e6, 1e8):
        with pytest.raises(sn.StepTooLarge, match=r"dt_s is 0\.001; method rk4 is stable up to"):
            sn.simulate(replace(scene, joint_stiffness_n_m=k))


@pytest.mark.parametrize("method", stability_map.fixed_step_methods())
def test_what_runs_does_not_grow_and_what_grows_is_refused(method: str) -> None:
    """Around the limit by the modes: a disturbance grows half above and not just below."""
    # from 60 links on the limit is by a bound of the modes
    for links, friction, damping, stiffness in (
        (2, 10.0, 1e3, 1e5),
        (6, 10.0, 300, 1e6),
        (6, 1e4, 1e3, 1e3),  # friction brakes what the dampers do, too
        (80, 10.0, 30, 1e5),
    ):
        line = method, links, friction, damping, stiffness
        limit = min(1.0, largest_stable_step_s(stability_map.scene_of(*line)))
        below, above = stability_map.line_of_growth(line, (0.98 * limit, 1.5 * limit), 3000)
        assert below < stability_map.UNSTABLE_GROWTH, line
        assert above > stability_map.UNSTABLE_GROWTH, line
