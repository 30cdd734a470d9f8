"""The least arithmetic of periodic states is counted as its words say."""

from __future__ import annotations

import pytest
from steady_cost import dry_products, viscous_products


def test_the_floors_count_what_they_say() -> None:
    assert viscous_products() == pytest.approx(14_000, rel=0.03)
    assert dry_products() == pytest.approx(19 * 7000, rel=0.1)
