"""Crawls in the fit: draws against the exact answer, and what they may not tell."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import MASS, TRUTH, floor_setup, short_session
from refusals import refused
from robots import gait_in_deg
from serpenoid import fit_friction
from serpenoid.calibration.crawls.data import CrawlData
from serpenoid.calibration.crawls.posterior import Beforehand, CrawlPosterior
from serpenoid.calibration.fitting.posterior import Posterior
from serpenoid.calibration.fitting.shared import FRICTIONS
from serpenoid.calibration.friction_result import ground_of
from serpenoid.calibration.speeds import ServoEffects, SpeedModel, SpeedTable
from serpenoid.prediction import speed_samples
from serpenoid.prediction.speed_samples import sample_speeds
from serpenoid.session.gait_run import GaitRun
from simulated_sessions import MemoryRecord

GAITS = tuple(gait_in_deg(70, 60, math.pi * k) for k in (1, 2, 3, 4, 5, 6))
ONE_SERVO = ServoEffects((), np.ones((1, len(GAITS))), np.ones((1, 0)), 0.0)
RNG = np.random.default_rng(4)
BY_LOGS = RNG.normal(size=(len(GAITS), 4))
BY_AMPLITUDE = np.linspace(1.0, 2.0, len(GAITS))


def crawls(speed_m_s, sigma_m_s):
    return CrawlData(GAITS, np.asarray(speed_m_s), np.full(len(GAITS), sigma_m_s))


def even_powers(whole, amplitude):
    """Speeds whose logarithm is linear in all unknowns: the posterior is then normal."""
    return 50.0 * np.exp(
        np.log(whole / TRUTH) @ BY_LOGS.T + (amplitude - 1)[:, None] * BY_AMPLITUDE
    )


def drawn(sigmas, speeds, measured_m_s, sigma_m_s, seed):
    """Return what crawls leave of frictions that are known to these sigmas of a logarithm."""
    known = Beforehand(np.log(TRUTH), np.diag(sigmas))
    u = np.random.default_rng(seed).normal(size=(1024, 4))
    posterior = CrawlPosterior(
        Posterior((known,)), crawls(measured_m_s, sigma_m_s), SpeedTable(speeds), ONE_SERVO, 0.2
    )
    return posterior.draw(known.whole(u), seed)


def test_draws_are_the_normal_answer_where_there_is_one() -> None:
    off = np.array([0.3, -0.1, 0.2, 0.0, -0.2, 0.1])
    measured, sigma = 50.0 * np.exp(off), 5.0
    found = drawn([0.3] * 4, even_powers, measured, sigma, 3)
    whole, amplitude = found.posterior.whole(found.z), found.posterior.amplitude(found.z)
    slopes = np.column_stack([0.3 * BY_LOGS, 0.2 * BY_AMPLITUDE]) * (measured / sigma)[:, None]
    covariance = np.linalg.inv(slopes.T @ slopes + np.eye(5))
    mean = covariance @ slopes.T @ (off * measured / sigma)
    u = np.column_stack([np.log(whole / TRUTH) / 0.3, (amplitude - 1) / 0.2])
    sd = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(u.mean(axis=0), mean, atol=0.15 * sd.max())
    np.testing.assert_allclose(u.std(axis=0), sd, rtol=0.12)
    np.testing.assert_allclose(np.log(found.best_whole / TRUTH) / 0.3, mean[:4], atol=2e-2)


def test_two_minima_are_both_drawn_by_their_weight() -> None:
    """Speeds know only |log ct - 0.5|: half of the draws are at either side."""

    def folded(whole, amplitude):
        away = np.abs(np.log(whole[:, :1] / TRUTH[0]))
        return 50.0 * np.exp(np.tile(away, (1, len(GAITS))))

    found = drawn([1.0, 0.1, 0.1, 0.1], folded, 50.0 * np.exp(np.full(len(GAITS), 0.8)), 3.0, 1)
    logs = np.log(found.posterior.whole(found.z)[:, 0] / TRUTH[0])
    assert np.mean(logs > 0) == pytest.approx(0.5, abs=0.08)
    assert np.abs(logs).mean() == pytest.approx(0.8, abs=0.03)


def small_powers(whole, amplitude):
    """Speeds that hang on friction over mass alone, as every true one does."""
    return even_powers(whole, amplitude) / 500


SPEEDS = small_powers(np.array([TRUTH]), np.ones(1))[0]


def with_runs(session, speeds=SPEEDS, sigma=0.001):
    runs = tuple(
        GaitRun(900 + k, g.alpha_rad, g.beta_rad, g.omega_rad_s, float(v), sigma)
        for k, (g, v) in enumerate(zip(GAITS, speeds, strict=True))
    )
    return replace(session, gait_runs=runs)


@pytest.fixture
def crawls_fit(monkeypatch):
    """Return the fit with crawls, where speeds are small powers."""
    monkeypatch.setattr(
        SpeedModel, "ideal", lambda _, whole, amplitude, **__: small_powers(whole, amplitude)
    )
    return lambda session, **more: fit_friction(session, crawls=True, **more)


def holds_truth(fit):
    low, high = np.transpose(list(fit.intervals.values()))
    return np.all((low < TRUTH) & (high > TRUTH))


@pytest.fixture(scope="module")
def pushed():
    session = short_session()
    return with_runs(session)


def test_crawls_narrow_what_pushes_leave_but_never_the_mass(pushed, crawls_fit) -> None:
    heavy = replace(
        pushed,
        setup=replace(pushed.setup, uncertainty=replace(pushed.setup.uncertainty, mass_sigma=0.05)),
    )
    before, after = fit_friction(heavy), crawls_fit(heavy)
    assert holds_truth(after)
    for name, true in zip(FRICTIONS, TRUTH, strict=True):
        assert after.parameters[name].sigma < 1.03 * before.parameters[name].sigma
        assert after.parameters[name].sigma > 0.045 * true  # the mass alone
    ratio = [f.sample_whole(1024)[:, 0] / f.sample_whole(1024)[:, 3] for f in (before, after)]
    assert ratio[1].std() < 0.8 * ratio[0].std()
    assert "no test" in after.notes[0]


def test_a_misread_crawl_is_an_alarm_and_the_papers_lines_take_none(pushed, crawls_fit) -> None:
    first, *others = pushed.gait_runs
    wrong = replace(pushed, gait_runs=(replace(first, speed_m_s=1.4 * first.speed_m_s), *others))
    fit = crawls_fit(wrong)
    assert fit.p_value < 0.01
    assert "the crawls do not agree" in fit.alarms[0]
    with refused("not 'naive'"):
        fit_friction(pushed, method="naive", crawls=True)


def test_crawls_alone_say_that_they_tell_speeds_only(monkeypatch) -> None:
    monkeypatch.setattr(
        SpeedModel, "ideal", lambda _, whole, a, **__: small_powers(whole, a)[:, [0] * 6]
    )
    session = with_runs(MemoryRecord(floor_setup()).session, sigma=0.01)
    fit = fit_friction(session, crawls=True)
    assert "Speeds only" in fit.notes[0]
    assert fit.dof == len(GAITS)
    with refused("4 gaits at least"):
        fit_friction(replace(session, gait_runs=session.gait_runs[:2]), crawls=True)


def test_predictions_take_the_amplitude_that_crawls_told(pushed, crawls_fit, monkeypatch) -> None:
    """Draws of the amplitude go with their frictions: what they add hangs on them alone.

    Beside what the model leaves out, 1 % of each speed.
    """
    fit = crawls_fit(pushed)
    gait = gait_in_deg(70, 75, math.pi)
    more = sample_speeds(fit, [gait], amplitude_sigma=0.03, count=256).joints_m_s
    monkeypatch.setattr(speed_samples, "MODEL_SIGMA", 0.0)
    less = sample_speeds(fit, [gait], amplitude_sigma=0.03, count=256).joints_m_s
    assert np.std(more / less) == pytest.approx(0.015, rel=0.2)
    drawn = sample_speeds(fit, [gait], amplitude_sigma=0.03, count=32)
    added = (drawn.joints_m_s / drawn.friction_m_s)[:, 0] - 1.0
    assert abs(np.corrcoef(added, fit.sample_amplitudes(32) - 1.0)[0, 1]) > 0.9


def test_real_speeds_tell_the_amplitude() -> None:
    """Crawls by the package's own solver: joints at 94 % of their amplitude are found."""
    session = short_session()
    robot = session.setup.robot
    model = SpeedModel(robot, ground_of(robot.links, TRUTH), GAITS[:2], (None, None))
    assert robot.links * robot.link_mass_kg == pytest.approx(MASS)
    slow = model.ideal(np.array([TRUTH]), np.array([0.94]))[0]
    session = replace(session, gait_runs=with_runs(session, np.resize(slow, 6)).gait_runs[:2])
    fit = fit_friction(session, crawls=True)
    amplitude = fit.nuisances["joint_amplitude"]
    assert amplitude.value == pytest.approx(0.94, abs=2.5 * amplitude.sigma)
    assert amplitude.sigma < 0.025
    assert fit.method == "joint, with crawls"
