"""Draws of what crawls leave against plain ones: points of what was known before, each weighed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import TRUTH, floor_setup
from scipy.special import ndtri
from scipy.stats import qmc
from serpenoid.calibration.crawls.data import CrawlData
from serpenoid.calibration.crawls.posterior import Before, Posterior, draw
from serpenoid.calibration.crawls.servos import ServoEffects
from serpenoid.calibration.friction_result import ground_of
from serpenoid.calibration.speed_samples import speed
from serpenoid.model.gait import Gait

ROBOT = floor_setup().robot
QUANTILES = (0.025, 0.5, 0.975)
CRAWLED = tuple(
    Gait(math.radians(a), math.radians(b), 2 * math.pi * f)
    for a, b, f in ((70, 60, 0.8), (80, 75, 0.45))
)


def plainly(posterior, before, points):
    """Return points all over what was known before, and the weight of each: no search at all."""
    sobol = qmc.Sobol(5, seed=1)  # pyright: ignore[reportCallIssue]
    u = ndtri(sobol.random(points))
    each = posterior.by_servo(u)
    weight = np.exp(each + 0.5 * np.sum(u**2, axis=1)[:, None])  # each has the prior in it
    return np.column_stack([np.log(before.whole(u)), before.amplitude(u)]), weight


def quantiles(values, weight):
    order = np.argsort(values)
    share = np.cumsum(weight[order]) / weight.sum()
    return values[order][np.searchsorted(share, QUANTILES)]


def check_alike(found, plain, weight, *, worst):
    """Hold every quantile against the plain one: draws of some 400 scatter by 0.1 to 0.15."""
    drawn = np.column_stack([np.log(found.whole), found.amplitude])
    total = weight.sum(axis=1)
    for k in range(5):
        want = quantiles(plain[:, k], total)
        sd = math.sqrt(np.cov(plain[:, k], aweights=total))
        assert np.quantile(drawn[:, k], QUANTILES) == pytest.approx(want, abs=worst * sd)
    shares = weight.sum(axis=0) / weight.sum()
    counted = np.bincount(found.servo, minlength=len(shares)) / len(found.servo)
    assert counted == pytest.approx(shares, abs=0.1)


def filmed(noise, seed):
    """Return films of two gaits, there and back, whose joints are off by noise; the true speeds."""
    rng = np.random.default_rng(seed)
    asked = [gait for gait in CRAWLED for _ in range(2)]
    gaits = tuple(
        replace(
            g,
            joint_gain=tuple(0.97 + noise * rng.normal(size=5)),
            joint_shift_rad=tuple(noise * rng.normal(size=5)),
        )
        for g in asked
    )
    ground = ground_of(ROBOT.links, TRUTH)
    true = np.array([speed(ROBOT, ground, replace(g, joint_gain=(0.97,) * 5)) for g in asked])
    return CrawlData(
        gaits,
        true,
        0.014 * true,
        np.ones(4, bool),
        ((1,),) * 4,
        tuple(asked),
        np.full(4, 0.97),
        np.full(4, 0.003),
        ((0.0, 0.0),) * 4,
    )


def one_by_one(data):
    """Return what solves for every film's speed by itself, from rest."""

    def speeds(whole, amplitude):
        grounds = [ground_of(ROBOT.links, w) for w in whole.tolist()]
        return np.array([[speed(ROBOT, ground, gait) for gait in data.gaits] for ground in grounds])

    return speeds


def pushed(correlated=0.6):
    """Return what pushes leave of the frictions, some per cent."""
    sigma = np.array([0.03, 0.025, 0.02, 0.02])
    along = np.full((4, 4), correlated) + (1 - correlated) * np.eye(4)
    root = np.linalg.cholesky(along * np.outer(sigma, sigma))
    return Before(np.log(TRUTH), np.asarray(root, dtype=np.float64), 0.03)


def test_films_of_one_gait_share_a_state_and_hardly_err() -> None:
    data, before = filmed(0.003, 2), pushed()
    u = np.random.default_rng(3).normal(size=(12, 5))
    whole, amplitude = before.whole(u), before.amplitude(u)
    solver = data.of_robot(ROBOT, np.exp(before.mean), before.narrow)
    off = np.log(solver(whole, amplitude) / one_by_one(data)(whole, amplitude))
    assert abs(off[:, :2].mean(axis=1)).max() < 1e-4  # a speed's own doubt is 1.4 %
    assert abs(off[:, 2:].mean(axis=1)).max() < 6e-4  # this gait is nearer to the cliff
    assert abs(off).max() < 1e-3
    far = data.of_robot(ROBOT, np.exp(before.mean), False)(whole[:3], amplitude[:3])
    np.testing.assert_allclose(far, one_by_one(data)(whole[:3], amplitude[:3]), rtol=1e-4)


def test_draws_about_one_minimum_are_the_plain_ones() -> None:
    """Real speeds, each film by itself from rest; 16 servos of which some are likely."""
    data, before = filmed(0.003, 5), pushed()
    shares = 1.0 - 0.04 * np.random.default_rng(6).random((16, 4))
    servos = ServoEffects((), shares, shares - 0.02, 0.01)
    exact = one_by_one(data)
    fast = data.of_robot(ROBOT, np.exp(before.mean), before.narrow)
    plain, weight = plainly(Posterior(data, before, exact, servos), before, 1024)
    assert weight.sum() ** 2 / (weight.sum(axis=1) ** 2).sum() > 60
    found = draw(Posterior(data, before, fast, servos), before, 1024, 7)
    check_alike(found, plain, weight, worst=0.45)
    assert found.effective > 300


@pytest.mark.parametrize("seed", [1, 2])
def test_draws_about_several_minima_are_the_plain_ones(seed) -> None:
    """Speeds with a cliff, and a valley that turns back: what crawls alone leave."""
    before = Before(np.log(TRUTH), 0.6 * np.eye(4), 0.03)
    gaits = CRAWLED * 3

    def cliff(whole, amplitude):
        logs = np.log(whole / TRUTH)
        way = 1.0 / (1.0 + np.exp(8.0 * (logs[:, 3] - logs[:, 2] - 0.8)))
        turn = (logs[:, 0] - 0.3) ** 2 - 0.5 * logs[:, 1]
        each = np.linspace(0.2, 1.0, 6)[:, None] * turn + np.outer([1, 0.5] * 3, logs[:, 2])
        return 0.2 * (way * np.exp(each)).T * amplitude[:, None]

    true = cliff(np.array([TRUTH]) * 1.1, np.ones(1))[0]
    data = CrawlData(gaits, true, 0.1 * true, np.zeros(6, bool), ((1,),) * 6)
    posterior = Posterior(data, before, cliff, ServoEffects.none(6, 0))
    plain, weight = plainly(posterior, before, 2**16)
    check_alike(draw(posterior, before, 1024, seed), plain, weight, worst=0.45)
