"""Gaits that survive being wrong: margins, samples, and runs in time of perturbed robots."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from gaits.robots import run_speed
from refusals import refused
from robots import BINGHAM, OF_2005, PAPER, VISCOUS
from serpenoid.periodic.servo_steady import servo_speeds

D = math.pi / 180
FRAGILE, STURDY = sn.Gait(66.7 * D, 78.8 * D, 1.6), sn.Gait(80 * D, 75 * D, 1.75)


def speeds_of(robot: sn.Robot, gait: sn.Gait, samples: list) -> np.ndarray:
    """Return the speed of each sampled robot with its servo, m/s, solved one by one."""
    ideal = [
        sn.steady_gait(robot, one.ground, one.gait(gait), rtol=1e-5, powers=False)
        for one in samples
    ]
    if samples[0].servo is not None:
        pairs = [(state, one.servo) for state, one in zip(ideal, samples, strict=True)]
        return np.nan_to_num(servo_speeds(pairs))
    return np.array([state.speed_m_s for state in ideal])


def test_the_gait_beside_the_cliff_is_told_from_the_one_that_survives() -> None:
    fragile = sn.gait_margins(OF_2005, BINGHAM, FRAGILE)
    sturdy = sn.gait_margins(OF_2005, BINGHAM, STURDY)
    assert fragile.near_cliff
    assert not sturdy.near_cliff
    assert fragile.amplitude_loss == pytest.approx(0.45, abs=0.03)
    assert fragile.grip_loss == pytest.approx(0.50, abs=0.03)
    assert fragile.amplitude < 0.06
    assert sturdy.amplitude > 0.2
    assert "10 % less amplitude costs 44 %" in fragile.warning
    assert sturdy.warning == ""


@pytest.mark.parametrize(
    ("robot", "ground", "gait"),
    [
        (PAPER, VISCOUS, sn.Gait(30 * D, 0.0, 5.0)),
        (PAPER, VISCOUS, sn.Gait(0.0, 80 * D, 5.0)),
        (PAPER, sn.Ground(1.0, 1.0), sn.Gait(30 * D, 80 * D, 5.0)),
        (sn.Robot(2, 0.1, 0.1), BINGHAM, sn.Gait(60 * D, 75 * D, 3.14)),
    ],
    ids=["standing wave", "no amplitude", "isotropic", "two links"],
)
def test_a_gait_that_does_not_travel_has_no_margins(robot, ground, gait) -> None:
    margins = sn.gait_margins(robot, ground, gait)
    assert not margins.travels
    assert not margins.near_cliff
    assert margins.warning == "this gait does not travel: there is no speed to lose"


def test_a_gait_below_the_cliff_is_told_what_it_misses() -> None:
    """At 40 deg the wheels hardly let go; a small viscous gait is slow, but no cliff is near."""
    stuck = sn.gait_margins(OF_2005, BINGHAM, sn.Gait(40 * D, 75 * D, 1.57))
    assert stuck.below_cliff
    more = sn.steady_gait(OF_2005, BINGHAM, sn.Gait(64 * D, 75 * D, 1.57), rtol=1e-3).speed_m_s
    now = sn.steady_gait(OF_2005, BINGHAM, sn.Gait(40 * D, 75 * D, 1.57), rtol=1e-3).speed_m_s
    assert stuck.far_gain == pytest.approx(more / now - 1, rel=0.01)
    assert "this gait is below a cliff" in stuck.warning
    tiny = sn.gait_margins(PAPER, VISCOUS, sn.Gait(2 * D, 80 * D, 5.0))
    assert not tiny.below_cliff
    assert math.isnan(tiny.grip)
    assert tiny.warning == ""


def test_the_mirror_and_the_reverse_of_a_gait_have_its_margins() -> None:
    one = sn.gait_margins(OF_2005, BINGHAM, STURDY)
    back = sn.gait_margins(OF_2005, BINGHAM, replace(STURDY, beta_rad=-STURDY.beta_rad))
    assert back.amplitude == pytest.approx(one.amplitude, rel=0.02)
    assert back.grip == pytest.approx(one.grip, rel=0.02)
    turning = sn.gait_margins(OF_2005, BINGHAM, replace(STURDY, offset_rad=5 * D))
    assert 0.05 < turning.amplitude < 0.6


def test_samples_are_the_robots_that_were_stated() -> None:
    stated = sn.Uncertainty(
        friction=(0.1, 0.2, 0.0, 0.3), amplitude=0.02, common_amplitude=0.05, lag_rad=0.03
    )
    drawn = stated.samples(OF_2005, BINGHAM, 1024)
    logs = np.log([[s.ground.ct, s.ground.cn, s.ground.fn0] for s in drawn])
    assert logs.std(axis=0) == pytest.approx([0.1, 0.2, 0.3], rel=0.05)
    assert [s.ground.ft0 for s in drawn] == pytest.approx([BINGHAM.ft0] * 1024)
    gains = np.array([s.joint_gain for s in drawn])
    shifts = np.array([s.joint_shift_rad for s in drawn])
    assert gains.mean(axis=1).std() == pytest.approx(math.hypot(0.05, 0.02 / 5**0.5), rel=0.05)
    assert (gains - gains.mean(axis=1, keepdims=True)).std() == pytest.approx(
        0.02 * 0.8**0.5, rel=0.05
    )
    assert shifts.std(axis=0) == pytest.approx([0.03] * 5, rel=0.05)
    assert drawn == stated.samples(OF_2005, BINGHAM, 1024)
    assert drawn != stated.samples(OF_2005, BINGHAM, 1024, seed=1)


def test_grounds_of_a_fit_are_used_as_they_are() -> None:
    grounds = (sn.Ground(0.01, 0.2, 0.02, 0.04), sn.Ground(0.02, 0.3, 0.01, 0.05))
    drawn = sn.Uncertainty(grounds=grounds).samples(OF_2005, BINGHAM, 32)
    assert {s.ground for s in drawn} == set(grounds)


def test_robust_on_viscous_ground_by_runs_in_time() -> None:
    stated = sn.Uncertainty(friction=(0.1, 0.3, 0, 0), amplitude=0.05, common_amplitude=0.08)
    best = sn.robust_gait(PAPER, VISCOUS, speed_m_s=0.2, uncertainty=stated)
    assert best.low_speed_m_s == pytest.approx(0.18, rel=0.01)
    assert best.speed_m_s >= 0.2 * 0.999
    assert best.fragile_low_m_s < best.low_speed_m_s
    assert 0 < best.premium < 0.6
    drawn = stated.samples(PAPER, VISCOUS, best.speeds_m_s.size)
    others = stated.samples(PAPER, VISCOUS, best.speeds_m_s.size, seed=2006)  # the next seed
    for low, robots in ((best.low_speed_m_s, drawn), (best.checked_low_m_s, others)):
        speeds = speeds_of(PAPER, best.gait, robots)
        assert low == pytest.approx(np.quantile(speeds, 0.05), rel=1e-3)
    for k in np.argsort(best.speeds_m_s)[[0, 3, 40]]:
        sample = drawn[k]
        by_time = run_speed(PAPER, sample.ground, sample.gait(best.gait), cycles=25)
        assert by_time == pytest.approx(best.speeds_m_s[k], rel=3e-3)


def test_refusals() -> None:
    with refused("amplitude is 3"):
        sn.Uncertainty(amplitude=3.0)
    for sigmas in ((0.1, 0.1), 0.1):
        with refused("four sigmas"):
            sn.Uncertainty(friction=sigmas)  # pyright: ignore[reportArgumentType]
    with refused("samples is 3"):
        sn.robust_gait(PAPER, VISCOUS, speed_m_s=0.1, samples=3)


def test_the_check_draws_frictions_that_chose_nothing() -> None:
    grounds = tuple(sn.Ground(0.01 + 1e-4 * k, 0.2) for k in range(64))
    stated = sn.Uncertainty(grounds=grounds)
    chose = {s.ground for s in stated.samples(OF_2005, BINGHAM, 32)}
    check = {s.ground for s in stated.samples(OF_2005, BINGHAM, 32, seed=1, skip=32)}
    assert chose | check == set(grounds)
    assert not chose & check


def test_without_doubt_robustness_costs_nothing() -> None:
    """All samples are the same robot: no trait tells them apart, and none is slower."""
    known = sn.Uncertainty(friction=(0, 0, 0, 0), amplitude=0, common_amplitude=0, lag_rad=0)
    best = sn.robust_gait(OF_2005, BINGHAM, speed_m_s=0.05, uncertainty=known, samples=64)
    assert best.premium == pytest.approx(0, abs=5e-3)
    assert best.speeds_m_s == pytest.approx(np.full(64, 0.05), rel=2e-3)
    assert best.checked_low_m_s == pytest.approx(0.05, rel=2e-3)


@pytest.mark.slow
def test_a_robust_gait_survives_robots_drawn_and_solved_elsewhere() -> None:
    """A plain loop: robots drawn by NumPy, each solved alone from rest, no fit between them."""
    best = sn.robust_gait(OF_2005, BINGHAM, speed_m_s=0.1, samples=1024)
    rng, count = np.random.default_rng(77), 1500
    mix = [[1, -0.65, -0.32, 0.58], [-0.65, 1, 0.21, -0.57], [-0.32, 0.21, 1, -0.21]]
    mix = np.array([*mix, [0.58, -0.57, -0.21, 1]])
    friction = rng.multivariate_normal(np.zeros(4), mix, count) * [0.06, 0.35, 0.06, 0.13]
    common = 0.03 * rng.normal(size=(count, 1))
    gains = 1 + common + 0.02 * rng.normal(size=(count, 5))
    shifts = math.radians(1.0) * rng.normal(size=(count, 5))
    speeds = []
    for row, gain, shift in zip(np.exp(friction), gains.tolist(), shifts.tolist(), strict=True):
        gait = replace(best.gait, joint_gain=tuple(gain), joint_shift_rad=tuple(shift))
        ground = sn.Ground(*(np.array([BINGHAM.ct, BINGHAM.cn, BINGHAM.ft0, BINGHAM.fn0]) * row))
        speeds.append(sn.steady_gait(OF_2005, ground, gait, rtol=1e-4, powers=False).speed_m_s)
    order = np.sort(speeds)
    low, spread_ranks = 0.05 * count, math.sqrt(count * 0.05 * 0.95)
    noise = (order[int(low + spread_ranks)] - order[int(low - spread_ranks)]) / 2
    assert noise < 0.01 * best.checked_low_m_s
    assert order[int(low)] == pytest.approx(best.checked_low_m_s, abs=4 * noise)
    assert order[int(low)] > 0.09 - 4 * noise
    assert np.median(order) > 1.04 * order[int(low)]


def test_samples_that_chance_tells_apart_are_confirmed() -> None:
    """Two sets scatter by the square root of 2 times the error of one: 4.4 are 3.1 sigma."""
    robust = sn.robust_gait(PAPER, VISCOUS, speed_m_s=0.1, samples=64)
    low, error = robust.low_speed_m_s, robust.low_error_m_s
    apart = [replace(robust, checked_low_m_s=low - k * error).confirmed for k in (0, 3.1, 4.4)]
    assert apart == [True, True, False]
