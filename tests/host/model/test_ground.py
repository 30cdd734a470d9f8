"""Ground: pairs of friction forwards and backwards, and one value for both ways."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused


def test_a_pair_is_forwards_then_backwards_and_two_equal_values_are_one() -> None:
    plain, pairs = sn.Ground(0.1, 2.0, 0.3, 0.4), sn.Ground((0.1, 0.1), 2.0, [0.3, 0.3], 0.4)
    assert (pairs, repr(pairs), pairs.ratchet) == (plain, repr(plain), False)
    ground = sn.Ground((0.1, 0.5), 2.0, np.array([0.0, 0.3]))
    assert (ground.ct_forward, ground.ct_backward) == (0.1, 0.5)
    assert repr(ground) == "Ground(ct=(0.1, 0.5), cn=2.0, ft0=(0.0, 0.3), fn0=0.0)"
    assert len({ground, sn.Ground((0.1, 0.5), 2.0, (0.0, 0.3)), plain, pairs}) == 2
    assert (ground.ratchet, ground.dry, ground.smooth) == (True, True, False)


def test_what_is_smooth() -> None:
    assert sn.Ground(0.1, 2.0).smooth
    assert not sn.Ground(0.1, 2.0, 0.0, 0.1).smooth
    kinked = sn.Ground((0.1, 0.2), 2.0)
    assert not kinked.smooth
    assert not kinked.dry


def test_whole_body_and_factors_take_both_ways() -> None:
    whole = sn.Ground.whole_body(4, (0.4, 0.8), 2.0, (0.1, 0.2), 0.4)
    assert whole == sn.Ground((0.1, 0.2), 0.5, (0.025, 0.05), 0.1)
    assert whole.scaled(ct=2.0, ft0=4.0) == sn.Ground((0.2, 0.4), 0.5, (0.1, 0.2), 0.1)
    assert replace(whole, ct=0.3).ct == 0.3


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"ct": (0.1, 0.2, 0.3)}, "two: forwards, backwards"),
        ({"ct": (0.1, -0.2)}, "ct backwards is -0.2"),
        ({"ft0": (math.inf, 0.2)}, "ft0 forwards is inf"),
        ({"ct": ("a", 1.0)}, "ct forwards is 'a'"),
        ({"cn": (0.1, 0.2)}, r"cn is \(0.1, 0.2\)"),
        ({"cn": True}, "cn is True"),
    ],
)
def test_bad_pairs_are_named(given: dict, said: str) -> None:
    with refused(said):
        sn.Ground(**{"ct": 0.1, "cn": 1.0, **given})
