"""Speeds predicted from a fit: known values, known errors of the springs, an honest band."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
from robots import NIRAKH_2005, PAPER, VISCOUS, gait_in_deg
from serpenoid.prediction.predict import one_cycle, predict


@pytest.fixture(scope="module")
def fit() -> sn.FrictionFit:
    return sn.fit_friction(sn.load_session(NIRAKH_2005))


def test_speed_of_the_2005_robot(fit) -> None:
    quick = predict(fit.robot, fit, gait_in_deg(70, 75, 5.0))
    assert quick.explicit_m_s == pytest.approx(0.133205, rel=2e-4)
    assert quick.explicit_error_m_s < 1e-6
    assert np.isnan([quick.low_m_s, quick.high_m_s]).all()  # too fast for servos
    gait = gait_in_deg(70, 75, 4.0)
    point = predict(fit.robot, fit, gait)
    assert point.low_ideal_m_s < point.explicit_m_s < point.high_ideal_m_s
    # servos take some of the speed, and add to the doubt
    assert point.low_m_s < point.low_ideal_m_s
    assert point.high_m_s < 1.01 * point.high_ideal_m_s
    state = sn.steady_gait(fit.robot, fit.ground, gait, powers=False)
    stated = state.error_estimate * state.speed_m_s  # a speed, not a share
    assert point.explicit_error_m_s == pytest.approx(stated, rel=1e-6)
    ideal = predict(fit.robot, fit, gait, servo=None)
    assert (ideal.low_m_s, ideal.high_m_s) == (point.low_ideal_m_s, point.high_ideal_m_s)
    # asking for more must move the speed by no more than the error that is stated
    finer = sn.steady_springs(fit.robot, fit.ground, gait, rtol=1e-5)
    assert abs(finer.speed_m_s - point.implicit_m_s) <= point.implicit_error_m_s


def test_samples_follow_the_fit_and_stay_physical(fit) -> None:
    samples = fit.sample_whole(1024)
    assert np.array_equal(samples, fit.sample_whole(1024))
    assert samples.min() > 0
    assert not np.array_equal(fit.sample_whole(8), fit.sample_whole(8, seed=1))
    whole = sn.Ground.whole_body(6, *samples[7])
    assert fit.sample(1024)[7] == whole
    sigmas = np.sqrt(np.diag(fit.covariance))
    centre = [p.value for p in fit.parameters.values()]
    # the likeliest values are not the middle of draws that are skewed
    assert np.abs((np.median(samples, axis=0) - centre) / sigmas).max() < 0.25
    ends = np.array(list(fit.intervals.values()))
    held = np.mean((samples >= ends[:, 0]) & (samples <= ends[:, 1]), axis=0)
    assert held == pytest.approx(0.95, abs=0.02)
    assert samples.std(axis=0) == pytest.approx(sigmas, rel=0.1)  # 256 samples
    assert np.corrcoef(samples.T) == pytest.approx(
        fit.covariance / np.outer(sigmas, sigmas), abs=0.05
    )


def test_mean_speed_over_a_cycle_is_the_periodic_states() -> None:
    gait = gait_in_deg(30, 80, 5.0)
    state, run = one_cycle(PAPER, VISCOUS, gait)
    # 600 steps of RK4 a period, 120 of them recorded
    speeds = run.mean_speed_m_s(gait.period_s)[::120]
    assert speeds == pytest.approx([state.speed_m_s] * 3, rel=1e-6)
