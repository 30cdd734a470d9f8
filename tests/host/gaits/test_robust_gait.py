"""Gaits that survive being wrong: margins, samples, and runs in time of perturbed robots."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from serpenoid.gaits import sampled_speeds as spread

D = math.pi / 180
PAPER, VISCOUS = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
OF_2005, BINGHAM = sn.Robot(6, 0.0756, 0.076), sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
FRAGILE, STURDY = sn.Gait(66.7 * D, 78.8 * D, 1.6), sn.Gait(80 * D, 75 * D, 1.75)


def run_speed(robot: sn.Robot, ground: sn.Ground, gait: sn.Gait, cycles: int = 12) -> float:
    """Return the speed of the last cycle of a run from rest, m/s: no periodic solver in it."""
    run = sn.simulate(
        sn.Scene(
            robot,
            ground,
            gait,
            start="zero_momentum",
            record_every=400,
            method="nonsmooth" if ground.dry else "rk4",
            dt_s=gait.period_s / 400,
            duration_s=cycles * gait.period_s,
        )
    )
    x, y = run.x_m.mean(axis=1)[-2:], run.y_m.mean(axis=1)[-2:]
    return math.hypot(x[1] - x[0], y[1] - y[0]) / gait.period_s


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


def test_a_margin_is_where_runs_in_time_have_lost_a_tenth() -> None:
    margins = sn.gait_margins(OF_2005, BINGHAM, FRAGILE)
    full = run_speed(OF_2005, BINGHAM, FRAGILE)
    weak = replace(FRAGILE, alpha_rad=(1 - margins.amplitude) * FRAGILE.alpha_rad)
    assert run_speed(OF_2005, BINGHAM, weak) == pytest.approx(0.9 * full, rel=0.02)
    loose = replace(BINGHAM, fn0=(1 - margins.grip) * BINGHAM.fn0)
    assert run_speed(OF_2005, loose, FRAGILE) == pytest.approx(0.9 * full, rel=0.02)


def test_viscous_ground_has_no_cliff() -> None:
    margins = sn.gait_margins(PAPER, VISCOUS, sn.Gait(30 * D, 80 * D, 5.0))
    assert not margins.near_cliff
    assert math.isnan(margins.grip)


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


def test_low_speed_is_the_quantile_of_all_from_the_slowest() -> None:
    speeds = np.random.default_rng(1).normal(size=64)
    assert spread.low_speed(np.sort(speeds)[:20], 64) == pytest.approx(np.quantile(speeds, 0.05))


def test_the_smoothed_quantile_scatters_less_and_its_error_is_known() -> None:
    """Of skewed samples, as at a cliff: both estimates are right on average, their spread told."""
    rng = np.random.default_rng(5)
    sets = [np.exp(-0.1 * rng.exponential(size=1024)) for _ in range(300)]
    plain = np.array([spread.low_speed(s, 1024) for s in sets])
    smooth = np.array([spread.smooth_low_speed(np.sort(s)[:128], 1024) for s in sets])
    truth = 0.05**0.1
    assert plain.mean() == pytest.approx(truth, rel=2e-3)
    assert smooth.mean() == pytest.approx(truth, rel=2e-3)
    assert smooth.std() < 0.97 * plain.std()
    assert np.mean([spread.low_speed_error(s) for s in sets]) == pytest.approx(
        plain.std(), rel=0.15
    )


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
        speeds = spread.sampled_speeds(PAPER, best.gait, robots)
        assert low == pytest.approx(np.quantile(speeds, 0.05), rel=1e-9)
    for k in np.argsort(best.speeds_m_s)[[0, 3, 40]]:
        sample = drawn[k]
        by_time = run_speed(PAPER, sample.ground, sample.gait(best.gait), cycles=25)
        assert by_time == pytest.approx(best.speeds_m_s[k], rel=3e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "bend", "most"),
    [(0.05, 7.5, 0.27), (0.1, 7.5, 0.31), (0.05, 30, 0.25), (0.1, 30, 0.25)],
)
def test_robust_2005_robot(speed: float, bend: float, most: float) -> None:
    """Little more power, less where friction is known better; both faults together are borne."""
    friction = (0.06, 0.35, 0.06, 0.13) if bend == 7.5 else (0.06, 0.036, 0.06, 0.033)
    best = sn.robust_gait(
        OF_2005, BINGHAM, speed_m_s=speed, uncertainty=sn.Uncertainty(friction=friction)
    )
    assert best.premium < most
    assert best.low_speed_m_s > 0.899 * speed
    assert abs(best.checked_low_m_s - best.low_speed_m_s) < 3 * best.low_error_m_s
    assert best.checked_low_m_s != best.low_speed_m_s  # other samples
    assert best.low_error_m_s < 0.012 * speed
    assert best.fragile_low_m_s < best.low_speed_m_s
    if bend != 7.5:
        return
    weak = replace(best.gait, alpha_rad=0.9 * best.gait.alpha_rad)
    loose = replace(BINGHAM, fn0=0.87 * BINGHAM.fn0)
    assert run_speed(OF_2005, loose, weak) > 0.85 * speed
    fragile = best.fragile.gait
    less = replace(fragile, alpha_rad=0.9 * fragile.alpha_rad)
    assert run_speed(OF_2005, loose, less) < 0.6 * speed
    drawn = best.uncertainty.samples(OF_2005, BINGHAM, best.speeds_m_s.size)
    for k in np.argsort(best.speeds_m_s)[[0, 2, 30]]:
        by_time = run_speed(OF_2005, drawn[k].ground, drawn[k].gait(best.gait))
        assert by_time == pytest.approx(best.speeds_m_s[k], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.05, 0.1])
def test_no_shape_around_a_robust_gait_costs_less(speed: float) -> None:
    """Brute force, all samples, no smoothing: what 25 and 30 % more power buy costs no less."""
    best = sn.robust_gait(OF_2005, BINGHAM, speed_m_s=speed)
    drawn = sn.Uncertainty().samples(OF_2005, BINGHAM, best.speeds_m_s.size)
    for a, b in ((-2, 0), (2, 0), (0, -3), (0, 3)):
        gait = replace(
            best.gait, alpha_rad=best.gait.alpha_rad + a * D, beta_rad=best.gait.beta_rad + b * D
        )
        slowest = np.argsort(spread.sampled_speeds(OF_2005, gait, drawn))[:300]
        low, high = 0.8 * gait.omega_rad_s, 1.3 * gait.omega_rad_s
        for _ in range(7):
            rate = math.sqrt(low * high)
            speeds = spread.sampled_speeds(
                OF_2005, replace(gait, omega_rad_s=rate), [drawn[i] for i in slowest]
            )
            slow = spread.low_speed(speeds, len(drawn)) < 0.9 * speed
            low, high = (rate, high) if slow else (low, rate)
        state = sn.steady_gait(OF_2005, BINGHAM, replace(gait, omega_rad_s=high), rtol=1e-4)
        assert state.power_w > 0.985 * best.power_w


def test_samples_agree_with_the_solver_one_by_one() -> None:
    drawn = sn.Uncertainty().samples(OF_2005, BINGHAM, 4)
    speeds = spread.sampled_speeds(OF_2005, STURDY, drawn)
    by_time = [run_speed(OF_2005, s.ground, s.gait(STURDY)) for s in drawn]
    assert speeds == pytest.approx(by_time, rel=0.01)


def test_a_table_of_servos_stands_for_each_robots_own() -> None:
    """Shares on the nominal ground, by rough steps, against each robot solved with its servo."""
    drawn = sn.Uncertainty(servo=sn.servo()).samples(OF_2005, BINGHAM, 32)
    assert len({s.servo for s in drawn}) == 32
    gait = replace(STURDY, omega_rad_s=4.0)
    table = spread.sampled_speeds(OF_2005, gait, drawn, spread.ServoShares(OF_2005, BINGHAM))
    own = spread.driven_speeds(OF_2005, gait, drawn)
    ideal = spread.sampled_speeds(OF_2005, gait, drawn)
    assert np.median(np.abs(table / own - 1)) < 0.06
    assert np.quantile(table, 0.1) == pytest.approx(np.quantile(own, 0.1), rel=0.1)
    assert np.median(np.abs(ideal / own - 1)) > 0.1  # or the test could not fail


def test_a_robust_gait_survives_a_servo_that_shakes() -> None:
    """One known servo without a rotor: the gait costs more, and keeps the speed with it."""
    shaking = sn.ServoKind("no rotor", sn.Servo())
    known = {"friction": (0.01, 0.01, 0.01, 0.01), "amplitude": 0.01, "common_amplitude": 0.01}
    plain, best = (
        sn.robust_gait(
            OF_2005,
            BINGHAM,
            speed_m_s=0.05,
            samples=32,
            uncertainty=sn.Uncertainty(**known, servo=servo),
        )
        for servo in (None, shaking)
    )
    robots = best.uncertainty.samples(OF_2005, BINGHAM, 16, seed=1)
    assert spread.driven_speeds(OF_2005, best.gait, robots).min() > 0.87 * 0.05
    assert spread.driven_speeds(OF_2005, plain.gait, robots).max() < 0.87 * 0.05
    assert best.power_w > plain.power_w
    assert best.checked_low_m_s == pytest.approx(0.045, rel=0.06)
    assert "servos: no rotor" in best.uncertainty.in_words()


def test_refusals() -> None:
    with pytest.raises(sn.BadInput, match="amplitude is 3"):
        sn.Uncertainty(amplitude=3.0)
    with pytest.raises(sn.BadInput, match="four sigmas"):
        sn.Uncertainty(friction=(0.1, 0.1))  # pyright: ignore[reportArgumentType]
    with pytest.raises(sn.BadInput, match="samples is 3"):
        sn.robust_gait(PAPER, VISCOUS, speed_m_s=0.1, samples=3)


def test_the_check_draws_frictions_that_chose_nothing() -> None:
    grounds = tuple(sn.Ground(0.01 + 1e-4 * k, 0.2) for k in range(64))
    stated = sn.Uncertainty(grounds=grounds)
    chose = {s.ground for s in stated.samples(OF_2005, BINGHAM, 32)}
    check = {s.ground for s in stated.samples(OF_2005, BINGHAM, 32, seed=1, skip=32)}
    assert chose | check == set(grounds)
    assert not chose & check


@pytest.mark.parametrize("gait", [FRAGILE, STURDY])
def test_the_percentile_needs_only_the_samples_near_it(gait: sn.Gait) -> None:
    """A fit that starts 256 samples leaves their percentile as it is when each is solved alone."""
    drawn = sn.Uncertainty().samples(OF_2005, BINGHAM, 256)
    full = [
        sn.steady_gait(OF_2005, one.ground, one.gait(gait), rtol=1e-5, powers=False).speed_m_s
        for one in drawn
    ]
    robots, everyone = spread.SampledSpeeds(OF_2005, drawn), np.arange(256)
    seen = robots.near_percentile(gait, everyone, spread.percentile_rank(256))
    assert spread.low_speed(seen, 256) == pytest.approx(
        spread.low_speed(np.array(full), 256), rel=3e-3
    )
    assert robots.rough(gait, everyone) == pytest.approx(np.array(full), rel=0.05)
    assert robots.solved < 2.5 * 256  # all roughly, twice, and some more finely


def test_samples_that_are_followed_have_the_percentile_of_all() -> None:
    """From shape to shape near a cliff, against every sample solved; few of them were."""
    drawn = sn.Uncertainty().samples(OF_2005, BINGHAM, 1024)
    robots, everyone = spread.SampledSpeeds(OF_2005, drawn), np.arange(1024)
    slow = np.argsort(robots.rough(STURDY, everyone))[:170]
    followed = spread.FollowedSamples(robots, slow, 1024)
    followed.low(STURDY)
    before, off = robots.solved, []
    for alpha, beta, rate in (
        (-2, 0, 1.0),
        (0, 3, 1.1),
        (3, -2, 1.0),
        (-4, 2, 1.15),
        (-1, 1, 1.05),
    ):
        gait = sn.Gait(
            STURDY.alpha_rad + alpha * D, STURDY.beta_rad + beta * D, rate * STURDY.omega_rad_s
        )
        full = spread.sampled_speeds(OF_2005, gait, [drawn[i] for i in slow])
        off.append(followed.low(gait) / spread.smooth_low_speed(full, 1024) - 1)
    assert np.abs(off).max() < 2e-3
    assert robots.solved - before < 0.8 * 5 * slow.size


def test_a_fit_tells_where_other_samples_begin() -> None:
    """States solved from where others lead to expect them are near that, and as solved alone."""
    stated, everyone = sn.Uncertainty(), np.arange(64)
    seen = spread.SampledSpeeds(OF_2005, stated.samples(OF_2005, BINGHAM, 512))
    seen.rough(STURDY, np.arange(512))
    others = stated.samples(OF_2005, BINGHAM, 64, seed=9)
    led, alone = (spread.SampledSpeeds(OF_2005, others, like=like) for like in (seen, None))
    begun = led.begin(everyone)
    assert begun is not None
    assert alone.begin(everyone) is None
    speeds = [robots.rough(STURDY, everyone) for robots in (led, alone)]
    assert speeds[0] == pytest.approx(speeds[1], rel=0.03)
    assert np.median(np.abs(speeds[0] / speeds[1] - 1)) < 5e-4
    assert (np.std(begun - led.starts, axis=0) < 0.6 * np.std(led.starts, axis=0)).all()


def test_without_doubt_robustness_costs_nothing() -> None:
    """All samples are the same robot: no trait tells them apart, and none is slower."""
    known = sn.Uncertainty(friction=(0, 0, 0, 0), amplitude=0, common_amplitude=0, lag_rad=0)
    best = sn.robust_gait(OF_2005, BINGHAM, speed_m_s=0.05, uncertainty=known, samples=64)
    assert best.premium == pytest.approx(0, abs=5e-3)
    assert best.speeds_m_s == pytest.approx(np.full(64, 0.05), rel=2e-3)
    assert best.checked_low_m_s == pytest.approx(0.05, rel=2e-3)


def test_rough_speeds_on_viscous_ground_are_exact() -> None:
    drawn = sn.Uncertainty().samples(PAPER, VISCOUS, 32)
    seen = spread.SampledSpeeds(PAPER, drawn).rough(STURDY, np.arange(32))
    assert seen == pytest.approx(spread.sampled_speeds(PAPER, STURDY, drawn), rel=1e-12)


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
