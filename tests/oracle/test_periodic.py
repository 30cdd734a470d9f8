"""The brute-force periodic states: published numbers, their own consistency, rows of the table."""

from __future__ import annotations

import numpy as np
import pytest

from . import body_frame as bf
from . import explicit, periodic
from . import generate_viscous as generate
from .params import Params, gait_deg

GAIT = gait_deg(30, 80, 5)
ROWS = generate.table()


@pytest.fixture(scope="module")
def six_links() -> periodic.Periodic:
    return periodic.steady(Params(6), GAIT)


@pytest.mark.parametrize("n", [2, 3, 6, 12, 50])
def test_body_frame_agrees_with_the_dense_model(n: int) -> None:
    """Three balance equations against 6n - 3 constrained ones, torques included."""
    rng = np.random.default_rng(n)
    p = Params(n, *rng.uniform(0.05, 2.0, 3), *rng.uniform(0.0, 5.0, 2))
    gait, t, u, heading = gait_deg(50, 70, 3, 10), 0.37, rng.normal(size=3), 0.8
    shape = bf.shape_at(p, gait, t)
    ground = bf.viscous(p, shape, u)
    rate = bf.u_dot(p, shape, u, ground)
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    rates = np.append(turn @ u[:2], u[2])
    motion = explicit.angle_driven(p, [0, 0, heading], rates, gait.angles(t, n - 1))
    accel = turn @ (rate[:2] + u[2] * bf.across(u[:2]))
    # the dense solve loses digits with n; the torques' scale is their own largest
    assert motion.accel_m_s2[0] == pytest.approx(accel, rel=1e-9, abs=1e-9)
    assert motion.theta_ddot[0] == pytest.approx(rate[2], rel=1e-9, abs=1e-9)
    torque = bf.joint_torques(p, shape, u, rate, ground)
    size = np.abs(torque).max()
    assert np.abs(motion.torque_n_m - torque).max() < 1e-12 * n**2 * size


def test_published_six_link_state(six_links: periodic.Periodic) -> None:
    # half a unit of each printed digit
    assert six_links.speed_m_s == pytest.approx(0.292060796024, abs=5e-13)
    assert six_links.power_w == pytest.approx(0.073312554830, abs=5e-13)
    assert six_links.abs_power_w == pytest.approx(0.5146735, abs=5e-8)
    assert six_links.positive_power_w == pytest.approx(0.2939930, abs=5e-8)
    assert abs(six_links.turn_rad_per_cycle) < 1e-12


def test_power_is_the_friction_loss(six_links: periodic.Periodic) -> None:
    assert six_links.power_w == pytest.approx(six_links.dissipation_w, rel=1e-12)
    assert six_links.fourier_tail < 1e-12


def test_half_a_period_later_is_the_mirror_image(six_links: periodic.Periodic) -> None:
    """The symmetry that the shooting did not use."""
    half = periodic.march(Params(6), GAIT, six_links.u0, 2)[1, :3]
    assert half * [1, -1, -1] == pytest.approx(six_links.u0, abs=1e-11)


def test_multipliers_are_the_decay_of_a_disturbance(six_links: periodic.Periodic) -> None:
    u0, decay = six_links.u0, abs(six_links.multipliers[0])
    disturbed = [periodic.march(Params(6), GAIT, np.add(u0, [0, 0, 1e-4]), 1)[-1, :3]]
    disturbed.append(periodic.march(Params(6), GAIT, disturbed[0], 1)[-1, :3])
    first, second = (np.abs(u - u0).max() for u in disturbed)
    # the second multiplier is 2e4 times smaller; the disturbance's own square is 1e-4 of it
    assert second / first == pytest.approx(decay, rel=1e-3)


def test_absolute_mean_between_roots() -> None:
    """|sin| has mean 2/pi; a constant, and a wave that never crosses zero, keep theirs."""
    phase = 2 * np.pi * np.arange(64) / 64
    columns = np.stack([np.sin(phase), 0 * phase - 3.0, 2 + np.cos(phase)], -1)
    net, total, tail = periodic.split_means(columns)
    assert net == pytest.approx(-1.0, abs=1e-14)
    assert total == pytest.approx(2 / np.pi + 3.0 + 2.0, rel=1e-14)
    assert tail < 1e-15


def test_mirrored_offset_mirrors_the_turn() -> None:
    left, right = (
        next(row for p, gait, row in ROWS if p.links == 6 and np.isclose(gait.offset_rad, offset))
        for offset in np.radians([5.0, -5.0])
    )
    assert left["turn_rad_per_cycle"] == pytest.approx(-right["turn_rad_per_cycle"], rel=1e-11)
    assert left["power_w"] == pytest.approx(right["power_w"], rel=1e-11)
    assert left["mean_speed_m_s"] == pytest.approx(right["mean_speed_m_s"], rel=1e-11)


def test_table_is_broad_and_tight() -> None:
    assert len(ROWS) >= 40
    assert {p.links for p, _, _ in ROWS} >= {2, 3, 4, 6, 9, 12, 20}
    assert max(row["speed_check_m_s"] for _, _, row in ROWS) < 1e-12
    assert max(row["fourier_tail"] for _, _, row in ROWS) < 1e-10


@pytest.mark.parametrize("index", [1, *(pytest.param(k, marks=pytest.mark.slow) for k in (29, 54))])
def test_rows_of_the_table(index: int) -> None:
    p, gait, row = ROWS[index]
    found = periodic.steady(p, gait)
    for name in generate.RESULTS[:7]:
        # 13 digits are written; the turn and the speed of a straight gait differ by rounding alone
        assert getattr(found, name) == pytest.approx(row[name], rel=1e-10, abs=1e-12)
