"""Two sessions of one robot: differences held against their errors, and what explains them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import short_session
from calibration.test_ratchet_pushes import with_backward
from refusals import refused
from serpenoid import fit_friction
from serpenoid.calibration.friction_result import Estimate, WholeSnake
from serpenoid.prediction.two_fits import two_fits, two_sessions


@pytest.fixture(scope="module")
def fit():
    return fit_friction(short_session())


def moved(fit, values):
    pairs = zip(fit.names, values, np.sqrt(np.diag(fit.covariance)), strict=True)
    return replace(fit, parameters=WholeSnake({n: Estimate(float(v), s) for n, v, s in pairs}))


def values_of(fit):
    return np.array(list(fit.whole_snake.values()))


def test_two_draws_of_one_truth_differ_as_often_as_stated(fit) -> None:
    root, rng = np.linalg.cholesky(2 * fit.covariance), np.random.default_rng(2)
    off = root @ rng.normal(size=(4, 400))
    found = [two_fits(fit, moved(fit, values_of(fit) + d)) for d in off.T]
    assert np.mean([one.p_value < 0.05 for one in found]) == pytest.approx(0.05, abs=0.035)
    assert np.mean([one.rows[0].sigmas ** 2 for one in found]) == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize(
    ("cause", "factors"),
    [
        ("mass", (1.4, 1.4, 1.4, 1.4)),
        ("speed", (1.5, 1.5, 1.0, 1.0)),
        ("ct", (1.6, 1, 1, 1)),
        ("fn0", (1.0, 1.0, 1.0, 1.5)),
        ("ft0", (1.0, 1.0, 1.5, 1.0)),
        ("bend", (1, 1.5, 1, 1.5)),
    ],
)
def test_what_was_changed_is_named(fit, cause, factors) -> None:
    found = two_fits(fit, moved(fit, values_of(fit) * factors))
    assert cause in found.causes
    assert found.p_value < 0.05


def test_frictions_backwards_are_compared_where_both_have_them(fit) -> None:
    ratchet = fit_friction(with_backward(short_session()))
    held = two_fits(ratchet, moved(ratchet, values_of(ratchet) * [1, 1, 1, 1, 1, 1.6]))
    assert held.causes == ("ft0_back",)
    assert len(two_fits(fit, ratchet).rows) == 4


def test_two_sessions_agree_and_two_robots_are_refused() -> None:
    one, other = (short_session(seed) for seed in (1, 2))
    found = two_sessions(one, other)
    assert found.p_value > 0.01
    assert "agree within" in found.verdict
    assert "trusted" not in found.verdict
    fit = fit_friction(one)
    assert "is not to be trusted. chi2" in two_fits(fit, replace(fit, alarms=("chi2",))).verdict
    longer = replace(other.setup.robot, link_length_m=0.1)
    with refused("one robot"):
        two_sessions(one, replace(other, setup=replace(other.setup, robot=longer)))
