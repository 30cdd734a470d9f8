"""Samples of a density: weighted points about its mode, and particles that go there."""

import numpy as np
import pytest
from serpenoid.base.particles import explored, points_about

CENTRE, ROOT = np.array([0.3, -0.2]), np.array([[1.2, 0.0], [0.4, 1.1]])


def normal(x, mean=0.0, sigma=1.0):
    """Return the logarithm of a normal density of independent parts, but for a constant."""
    return -np.sum(((x - mean) / sigma) ** 2 / 2, axis=1)


def test_points_about_a_mode_have_the_weights_of_another_density():
    x, log_about = points_about(CENTRE, ROOT, 0, 16384, np.random.default_rng(1))
    weight = np.exp(normal(x) - log_about)
    weight /= weight.sum()
    np.testing.assert_allclose(weight @ x, 0.0, atol=0.02)
    np.testing.assert_allclose(weight @ x**2, 1.0, atol=0.03)


def test_particles_that_begin_elsewhere_find_a_narrow_density():
    rng = np.random.default_rng(3)
    samples = explored(rng.normal(size=(512, 2)), lambda x: normal(x, 1.5, 0.2), 120, rng)
    x = np.concatenate(samples)
    assert x.mean() == pytest.approx(1.5, abs=0.02)
    assert x.std() == pytest.approx(0.2, rel=0.05)
