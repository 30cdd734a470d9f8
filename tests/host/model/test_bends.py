"""Balanced bends: what they promise, for any number of links."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused
from serpenoid.model.bends import balanced_signs


@pytest.mark.parametrize("links", range(4, 40))
def test_neither_a_side_force_nor_a_moment_is_left(links):
    signs = np.array(balanced_signs(links))
    places = 2.0 * np.arange(links) - (links - 1)  # of straight links, in half lengths
    assert len(signs) == links
    assert np.any(signs)
    assert signs.sum() == 0
    assert places @ signs == 0
    assert tuple(signs[::-1]) == tuple(signs)
    assert np.count_nonzero(signs == 0) < 4  # as many links as can be are bent


@pytest.mark.parametrize("links", [1, 2, 3])
def test_few_links_have_none(links):
    with refused(f"{links} links.*guide"):
        balanced_signs(links)
