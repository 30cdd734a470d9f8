"""Stability: what is refused grows, what runs does not; extremes meet their error or say no."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from robots import PAPER, VISCOUS, gait_in_deg
from serpenoid import LinkState
from serpenoid.bench import stability_map
from serpenoid.bench.stability_map import Grid
from serpenoid.simulation.methods import METHODS
from serpenoid.simulation.stability import largest_stable_step_s

GAIT = gait_in_deg(30, 80, 5.0)


SLOW = sn.Scene(PAPER, sn.Ground(1.0, 1.0), sn.Gait(0.5, 1.4, 0.3), method="rk4", dt_s=4.0)


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


def test_the_limit_goes_as_the_damping_over_thirty_decades() -> None:
    """Dampers alone have no other scale; below 1e-15 s the search came to no end."""
    damped = [
        sn.Scene(PAPER, VISCOUS, gait_in_deg(30, 80, 5.0), "implicit", 0.0, c, method="rk4")
        for c in (1e6, 1e18, 1e30)
    ]
    limits = [scene.joint_damping_n_s_m * largest_stable_step_s(scene) for scene in damped]
    assert limits == pytest.approx([limits[0]] * 3, rel=1e-6)


def test_a_small_map_has_no_cell_that_runs_and_is_unstable() -> None:
    grid = Grid((3,), (10.0, 1e4), (0.0, 100.0), (1e3, 1e6), (1e-4, 1e-3, 1e-2), 600)
    cells = list(stability_map.measure(grid, lambda _: None))
    assert len(cells) == 24 * len(stability_map.fixed_step_methods())
    assert not [cell for cell in cells if cell.kind == 3]
    assert {cell.kind for cell in cells} >= {0, 1}


def changes_of_a_free_snake(method: str, formulation: str, dt_s: float):
    """Return what 2000 steps change of energy and momenta that nothing acts on, J and kg m/s."""
    place, rates = (0, 0, 0.1, 0.5, -0.3, 0.2, 0.6, -0.1), (0.3, -0.2, 1, -0.6, 0.8, 0.4, -0.9, 0.5)
    limp = {"drive": "torque", "torque": [0.0] * 5, "joint_damping_n_s_m": 0.0}
    times = {"dt_s": dt_s, "duration_s": 2000 * dt_s, "record_every": 10**9}
    start = LinkState.joined(PAPER, place, rates)
    still = {"formulation": formulation, "method": method, "start": start}
    scene = sn.Scene(PAPER, sn.Ground(0.0, 0.0), sn.Gait(0.0, 0.0, 1.0), **still, **limp, **times)
    run = sn.simulate(scene)
    vx, vy, w = run.vx_m_s, run.vy_m_s, run.omega_rad_s
    spin = run.x_m * vy - run.y_m * vx + PAPER.inertia_kg_m2 * w
    energy = (vx**2 + vy**2 + PAPER.inertia_kg_m2 * w**2) / 2
    return [float(np.ptp(part.sum(axis=1)[[0, -1]])) for part in (energy, vx, vy, spin)]


def test_a_free_snake_keeps_its_momentum() -> None:
    """Forces in pairs: to rounding in the implicit formulation, by every method at any step.

    1e-4 s is a ten thousandth of the time scale: rk4's order leaves less than rounding of all.
    """
    assert max(changes_of_a_free_snake("rk4", "explicit", 1e-4)) < 1e-12
    for name, kind in METHODS.items():
        if "implicit" in kind.formulations:
            assert max(changes_of_a_free_snake(name, "implicit", 1e-3)[1:3]) < 1e-12, name
