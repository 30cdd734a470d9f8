"""Speeds predicted from a fit: known values, known errors of the springs, an honest band."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
from robots import NIRAKH_2005, gait_in_deg
from serpenoid.prediction.band import speed_band


@pytest.fixture(scope="module")
def fit() -> sn.FrictionFit:
    return sn.fit_friction(sn.load_session(NIRAKH_2005))


def test_a_band_of_the_2005_robot(fit) -> None:
    too_fast = speed_band(fit, gait_in_deg(70, 75, 5.0))
    assert too_fast.speed_m_s < 0.133205  # of ideal joints
    assert np.isnan([too_fast.low_m_s, too_fast.high_m_s]).all()
    gait = gait_in_deg(70, 75, 4.0)
    moved, ideal = speed_band(fit, gait), speed_band(fit, gait, servo=None)
    assert (ideal.low_m_s, ideal.high_m_s) == (moved.low_joints_m_s, moved.high_joints_m_s)
    assert ideal.low_m_s < ideal.speed_m_s < ideal.high_m_s
    # servos take some of the speed, and add to the doubt
    assert moved.low_m_s < ideal.low_m_s
    assert moved.high_m_s < 1.01 * ideal.high_m_s


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
