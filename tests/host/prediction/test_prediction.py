"""Samples of a fit: they follow its values, intervals and correlations, and are positive."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
from robots import NIRAKH_2005


@pytest.fixture(scope="module")
def fit() -> sn.FrictionFit:
    return sn.fit_friction(sn.load_session(NIRAKH_2005))


def test_samples_follow_the_fit_and_are_positive(fit) -> None:
    samples = fit.sample_whole(1024)
    assert np.array_equal(samples, fit.sample_whole(1024))
    assert samples.min() > 0
    assert not np.array_equal(fit.sample_whole(8), fit.sample_whole(8, seed=1))
    whole = sn.Ground.whole_body(6, *samples[7])
    assert fit.sample(1024)[7] == whole
    sigmas = np.sqrt(np.diag(fit.covariance))
    centre = [p.value for p in fit.parameters.values()]
    # The MAP estimate is not the median of a skewed distribution.
    assert np.abs((np.median(samples, axis=0) - centre) / sigmas).max() < 0.25
    ends = np.array(list(fit.intervals.values()))
    coverage = np.mean((samples >= ends[:, 0]) & (samples <= ends[:, 1]), axis=0)
    assert coverage == pytest.approx(0.95, abs=0.02)
    assert samples.std(axis=0) == pytest.approx(sigmas, rel=0.1)
    assert np.corrcoef(samples.T) == pytest.approx(
        fit.covariance / np.outer(sigmas, sigmas), abs=0.05
    )
