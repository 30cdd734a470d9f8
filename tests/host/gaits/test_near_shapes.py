"""Costs of shapes from their neighbours: against the solver of one gait by secants from rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn
from serpenoid.gaits.limits import GaitLimits
from serpenoid.gaits.shape_search import GaitShape, NearShapes, ShapeSearch, exact_solver
from serpenoid.periodic.near_states import LocalFit

ROBOT, GROUND = sn.Robot(6, 0.0756, 0.076), sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)


@pytest.mark.parametrize("cost", ["power", "positive_power"])
@pytest.mark.parametrize(
    "ground", [GROUND, sn.Ground((0.014, 0.14), 0.2, (0.01, 0.05), 0.1)], ids=["plain", "ratchet"]
)
def test_costs_are_those_of_single_gaits(cost: str, ground: sn.Ground) -> None:
    """Rough ones to what slopes from afar leave, those of chosen shapes to 5e-4."""
    solve = exact_solver(ROBOT, ground, powers=True)
    near = NearShapes(ROBOT, ground, solve, cost, GaitLimits())
    one = ShapeSearch(ROBOT, ground, solve, cost, GaitLimits())
    middle = np.array(GaitShape.of(1.2, 1.3))
    shapes = [middle + 0.06 * np.array([i, j]) for i in range(-3, 3) for j in range(-3, 3)]
    rough = near.points(shapes, 0.1, 2.0, 1e-4)
    chosen = [near.solved(point, 0.1, 1e-4) for point in rough]
    true = [one.point(at, 0.1, 2.0, 1e-6).value for at in shapes]
    assert [point.value for point in rough] == pytest.approx(true, abs=1e-2)
    assert [point.value for point in chosen] == pytest.approx(true, abs=5e-4)


def test_a_few_states_are_enough_for_a_shape() -> None:
    search = NearShapes(ROBOT, GROUND, exact_solver(ROBOT, GROUND, True), "power", GaitLimits())
    middle = np.array(GaitShape.of(1.2, 1.3))
    search.points([middle], 0.1, 2.0, 1e-4)
    before = search.evaluations
    turns = np.linspace(0, 2 * math.pi, 40, endpoint=False)
    ring = [middle + 0.03 * np.array([math.cos(t), math.sin(t)]) for t in turns]
    search.points(ring, 0.1, 2.0, 1e-4)  # all of them know one shape only
    assert search.evaluations - before <= 3 * len(ring)
    before = search.evaluations
    search.points([middle + 0.5 * (at - middle) for at in ring], 0.1, 2.0, 1e-4)
    assert search.evaluations - before <= 1.1 * len(ring)


def test_a_speed_that_no_rate_gives_is_not_allowed() -> None:
    search = NearShapes(ROBOT, GROUND, exact_solver(ROBOT, GROUND, True), "power", GaitLimits())
    (point,) = search.points([np.array(GaitShape.of(0.02, 2.6))], 3.0, 2.0, 1e-4)
    assert point.value == math.inf
    assert point.better[0]


def test_a_local_fit_knows_planes_and_follows_the_nearest() -> None:
    rng = np.random.default_rng(5)
    at = rng.normal(size=(30, 2))
    plane = np.array([[1.0, -2.0, 0.5], [3.0, 0.0, -1.0]])
    fit = LocalFit(2, 3)
    fit.add(at, at @ plane + 4.0)
    asked = rng.normal(size=(7, 2))
    assert fit.expect(asked) == pytest.approx(asked @ plane + 4.0, abs=0.05)
    fit.add(np.array([[10.0, 10.0]]), np.array([[1.0, 2.0, 3.0]]))
    assert fit.expect(np.array([[10.0, 10.0]]))[0] == pytest.approx([1.0, 2.0, 3.0], abs=1e-3)
    assert fit.nearest(np.array([10.0, 10.2])) == pytest.approx(0.2)
