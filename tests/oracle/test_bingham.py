"""Set-valued friction by events: the law itself, published speeds, and a second method."""

from __future__ import annotations

import numpy as np
import pytest

from . import bingham, bingham_periodic, bingham_stepping, periodic
from . import body_frame as bf
from . import generate_bingham as generate
from .params import Params, gait_deg, robot_2005

ROWS = generate.table()


def row_of(omega_rad_s: float) -> dict[str, float]:
    """Return the 2005 robot's row at alpha = 70, beta = 75 degrees."""
    wanted = gait_deg(70, 75, omega_rad_s)
    return next(row for p, gait, row in ROWS if p == ROWS[0][0] and gait == wanted)


def start_of(row: dict[str, float]) -> np.ndarray:
    """Return a row's velocities at t = 0, (3,)."""
    return np.array([row[name] for name in ("u0_x_m_s", "u0_y_m_s", "u0_spin_rad_s")])


def test_published_speeds() -> None:
    assert row_of(5)["speed_m_s"] == pytest.approx(0.133205, abs=5e-7)
    assert row_of(1)["speed_m_s"] == pytest.approx(0.03317, abs=5e-6)


def test_contact_rates_are_derivatives() -> None:
    p, gait, rng = robot_2005(4), gait_deg(50, 70, 3), np.random.default_rng(1)
    u, u_dot, t, step = rng.normal(size=3), rng.normal(size=3), 0.3, 1e-6
    touch = bingham.contacts_at(bf.shape_at(p, gait, t), u)
    later, before = (
        bingham.contacts_at(bf.shape_at(p, gait, t + h), u + h * u_dot).slip for h in (step, -step)
    )
    # central differences: rounding 1e-16 / step
    assert touch.rows @ u_dot + touch.bias == pytest.approx((later - before) / (2 * step), abs=1e-8)
    assert touch.slip == pytest.approx(bf.slip(bf.shape_at(p, gait, t), u).ravel(), abs=1e-15)


def test_every_piece_obeys_the_law_of_friction() -> None:
    """Slipping contacts slip the way their mode says; sticking ones rest within their grip."""
    system = bingham.System(robot_2005(), gait_deg(70, 75, 1.0))
    modes, stuck_most = set(), 0
    for piece in bingham_periodic.cycle(system, start_of(row_of(1)), 1e-10):
        middle = (piece.start_s + piece.end_s) / 2
        y, stuck = piece.at(middle), piece.mode == 0
        _, force, touch, _ = system.forces(middle, y[:3], piece.mode)
        # integration error of a tolerance of 1e-10 over a piece
        assert np.abs(touch.slip[stuck]).max(initial=0.0) < 1e-9
        assert (piece.mode * touch.slip)[~stuck].min() > -1e-9
        assert (np.abs(force) - system.threshold)[stuck].max(initial=-1.0) < 1e-9
        modes.add(tuple(piece.mode))
        stuck_most = max(stuck_most, stuck.sum())
    assert len(modes) > 20
    assert stuck_most == 3


def test_without_thresholds_it_is_the_viscous_state() -> None:
    p, gait = Params(3, 1.0, 0.06, None, 0.1, 10.0), gait_deg(30, 90, 3)
    smooth = periodic.steady(p, gait)
    found = bingham_periodic.steady(p, gait, 1e-9, smooth.u0)
    assert found.speed_m_s == pytest.approx(smooth.speed_m_s, rel=1e-8)
    assert found.abs_power_w == pytest.approx(smooth.abs_power_w, rel=1e-8)


@pytest.mark.parametrize("index", [pytest.param(4, marks=pytest.mark.slow), 26])
def test_second_method_agrees(index: int) -> None:
    """Implicit Euler with convex steps knows nothing of events and travels as far in a cycle."""
    p, gait, row = ROWS[index]
    system, start = bingham.System(p, gait), start_of(row)
    last = bingham_periodic.cycle(system, start, 1e-9)[-1]
    travel = last.at(last.end_s)[4:]
    coarse, fine = (bingham_stepping.march(system, start, n)[1][1:] for n in (500, 1000))
    # the rest after one extrapolation is of second order; measured up to 7e-4 of the distance,
    # and the table's `other_method` column carries the comparison on to 1e-7 .. 1e-5
    assert np.abs(2 * fine - coarse - travel).max() < 1.5e-3 * np.hypot(*travel)


def test_convex_step_obeys_its_optimality_conditions() -> None:
    """Zero lies in the subgradient at the minimiser, for random functions with many kinks."""
    rng = np.random.default_rng(2)
    for _ in range(200):
        root = rng.normal(size=(3, 3))
        rows, drive = rng.normal(size=(12, 3)), rng.normal(size=12) * 0.3
        matrix, load, weight = root @ root.T + 0.1 * np.eye(3), rng.normal(size=3), rng.random(12)
        problem = bingham_stepping.Kinked(matrix, load, rows, drive, weight)
        u, mode = problem.minimise(rng.integers(-1, 2, 12) * (rng.random(12) < 0.2))
        stuck, speed = mode == 0, rows @ u + drive
        assert np.abs(speed[stuck]).max(initial=0.0) < 1e-12
        assert (mode * speed)[~stuck].min() > -1e-12
        slope = matrix @ u - load + rows[~stuck].T @ (weight * mode)[~stuck]
        hold = np.linalg.lstsq(rows[stuck].T, -slope, rcond=None)[0]
        assert rows[stuck].T @ hold == pytest.approx(-slope, abs=1e-11)
        assert (np.abs(hold) - weight[stuck]).max(initial=-1.0) < 1e-11


def test_table_is_broad_and_says_how_good_it_is() -> None:
    assert len(ROWS) >= 8 + 15
    for _, _, row in ROWS:
        assert row["accuracy"] < 1e-6
        assert row["power_w"] == pytest.approx(row["dissipation_w"], rel=1e-6)
        # the second method's own estimate is an order of magnitude, not a bound
        assert row["other_method"] < max(20 * row["other_accuracy"], 1e-6)


@pytest.mark.parametrize("index", [9, pytest.param(19, marks=pytest.mark.slow)])
def test_rows_of_the_table(index: int) -> None:
    p, gait, row = ROWS[index]
    found = bingham_periodic.steady(p, gait, 1e-9, start_of(row))
    assert found.speed_m_s == pytest.approx(row["speed_m_s"], rel=1e-7)
    assert found.abs_power_w == pytest.approx(row["abs_power_w"], rel=1e-6)
