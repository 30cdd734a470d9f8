"""Draws of a density: by points about its mode, and by particles that go there."""

import numpy as np
import pytest
from serpenoid.base.particles import Student, tempered

CENTRE, ROOT = np.array([0.3, -0.2]), np.array([[1.2, 0.0], [0.4, 1.1]])


def normal(x, mean=0.0, sigma=1.0):
    """Return the logarithm of a normal density of independent parts."""
    return -np.sum(((x - mean) / sigma) ** 2 / 2 + np.log(sigma * np.sqrt(2 * np.pi)), axis=1)


def test_points_about_a_centre_follow_their_density():
    about = Student(CENTRE, ROOT)
    x = about.points(4096, 1)
    weight = np.exp(normal(x) - about.log_density(x))
    assert weight.mean() == pytest.approx(1.0, abs=0.02)
    assert weight @ x[:, 0] ** 2 / len(x) == pytest.approx(1.0, abs=0.04)


def test_particles_find_the_product_of_two_normal_densities_and_its_integral():
    """Of N(0, 1) and a likelihood N(1.5, 0.2): mean 1.44, integral N(1.5; 0, 1.02)."""
    rng = np.random.default_rng(3)
    x, evidence = tempered(
        rng.normal(size=(1024, 2)), normal, lambda x: normal(x, 1.5, 0.2), rng, moves=10
    )
    np.testing.assert_allclose(x.mean(axis=0), 1.5 / 1.04, atol=0.03)
    np.testing.assert_allclose(x.std(axis=0), 0.2 / np.sqrt(1.04), rtol=0.12)
    told = normal(np.full((1, 2), 1.5), sigma=np.sqrt(1.04))[0]
    assert evidence == pytest.approx(told, abs=0.2)
