"""Balanced bends: what they promise, for any number of links, and what PROTOCOL.md says of them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from serpenoid.model.bends import balanced_signs, joint_multiples
from serpenoid.model.errors import BadInput

PAGE = (Path(__file__).parents[3] / "firmware" / "PROTOCOL.md").read_text()


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
    with pytest.raises(BadInput, match=f"{links} links.*guide"):
        balanced_signs(links)


def test_the_page_has_the_same_signs():
    rows = re.findall(r"^\| (\d+) \| ([+−0 ]+) \| ([−0-9, ]+) \|$", PAGE, re.M)
    assert [int(links) for links, *_ in rows] == [4, 5, 6, 7, 8, 9]
    for links, signs, joints in rows:
        found = balanced_signs(int(links))
        assert ["0+−"[sign] for sign in found] == signs.split()
        told = [int(j.replace("−", "-")) for j in joints.split(",")]
        assert list(joint_multiples(found)) == told
